"""Fills without irregular vertices inside: single quads, grids, L-shapes, staircases, slits.

Such a fill is determined by the number of quads at each loop vertex. The loop walks along the edges
of the square lattice: it turns left at a vertex with one quad, goes straight on at two, turns right
at three and back at four. The walk belongs to a fill if it is closed, turns once in all, and winds
once around every cell inside.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from patterndb._native.query.holes.regular import fill_walk, pave, tabulate_rest
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

#: Edges up to which the closed walks of a loop are searched: the table of what they can still earn
#: has (L + 1)^3 * 17 numbers, 19 MB at 64 edges.
MOST_EDGES = 64

#: How far a walk may have turned in between, in quarters to the right and to the left.
MOST_RIGHT, MOST_LEFT = 6, 10

#: What walks earn that cannot be closed.
_NEVER = np.float32(-1e18)

#: One step on the lattice in each direction.
_STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def build_regular_fill(corners: Int32Array) -> tuple[Int32Array, int] | None:
    """Return the fill that has no irregular vertex inside and these quads at each loop vertex.

    corners: (L,) 1 to 4. Returns quads (q, 4) int32, loop vertices 0..L-1, inner ones after, and
    how many vertices; None where there is none.
    """
    quads, n_vertices = fill_walk(np.ascontiguousarray(corners, np.int32))
    return (quads, n_vertices) if n_vertices else None


def list_rectangles(logs: Floats, most: int) -> list[Int32Array]:
    """List the likeliest corners (L,) of rectangles whose boundary is the loop, at most ``most``.

    logs: (L, 4) log probabilities of 1 to 4 quads at each vertex.
    """
    n = len(logs)
    half = n // 2
    if n % 2 or half < 2:
        return []
    gain = logs[:, 0] - logs[:, 1]
    both = gain[:half] + gain[half:]  # a corner and the one opposite
    first, second = np.triu_indices(half, 1)
    found: list[Int32Array] = []
    for i in np.argsort(-(both[first] + both[second]), kind="stable")[:most].tolist():
        corners = np.full(n, 2, np.int32)
        for corner in (first[i], second[i]):
            corners[corner] = corners[corner + half] = 1
        found.append(corners)
    return found


def list_closed_walks(logs: Floats, most: int, steps: int) -> list[Int32Array]:
    """List the most probable corners (L,) of which the loop is a closed walk that turns once.

    logs: (L, 4) log probabilities of 1 to 4 quads at each vertex, which are taken as independent.
    steps: of the search, at most. Most probable first, and exactly so: what the rest of the loop
    can still earn is tabulated by vertex, place and turning. Walks may wind around a cell twice:
    then :func:`build_regular_fill` returns None.
    """
    n = len(logs)
    if n % 2 or not 4 <= n <= MOST_EDGES:
        return []
    rest = tabulate_rest(np.ascontiguousarray(logs))
    reach = n // 2
    gains = logs.tolist()
    found: list[Int32Array] = []
    # Edge 0 runs to the right, from vertex 0 to vertex 1; the turn at vertex 0 comes last.
    first = (-float(rest[1, reach + 1, reach, MOST_RIGHT]), 0, 0.0, reach + 1, reach, 0, ())
    heap: list[tuple[float, int, float, int, int, int, tuple[int, ...]]] = [first]
    serial = 0
    for _ in range(steps):
        if not heap or len(found) >= most:
            break
        _, _, earned, x, y, turned, chosen = heapq.heappop(heap)
        vertex = len(chosen) + 1
        if vertex > n:
            found.append(np.array((chosen[-1], *chosen[:-1]), np.int32))
            continue
        for quads in range(1, 5):
            now = turned + 2 - quads
            if not -MOST_RIGHT <= now <= MOST_LEFT:
                continue
            total = earned + gains[vertex % n][quads - 1]
            a, b = x, y
            if vertex < n:
                a, b = x + _STEPS[now & 3][0], y + _STEPS[now & 3][1]
                if not (0 <= a <= n and 0 <= b <= n):
                    continue
                ahead = float(rest[vertex + 1, a, b, now + MOST_RIGHT])
                if ahead <= _NEVER:
                    continue
            elif now == 4:
                ahead = 0.0
            else:
                continue
            serial += 1
            heapq.heappush(heap, (-total - ahead, serial, total, a, b, now, (*chosen, quads)))
    return found


#: Part of artists' vertices at which c quads of the ring and 1 to 4 quads within it meet, by c = 1
#: to 6 (rows): measured behind the rims of 4,513 holes that scripts/cut_holes.py cut into 40 of the
#: meshes that scripts/train_holes.py learns from; what was not met counts as .001.
WITHIN = np.array(
    [
        [0.001, 0.624, 0.353, 0.022],
        [0.127, 0.858, 0.013, 0.002],
        [0.917, 0.071, 0.011, 0.001],
        [0.648, 0.349, 0.002, 0.001],
        [0.864, 0.134, 0.001, 0.001],
        [0.863, 0.135, 0.001, 0.001],
    ]
)

#: More rings than any loop has room for.
_ALL = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class QuadRing:
    """The quads that touch a loop, and the loop that they leave.

    quads: (q, 4) int32, loop vertices 0..L-1, others from L on. inner: (m,) int32 the vertices of
    the loop that is left, in order; none where the ring fills the loop. counts: (m,) int32 quads of
    the ring at each. n_vertices: of loop and ring.
    """

    quads: Int32Array
    inner: Int32Array
    counts: Int32Array
    n_vertices: int

    def log_within(self) -> Floats:
        """(m, 4) log of the part of vertices that get 1 to 4 quads within."""
        return np.log(WITHIN[np.minimum(self.counts, len(WITHIN)) - 1])

    def join(self, quads: Int32Array) -> Int32Array:
        """(q, 4) the ring's quads, and those of a fill of the loop that is left, in its numbers."""
        m = len(self.inner)
        far = np.arange(max(int(quads.max()) + 1, m))
        names = np.where(far < m, self.inner[np.minimum(far, m - 1)], far - m + self.n_vertices)
        return np.concatenate([self.quads, names[quads]]).astype(np.int32)


def lay_ring(corners: Int32Array) -> QuadRing | None:
    """Return the ring of the quads at each vertex of a loop, none of which are joined needlessly.

    corners: (L,) 1 to 4, L even. None where there is no such ring.
    """
    quads, inner, counts, n_vertices = pave(np.ascontiguousarray(corners, np.int32), 1)
    return QuadRing(quads, inner, counts, n_vertices) if n_vertices else None


def pave_loop(corners: Int32Array) -> tuple[Int32Array, int] | None:
    """Return the fill of rings that has these quads at each loop vertex: quads (q, 4) int32, loop
    vertices 0..L-1, inner ones after, and how many vertices; None where paving does not end.

    corners: (L,) 1 to 4, L even. Most fills with one irregular vertex inside are found so.
    """
    quads, inner, _, n_vertices = pave(np.ascontiguousarray(corners, np.int32), _ALL)
    return (quads, n_vertices) if n_vertices and not len(inner) else None
