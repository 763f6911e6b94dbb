"""The quads of a mesh, checked, and how they are joined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array, border_vertices, fans
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import InvalidRetopoError


@dataclass(frozen=True, slots=True, eq=False)
class Quads:
    """A manifold mesh of quads, all turned alike; half-edges as in :mod:`patterndb.core.halfedge`.

    points: (v, 3) float64, and quads: (q, 4) int32, as they were given.
    twin:   (4q,) int32, -1 at a border.
    valence: (v,) int32, quads at every vertex; 0 where none is.
    border: (v,) bool, is it on a border?
    """

    points: Points
    quads: Int32Array
    twin: Int32Array
    valence: Int32Array
    border: NDArray[np.bool_]

    @property
    def tail(self) -> Int32Array:
        """(4q,) int32, the vertex that a half-edge leaves."""
        return self.quads.ravel()

    @property
    def irregular(self) -> NDArray[np.bool_]:
        """(v,) bool, vertices whose number of quads is not 4 inside, or 2 on a border.

        Differs from the program of Takayama et al. 2013, which takes a border's vertices of three
        quads for regular: curves would end on the inside of others.
        """
        wanted = np.where(self.border, 2, 4)
        return (self.valence != wanted) & (self.valence > 0)


def quads_of(vertices: ArrayLike, quads: ArrayLike) -> Quads:
    """Check (v, 3) vertices and (q, 4) quads, counter-clockwise seen from outside.

    Raises InvalidRetopoError, which names the face, edge or vertex, for arrays of another shape,
    indices out of range, coordinates that are not finite, quads that repeat a vertex, edges of
    more than two quads or of two that run alike, and vertices where several fans of quads meet.
    """
    points = np.array(vertices, np.float64)
    array = np.asarray(quads)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidRetopoError(f"the mesh's vertices must be (v, 3), got {points.shape}")
    if array.ndim != 2 or array.shape[1] != 4 or not np.issubdtype(array.dtype, np.integer):
        raise InvalidRetopoError(
            f"the mesh's faces must be quads, whole numbers (q, 4), got {array.dtype} "
            f"{array.shape}; triangles and larger faces cannot be imported"
        )
    if not len(array):
        raise InvalidRetopoError("the mesh has no quads; there is nothing to import")
    wrong = np.flatnonzero(((array < 0) | (array >= len(points))).any(axis=1))
    if len(wrong):
        raise InvalidRetopoError(
            f"quad {wrong[0]} {array[wrong[0]].tolist()} names a vertex outside "
            f"0..{len(points) - 1}"
        )
    array = np.ascontiguousarray(array, np.int32)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InvalidRetopoError(f"vertex {bad[0]} of the mesh is not finite")
    ordered = np.sort(array, axis=1)
    again = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(again):
        raise InvalidRetopoError(
            f"quad {again[0]} repeats a vertex: {array[again[0]].tolist()}; it is a triangle, or "
            "less, and cannot be imported"
        )
    twin = _twins(array)
    vertex, n_fans = fans(twin)
    source = np.empty(n_fans, np.int32)
    source[vertex] = array.ravel()
    named, times = np.unique(source, return_counts=True)
    if (times > 1).any():
        shared = named[np.argmax(times > 1)]
        raise InvalidRetopoError(
            f"quads meet at vertex {shared} without an edge between them: it joins several fans; "
            "split it, one vertex to each"
        )
    border = np.zeros(len(points), np.bool_)
    border[source] = border_vertices(twin, vertex, n_fans)
    valence = np.bincount(array.ravel(), minlength=len(points)).astype(np.int32)
    return Quads(points, array, twin, valence, border)


def _twins(quads: Int32Array) -> Int32Array:
    """(4q,) the half-edge on the other side; raises for edges that are none of two quads."""
    tail, head = quads.ravel().astype(np.int64), np.roll(quads, -1, axis=1).ravel().astype(np.int64)
    key = (np.minimum(tail, head) << 32) | np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    ranked = key[order]
    first = np.flatnonzero(np.r_[True, ranked[1:] != ranked[:-1]])
    uses = np.diff(np.r_[first, len(ranked)])
    many = np.flatnonzero(uses > 2)
    if len(many):
        at = order[first[many[0]]]
        raise InvalidRetopoError(
            f"the edge between vertices {tail[at]} and {head[at]} has {uses[many[0]]} quads; at "
            "most two can share one, so split the vertices there"
        )
    twin = np.full(len(key), -1, np.int32)
    one = order[first[uses == 2]]
    two = order[first[uses == 2] + 1]
    alike = np.flatnonzero(tail[one] == tail[two])
    if len(alike):
        a, b = one[alike[0]], two[alike[0]]
        raise InvalidRetopoError(
            f"quads {a // 4} and {b // 4} run alike along the edge between vertices {tail[a]} and "
            f"{head[a]}: one of them is turned over; orient all quads alike"
        )
    twin[one], twin[two] = two, one
    return twin
