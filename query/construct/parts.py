"""The parts that need no table: a pentagon and a rectangle, and where an outline has room for them.

The pentagon has one interior vertex, of valence 5; straight lines from it meet every side. Side k
is x_k + x_{k+2} edges long, x_k of them before the line that meets it, so
x_k = S/2 - L_{k+1} - L_{k+2} with S the perimeter: the pentagon exists exactly if S is even and any
two sides next to each other are shorter than half of it.

The rectangle is a grid laid anywhere in a boundary: the construction that never fails.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.system.kernels import kernel
from query.boundary import Boundary
from query.expand import expand_quads

#: Positions tried along a side; longer sides are tried in larger steps.
MOST_STEPS = 24


@lru_cache(maxsize=1024)
def make_pentagon(lengths: tuple[int, int, int, int, int]) -> Int32Array:
    """(q, 4) int32 quads of the pentagon; boundary vertices first, 0 where side 0 begins.

    lengths: edges of the sides, for which the pentagon must exist. Plans of one boundary have
    pentagons in common: the array is kept, and not to be written to.
    """
    twin, chord, before = _pattern()
    half = sum(lengths) // 2
    widths = np.empty(5, np.int32)
    for k in range(5):
        widths[before[k]] = half - lengths[(k + 1) % 5] - lengths[(k + 2) % 5]
    quads = expand_quads(twin, widths[chord], 2 * half, 0, False)[0]
    quads.flags.writeable = False
    return quads


@cache
def _pattern() -> tuple[Int32Array, Int32Array, list[int]]:
    """(half-edges, polychord across each, first polychord of every side) of five quads
    around a vertex."""
    quads = [[k, 5 + k, 10, 5 + (k + 4) % 5] for k in range(5)]
    pattern = Pattern.from_disk(QuadMesh.from_quads(quads).twin)
    return pattern.twin(), pattern.polychords().of_edge, [side[0] for side in pattern.label]


@kernel
def is_pentagon(s0: int, s1: int, s2: int, s3: int, s4: int) -> bool:
    """Is there a pentagon of one valence-5 vertex with these sides?"""
    total = s0 + s1 + s2 + s3 + s4
    longest = max(s0 + s1, s1 + s2, s2 + s3, s3 + s4, s4 + s0)
    return total % 2 == 0 and 2 * longest < total


@kernel
def find_pentagon_cuts(
    lengths: NDArray[np.int64], counts: NDArray[np.int64], ample: int
) -> NDArray[np.int64]:
    """The best cut at every side, (k, 4) int64, best first.

    lengths, counts: (n,) edges of the sides and quads at the corners of an outline, n >= 5.
    A cut (side i, u, w, c) takes off the pentagon of u edges of side i, sides i + 1 and
    i + 2, w edges of side i + 3 and a chord of c edges. The three corners between must be
    convex, and at least 2 edges be left of both sides. The best cut leaves the longest
    shortest side, where sides of more than ``ample`` edges count as that long, then has the
    shortest chord: long ones add up from cut to cut, until one side is more than half of
    what is left. Then it leaves more of the sides it cuts, and has u near w.
    """
    n = len(lengths)
    cuts = np.empty((n, 4), np.int64)
    score = np.empty(n)
    found = 0
    for i in range(n):
        convex = True
        shortest = 1 << 30
        for k in range(1, n):
            if k <= 3:
                convex = convex and counts[(i + k) % n] == 1
            else:
                shortest = min(shortest, lengths[(i + k) % n])
        if not convex:
            continue
        value, u, w, c = _best_cut(
            lengths[i],
            lengths[(i + 1) % n],
            lengths[(i + 2) % n],
            lengths[(i + 3) % n],
            shortest,
            ample,
        )
        if u == 0:
            continue
        at = found
        while at > 0 and score[at - 1] < value:
            score[at] = score[at - 1]
            cuts[at] = cuts[at - 1]
            at -= 1
        score[at] = value
        cuts[at, 0] = i
        cuts[at, 1] = u
        cuts[at, 2] = w
        cuts[at, 3] = c
        found += 1
    return cuts[:found].copy()


@kernel
def _best_cut(
    before: int, b: int, c: int, after: int, shortest: int, ample: int
) -> tuple[float, int, int, int]:
    """(score, u, w, chord) of the best cut over sides b and c; u = 0 if there is none.

    shortest: of the sides that the cut does not touch.
    """
    best = -np.inf
    best_u = best_w = best_e = 0
    step = max(1, before // MOST_STEPS)
    for u in range(2, before - 1, step):
        for w in range(max(2, u - 2 * step), min(after - 2, u + 2 * step) + 1):
            # The shortest chord that the pentagon's conditions and parity allow.
            e = max(2, b + c - u - w + 2, abs(u + b - c - w) + 2)
            e += (e + u + b + c + w) % 2
            if not is_pentagon(u, b, c, w, e):
                continue
            made = min(before - u, after - w, e)
            value = min(made, shortest, ample) * 1e6 - 1e2 * e + made - 0.5 * abs(u - w)
            if value > best:
                best = value
                best_u, best_w, best_e = u, w, e
    return best, best_u, best_w, best_e


def find_best_rectangle(boundary: Boundary) -> tuple[int, int, int]:
    """The rectangle with fewest irregular vertices: (irregular, p, a).

    Its corners fall on the boundary vertices p, p + a, p + P/2 and p + P/2 + a. Among equals
    the nearest to a square. There is always one.
    """
    gain = np.zeros(boundary.perimeter, np.int64)
    if boundary.n_sides:
        # A grid's corner makes a convex corner regular; at a reflex one it only falls on a
        # vertex that is irregular anyway.
        counts = np.array(boundary.corner_counts)
        gain[list(boundary.side_starts[:-1])] = np.where(counts == 1, 2, 1)
    half = boundary.perimeter // 2
    gained, p, a = find_best_places(gain[:half] + gain[half:])
    return boundary.n_sides + 4 - int(gained), int(p), int(a)


@kernel
def find_best_places(gain: NDArray[np.int64]) -> tuple[Index, Index, Index]:
    """(gain, p, a) of the best rectangle.

    gain: (P/2,) what a pair of opposite corners at p and p + P/2 gains.
    """
    half = len(gain)
    # Descending, the first of equal ones first.
    order = np.empty(half, np.int32)
    for i in range(half):
        j = i
        while j > 0 and gain[order[j - 1]] < gain[i]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = i
    best: tuple[Index, Index, Index] = (-1, 0, 0)
    for i in range(half - 1):
        x = order[i]
        if gain[x] + gain[order[i + 1]] < best[0]:
            break
        for j in range(i + 1, half):
            y = order[j]
            both = gain[x] + gain[y]
            if both < best[0]:
                break
            a = abs(y - x)
            if both > best[0] or abs(2 * a - half) < abs(2 * best[2] - half):
                best = (both, min(x, y), a)
    return best


def make_rectangle(perimeter: int, p: int, a: int) -> Int32Array:
    """(q, 4) int32 quads of the grid with corners p, p + a, p + P/2 and p + P/2 + a.

    Boundary vertices are 0..perimeter - 1, interior ones follow.
    """
    b = perimeter // 2 - a
    grid = np.empty((b + 1, a + 1), np.int32)
    grid[0] = np.arange(a + 1)
    grid[:, a] = a + np.arange(b + 1)
    grid[b, ::-1] = a + b + np.arange(a + 1)
    grid[::-1, 0] = (2 * a + b + np.arange(b + 1)) % perimeter
    grid = np.where(grid < perimeter, (grid + p) % perimeter, grid).astype(np.int32)
    grid[1:b, 1:a] = perimeter + np.arange((a - 1) * (b - 1)).reshape(b - 1, a - 1)
    corners = (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
    return np.stack([c.ravel() for c in corners], axis=1)
