"""Which corners of a boundary to keep, where a table knows only fills with fewer sides."""

from __future__ import annotations

import random
from bisect import bisect_left
from collections.abc import Iterator

from query.boundary import Boundary

#: Random choices of corners that follow the even ones.
RANDOM_CHOICES = 100

#: Few enough sides that corners are worth dropping down to.
FEWEST_KEPT = 4


def choices(boundary: Boundary, most: int) -> Iterator[tuple[int, ...]]:
    """Corners to keep, as ascending numbers; at most ``most`` of them, most corners first.

    First those nearest to equally spaced points, one choice for every corner to start from;
    where there are reflex corners, also among the convex ones alone. Then random ones, the
    same for the same boundary. No choice comes twice, and none keeps all corners.
    """
    n = boundary.n_sides
    corners = list(range(n))
    convex = [i for i in corners if boundary.corners[i] == "convex"]
    pools = [corners] if boundary.convex else [corners, convex]
    seen: set[tuple[int, ...]] = set()
    # Two kept corners are the least that the table is asked about.
    fewest = min(FEWEST_KEPT, max(2, n - 1))
    sizes = range(min(most, n - 1), fewest - 1, -1)
    for size in sizes:
        for pool in pools:
            if len(pool) < size:
                continue
            if len(pool) == size < n:
                evenly: Iterator[tuple[int, ...]] = iter([tuple(pool)])
            else:
                evenly = (evenly_spaced(boundary, pool, start, size) for start in range(len(pool)))
            for choice in evenly:
                if len(choice) == size and choice not in seen:
                    seen.add(choice)
                    yield choice
    chance = random.Random(repr((boundary.lengths, boundary.corners)))
    for _ in range(RANDOM_CHOICES if len(sizes) else 0):
        pool = chance.choice(pools)
        size = min(chance.choice(sizes), len(pool))
        choice = tuple(sorted(chance.sample(pool, size)))
        if 2 <= len(choice) < n and choice not in seen:
            seen.add(choice)
            yield choice


def evenly_spaced(boundary: Boundary, pool: list[int], start: int, size: int) -> tuple[int, ...]:
    """The corners of the pool nearest to ``size`` equally spaced points, the first of them
    corner pool[start]; fewer than ``size`` where two points have the same nearest one."""
    starts = boundary.side_starts
    perimeter = boundary.perimeter
    turned = pool[start:] + pool[:start]
    places = [(starts[i] - starts[turned[0]]) % perimeter for i in turned]
    near: set[int] = set()
    for k in range(size):
        aim = k * perimeter / size
        at = bisect_left(places, aim)
        options = [i for i in (at - 1, at) if 0 <= i < len(places)]
        near.add(turned[min(options, key=lambda i: abs(places[i] - aim))])
    return tuple(sorted(near))
