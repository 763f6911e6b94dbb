"""Rectangle: a grid laid anywhere in a boundary, the construction that never fails."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.system.kernels import kernel
from query.boundary import Boundary


def best_rectangle(boundary: Boundary) -> tuple[int, int, int]:
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
    gained, p, a = best_places(gain[:half] + gain[half:])
    return boundary.n_sides + 4 - int(gained), int(p), int(a)


@kernel
def best_places(gain: NDArray[np.int64]) -> tuple[Index, Index, Index]:
    """(gain, p, a) of the best rectangle.

    gain: (P/2,) what a pair of opposite corners at p and p + P/2 gains.
    """
    half = len(gain)
    order = np.argsort(-gain, kind="mergesort")
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


def rectangle_quads(perimeter: int, p: int, a: int) -> Int32Array:
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
