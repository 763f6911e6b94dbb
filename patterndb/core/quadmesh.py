"""A quad mesh: oriented quads, the edges that join them, and one vertex per fan.

Follows the section "Quad mesh" of the pattern definitions (docs/definitions.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.core.halfedge import border_vertices, fans
from patterndb._native.core.quadmesh import components, flip_to_agree
from patterndb.core.halfedge import Int32Array, list_pairs
from patterndb.errors import InvalidMeshError


@dataclass(frozen=True, slots=True, eq=False)
class QuadMesh:
    """Quads joined by half-edges.

    twin:       (4q,) int32, see :mod:`patterndb.core.halfedge`.
    vertex:     (4q,) int32, the vertex of every corner; a vertex is one fan of quads.
    n_vertices: number of vertices.
    source:     (n_vertices,) int32, the index that each vertex had in the quads the
                mesh was built from, so that geometry can be looked up.
    source_quad: (q,) int32, the row that each quad had in them.
    """

    twin: Int32Array
    vertex: Int32Array
    n_vertices: int
    source: Int32Array
    source_quad: Int32Array

    @classmethod
    def from_quads(cls, quads: ArrayLike) -> QuadMesh:
        """Build from (q, 4) vertex indices >= 0, each quad with four distinct ones.

        Quads are flipped, component by component (the component's first quad keeps its
        sense), so that neighbours agree. An edge joins two quads if exactly two use it
        and they traverse it in opposite directions; any other edge is a border edge.

        Raises InvalidMeshError if the array is not (q, 4) or a quad repeats a vertex.
        """
        array = np.asarray(quads)
        if array.size == 0:
            array = array.reshape(0, 4)
        if array.ndim != 2 or array.shape[1] != 4:
            raise InvalidMeshError(f"quads must be (q, 4), got {array.shape}")
        if array.size and (array.min() < 0 or array.max() >= 2**31):
            raise InvalidMeshError("vertex indices must lie in 0..2**31-1")
        array = array.astype(np.int32, copy=True)
        ordered = np.sort(array, axis=1)
        repeats = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
        if len(repeats):
            raise InvalidMeshError(
                f"quad {repeats[0]} repeats a vertex: {array[repeats[0]].tolist()}; "
                "leave such faces out (PolygonMesh.quads does)"
            )
        pairs = _edge_pairs(array)
        flip_to_agree(array, *_neighbours(len(array), pairs))
        return cls.from_twin(_join(array, pairs), array)

    @classmethod
    def from_twin(
        cls,
        twin: Int32Array,
        quads: Int32Array | None = None,
        source_quad: Int32Array | None = None,
    ) -> QuadMesh:
        """Build from half-edges; ``quads`` (q, 4) and ``source_quad`` (q,) are the vertices'
        and quads' names, if they have names other than their numbers."""
        twin = np.ascontiguousarray(twin, dtype=np.int32)
        vertex, n_vertices = fans(twin)
        source = np.arange(n_vertices, dtype=np.int32)
        if quads is not None:
            source[vertex] = quads.ravel()
        if source_quad is None:
            source_quad = np.arange(len(twin) // 4, dtype=np.int32)
        return cls(twin, vertex, n_vertices, source, source_quad)

    @property
    def n_quads(self) -> int:
        return len(self.twin) // 4

    @property
    def quads(self) -> Int32Array:
        """(q, 4) int32 vertices of every quad, counter-clockwise."""
        return self.vertex.reshape(-1, 4)

    def valence(self) -> NDArray[np.int32]:
        """(n_vertices,) int32 number of quads at every vertex."""
        return np.bincount(self.vertex, minlength=self.n_vertices).astype(np.int32)

    def border(self) -> NDArray[np.bool_]:
        """(n_vertices,) bool: is the vertex on a border edge?"""
        return border_vertices(self.twin, self.vertex, self.n_vertices)

    def components(self) -> NDArray[np.int32]:
        """(q,) int32 component of every quad, numbered by their first quads."""
        return components(self.twin)


def _edge_pairs(quads: Int32Array) -> NDArray[np.int64]:
    """(p, 2) int64 half-edges of every edge that exactly two quads use."""
    return list_pairs(quads.ravel(), np.roll(quads, -1, axis=1).ravel())


def _neighbours(
    n_quads: int, pairs: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Adjacency of quads over two-quad edges as (start, half-edge pairs) in CSR form."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.lexsort((both[:, 0],))]
    start = np.searchsorted(both[:, 0] // 4, np.arange(n_quads + 1)).astype(np.int64)
    return start, both


def _join(quads: Int32Array, pairs: NDArray[np.int64]) -> Int32Array:
    """twin of every half-edge of the flipped quads; ``pairs`` as before the flip.

    A flipped quad's old edge e (corners e, e+1) is its new edge 2 - e, so pairs are
    found anew rather than translated.
    """
    twin = np.full(quads.size, -1, np.int32)
    if len(pairs) == 0:
        return twin
    pairs = _edge_pairs(quads)
    a, b = pairs[:, 0], pairs[:, 1]
    flat = quads.ravel()
    ok = (flat[a] != flat[b]) & (a // 4 != b // 4)
    twin[a[ok]] = b[ok]
    twin[b[ok]] = a[ok]
    return twin
