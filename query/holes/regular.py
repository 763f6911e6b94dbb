"""Fills without irregular vertices inside: single quads, grids, L-shapes, staircases, slits.

Such a fill is determined by the number of quads at each loop vertex. The loop walks along the edges
of the square lattice: it turns left at a vertex with one quad, goes straight on at two, turns right
at three and back at four. The walk belongs to a fill if it is closed, turns once in all, and winds
once around every cell inside.
"""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel

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


@kernel
def fill_walk(corners: Int32Array) -> tuple[Int32Array, int]:
    """Kernel of :func:`build_regular_fill`: no vertices where no such fill exists."""
    n = len(corners)
    none = np.empty((0, 4), np.int32)
    if (2 - corners).sum() != 4:
        return none, 0
    x, y, ways = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64), np.zeros(n, np.int64)
    for i in range(n):
        ways[i] = (ways[i - 1] + 2 - corners[i]) & 3 if i else 0
        x[i + 1] = x[i] + (1 if ways[i] == 0 else -1 if ways[i] == 2 else 0)
        y[i + 1] = y[i] + (1 if ways[i] == 1 else -1 if ways[i] == 3 else 0)
    if x[n] or y[n]:
        return none, 0
    x, y = x[:n] - x[:n].min(), y[:n] - y[:n].min()
    width, height = x.max(), y.max()
    # How often the walk winds around each cell: edges to its right that run upwards, less those
    # that run downwards.
    winding = np.zeros((height, width + 1), np.int64)
    for i in range(n):
        if ways[i] == 1:
            winding[y[i], x[i]] += 1
        elif ways[i] == 3:
            winding[y[i] - 1, x[i]] -= 1
    # A lattice point that the walk passes twice, along a slit, is two vertices: so vertices are
    # numbered by the quarters around a point that lie inside.
    number = np.full((height + 1, width + 1, 4), -1, np.int64)
    for i in range(n):
        for k in range(ways[i], ways[i] + corners[i]):
            if number[y[i], x[i], k & 3] >= 0:
                return none, 0
            number[y[i], x[i], k & 3] = i
    on_loop = np.zeros((height + 1, width + 1), np.bool_)
    for i in range(n):
        on_loop[y[i], x[i]] = True
    used = np.zeros((height + 1, width + 1), np.bool_)
    cells = 0
    for b in range(height):
        for a in range(width - 1, -1, -1):
            winding[b, a] += winding[b, a + 1]
            if winding[b, a + 1] < 0 or winding[b, a + 1] > 1:
                return none, 0
            if winding[b, a + 1]:
                cells += 1
                used[b : b + 2, a : a + 2] = True
    count = n
    for b in range(height + 1):
        for a in range(width + 1):
            if used[b, a] and not on_loop[b, a]:
                number[b, a] = count
                count += 1
    quads = np.empty((cells, 4), np.int32)
    at = 0
    for b in range(height):
        for a in range(width):
            if not winding[b, a + 1]:
                continue
            quads[at, 0], quads[at, 1] = number[b, a, 0], number[b, a + 1, 1]
            quads[at, 2], quads[at, 3] = number[b + 1, a + 1, 2], number[b + 1, a, 3]
            at += 1
    if not cells or quads.min() < 0:
        return none, 0
    return quads, count


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
    rest = _tabulate_rest(np.ascontiguousarray(logs))
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


@kernel
def _tabulate_rest(logs: Floats) -> NDArray[np.float32]:
    """[i, x, y, t] the most that vertices i to L - 1, and then 0, earn from a place on, turned by
    t so far, if the walk is to be closed."""
    n = len(logs)
    reach = n // 2
    turns = MOST_RIGHT + MOST_LEFT + 1
    table = np.full((n + 1, n + 1, n + 1, turns), _NEVER, np.float32)
    for t in range(turns):
        quads = 2 - (4 - (t - MOST_RIGHT))
        if 1 <= quads <= 4:
            table[n, reach, reach, t] = logs[0, quads - 1]
    for i in range(n - 1, 0, -1):
        far = min(i, n - i)
        for x in range(reach - far, reach + far + 1):
            for y in range(reach - far, reach + far + 1):
                if abs(x - reach) + abs(y - reach) > far:
                    continue
                for t in range(turns):
                    best = _NEVER
                    for quads in range(1, 5):
                        now = t - MOST_RIGHT + 2 - quads
                        if now < -MOST_RIGHT or now > MOST_LEFT:
                            continue
                        way = now & 3
                        a = x + (1 if way == 0 else -1 if way == 2 else 0)
                        b = y + (1 if way == 1 else -1 if way == 3 else 0)
                        if a < 0 or b < 0 or a > n or b > n:
                            continue
                        ahead = table[i + 1, a, b, now + MOST_RIGHT]
                        if ahead > _NEVER:
                            best = max(best, np.float32(ahead + logs[i, quads - 1]))
                    table[i, x, y, t] = best
    return table
