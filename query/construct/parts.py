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

from patterndb._native.query.construct.parts import find_best_places
from patterndb._native.query.expand import expand_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from query.boundary import Boundary


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
