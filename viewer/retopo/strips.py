"""Strips: the quads one after another that an edge loop runs along, in a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.filling import RetopoMesh


def twins(quads: Int32Array) -> Int32Array:
    """(4 q,) the half-edge on the other side of the same edge, for quads (q, 4); -1 for none.

    Half-edge 4 i + k leads from corner k of quad i to the next. Of an edge with more than two
    quads only two are joined.
    """
    tail, head = quads.ravel().astype(np.int64), np.roll(quads, -1, axis=1).ravel()
    key = (np.minimum(tail, head) << 32) | np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    alike = key[order[1:]] == key[order[:-1]]
    # The first two of a run.
    alike[1:] &= ~alike[:-1]
    found = np.full(len(key), -1, np.int32)
    one, two = order[:-1][alike], order[1:][alike]
    found[one], found[two] = two, one
    return found


def nearest_edge(mesh: RetopoMesh, which: Int32Array, point: ArrayLike) -> int:
    """The half-edge of some quads, (k,) their numbers, whose edge is nearest to a point (3,)."""
    at = np.asarray(point, np.float64)
    corners = mesh.vertices[mesh.quads[which]]
    one, along = corners, np.roll(corners, -1, axis=1) - corners
    size = np.maximum((along**2).sum(axis=2), np.finfo(np.float64).tiny)
    share = np.clip(((at - one) * along).sum(axis=2) / size, 0.0, 1.0)
    away = np.linalg.norm(one + share[..., None] * along - at, axis=2)
    quad, k = divmod(int(away.argmin()), 4)
    return 4 * int(which[quad]) + k


def strip_line(mesh: RetopoMesh, half: int) -> Points:
    """(n, 3) the middles of the edges that the strip of quads through an edge crosses, in order;
    the first again at the end where it comes back to it."""
    twin = twins(mesh.quads)
    onward = _across(twin, half)
    if len(onward) > 1 and onward[-1] == half:
        way = onward
    else:
        back = _across(twin, int(twin[half])) if twin[half] >= 0 else []
        way = back[:0:-1] + onward
    tail, head = mesh.quads.ravel(), np.roll(mesh.quads, -1, axis=1).ravel()
    return 0.5 * (mesh.vertices[tail[way]] + mesh.vertices[head[way]])


def _across(twin: Int32Array, half: int) -> list[int]:
    """Half-edges from one on, each opposite to the one before in the quad that lies there; it ends
    on an open edge, or with the first again."""
    way = [half]
    while True:
        opposite = way[-1] ^ 2
        way.append(int(twin[opposite]) if twin[opposite] >= 0 else opposite)
        # A strip crosses a quad twice at most.
        if twin[opposite] < 0 or way[-1] == half or len(way) > len(twin) // 2:
            return way
