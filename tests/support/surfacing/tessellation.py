"""Closed polylines to fill, and what every filled one must be."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.sampling import Loop


def turned(points: Points, seed: int) -> Points:
    """The points after a random rigid motion."""
    chance = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(chance.normal(size=(3, 3)))
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    return points @ turn.T + chance.normal(size=3)


def wobbly(n: int, seed: int, noise: float) -> Points:
    """A closed polyline (n, 3) around a bent lobed disk, with noise."""
    chance = np.random.default_rng(seed)
    angles = np.sort(chance.uniform(0.0, 2.0 * np.pi, n))
    radius = 1.0 + 0.4 * chance.uniform() * np.sin(3.0 * angles + chance.uniform(0.0, 6.0))
    bend = chance.uniform(0.0, 0.8) * np.cos(2.0 * angles)
    points = np.stack([radius * np.cos(angles), radius * np.sin(angles), bend], axis=1)
    return turned(points + noise * chance.normal(size=(n, 3)), seed)


def as_loop(points: Points) -> Loop:
    return Loop(points, np.zeros(len(points), bool), np.arange(len(points)))


def chorded(n: int, wanted: int, seed: int) -> tuple[list[tuple[int, int]], list[list[int]]]:
    """Random chords of a loop of n vertices that do not cross, and the pieces between them."""
    chance = np.random.default_rng(seed)
    chords: list[tuple[int, int]] = []
    pieces = [list(range(n))]
    for _ in range(wanted):
        number = int(chance.integers(len(pieces)))
        piece = pieces[number]
        i, j = sorted(int(k) for k in chance.choice(len(piece), 2, replace=False))
        a, b = piece[i], piece[j]
        if (a - b) % n in (1, n - 1) or (a, b) in chords or (b, a) in chords:
            continue
        chords.append((a, b))
        pieces[number : number + 1] = [piece[i : j + 1], piece[j:] + piece[: i + 1]]
    return chords, pieces


def check_disk(triangles: NDArray[np.int64], around: list[int]) -> None:
    """One disk whose boundary is ``around``, in this order; triangles all turn that way."""
    sides = [(int(t[e]), int(t[(e + 1) % 3])) for t in triangles.tolist() for e in range(3)]
    assert max(Counter(sides).values()) == 1, "two triangles turn the same way on one edge"
    all_sides = set(sides)
    single = {(a, b) for a, b in sides if (b, a) not in all_sides}
    assert single == set(zip(around, around[1:] + around[:1], strict=True))
    edges = {(min(side), max(side)) for side in sides}
    vertices = {v for side in sides for v in side}
    assert len(vertices) - len(edges) + len(triangles) == 1
    # One boundary and an Euler sum of 1 leave one disk, if it is in one part.
    reached, beside = {int(triangles[0, 0])}, {v: set[int]() for v in vertices}
    for a, b in edges:
        beside[a].add(b)
        beside[b].add(a)
    front = list(reached)
    while front:
        for v in beside[front.pop()] - reached:
            reached.add(v)
            front.append(v)
    assert reached == vertices
