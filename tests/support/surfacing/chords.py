"""Cycles that tests of chords look at, and the slow ways to the same answers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)

#: Costs of the slow ways are within this of each other; they are sums of some ten terms.
CLOSE = 1e-9


def ring_network(curves: Sequence[Points]) -> tuple[CurveNetwork, Cycle]:
    """The network of curves that follow each other round one cycle, and the cycle."""
    n = len(curves)
    starts = np.array([curve[0] for curve in curves])
    made = []
    for i, curve in enumerate(curves):
        points = np.array(curve, float)
        points[-1] = starts[(i + 1) % n]
        made.append(Curve(points, (i, (i + 1) % n), i, i))
    return CurveNetwork(tuple(made), starts), Cycle(tuple((i, False) for i in range(n)))


def ring(curves: Sequence[Points], spacing: float | None = None) -> Loop:
    """The loop of curves that follow each other round one cycle."""
    network, cycle = ring_network(curves)
    return loop_of(network, sample(network, spacing), cycle)


def strip(a: Points, b: Points) -> list[Points]:
    """The four sides of the strip between two curves."""
    return [a, np.array([a[-1], b[-1]]), b[::-1], np.array([b[0], a[0]])]


def ribbon() -> list[Points]:
    """A ribbon, twisted by half a turn and as long as four times its width."""
    t = np.linspace(0, 1, 60)
    across = np.c_[0 * t, np.cos(math.pi * t), np.sin(math.pi * t)] / 2
    along = np.c_[4 * t, 0 * t, 0 * t]
    return strip(along + across, along - across)


def helix(turns: float = 1.2, pitch: float = 0.8) -> list[Points]:
    """A strip that winds up around an axis."""
    t = np.linspace(0, 2 * math.pi * turns, round(60 * turns))
    rise = pitch * t / (2 * math.pi)
    return strip(*(np.c_[r * np.cos(t), r * np.sin(t), rise] for r in (1.0, 1.5)))


def bumper() -> list[Points]:
    """A U like the bumper of a car: two arcs with straight ends, one above the other."""
    t = np.linspace(0, math.pi, 40)

    def side(r: float, z: float) -> Points:
        arc = np.c_[2 * r * np.cos(t), r * np.sin(t), 0 * t + z]
        return np.concatenate([[[2 * r, -1, z]], arc, [[-2 * r, -1, z]]])

    return strip(side(1.0, 0.0), side(0.8, 0.5))


def teacup() -> list[Points]:
    """A quarter of a cup between two horizontal arcs and two profiles."""
    t = np.linspace(0, math.pi / 2, 24)
    s = np.linspace(0, 1, 24)

    def arc(r: float, z: float) -> Points:
        return np.c_[r * np.cos(t), r * np.sin(t), 0 * t + z]

    def profile(x: float, y: float) -> Points:
        r = 1 - s**2 / 2
        return np.c_[r * x, r * y, 1 - s]

    return [arc(1, 1), profile(0, 1), arc(0.5, 0)[::-1], profile(1, 0)[::-1]]


def wave(waves: int = 2, height: float = 0.6, n: int = 80) -> list[Points]:
    """A closed curve without a corner: a circle that goes up and down."""
    t = np.linspace(0, 2 * math.pi, n + 1)
    points = np.c_[np.cos(t), np.sin(t), height * np.cos(waves * t)]
    points[-1] = points[0]
    return [points]


SHAPES = {
    "ribbon": ribbon,
    "helix": helix,
    "bumper": bumper,
    "teacup": teacup,
    "wave": wave,
    "three waves": lambda: wave(3, 0.4),
}


def random_loop(rng: np.random.Generator, n: int) -> Points:
    """(n, 3) a closed polyline around an axis, uneven in all directions."""
    t = 2 * math.pi * (np.arange(n) + rng.uniform(0, 0.6, n)) / n
    return (
        np.c_[np.cos(t), np.sin(t), 0 * t] * rng.uniform(0.7, 1.3, (n, 1))
        + np.c_[0 * t, 0 * t, rng.uniform(-0.5, 0.5, n)]
    )


def random_chords(rng: np.random.Generator, n: int, m: int) -> Int64Array:
    """Up to m chords of a loop of n vertices, no two alike, in random order."""
    pairs = [(i, j) for i in range(n) for j in range(i + 2, n) if j - i < n - 1]
    return np.array([pairs[i] for i in rng.permutation(len(pairs))[:m]], np.int64).reshape(-1, 2)


def spread(points: Points) -> float:
    """The root of the determinant of the covariance, by singular values."""
    centred = points - points.mean(axis=0)
    values = np.linalg.svd(centred, compute_uv=False)
    return float(np.prod(values)) / len(points) ** 1.5 if len(points) > 2 else 0.0


def perimeter(points: Points) -> float:
    """The length of a closed polyline."""
    return float(np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1).sum())


def parted(piece: tuple[int, ...], chord: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """The two parts of a piece that the chord cuts."""
    i, j = sorted((piece.index(chord[0]), piece.index(chord[1])))
    return piece[i : j + 1], piece[: i + 1] + piece[j:]


def available(piece: tuple[int, ...], chord: Sequence[int]) -> bool:
    """Are both ends of the chord in the piece, and not one after the other?"""
    if chord[0] not in piece or chord[1] not in piece:
        return False
    apart = abs(piece.index(chord[0]) - piece.index(chord[1]))
    return 1 < apart < len(piece) - 1


def all_costs(
    points: Points, piece: tuple[int, ...], chords: Sequence[tuple[int, int]], alpha: float
) -> Iterator[tuple[float, int]]:
    """Brute force: cost and number of cuts of every way to cut a piece.

    That is every set of chords that do not cross, each in every order of cutting.
    """
    yield spread(points[list(piece)]) / spread(points), 0
    length = perimeter(points[list(piece)])
    for chord in chords:
        if available(piece, chord):
            price = alpha * float(np.linalg.norm(points[chord[0]] - points[chord[1]])) / length
            left, right = parted(piece, chord)
            others = list(all_costs(points, right, chords, alpha))
            for cost, cuts in all_costs(points, left, chords, alpha):
                for more, further in others:
                    yield cost + more + price, cuts + further + 1


class Recursion:
    """Algorithm 1 of the paper in plain Python, with a key that tells sub-cycles apart.

    After the run, ``memo`` has for every sub-problem, keyed by the bits of its vertices and of
    its edges along the loop, its cost, the number of its cuts and its first cut.
    """

    def __init__(self, points: Points, chords: Int64Array, alpha: float) -> None:
        self.points = points
        self.chords = [(int(i), int(j)) for i, j in chords]
        self.alpha = alpha
        self.memo: dict[tuple[int, int], tuple[float, int, int]] = {}
        self.cost, self.cuts, self.first = self.sub(tuple(range(len(points))))

    def key(self, piece: tuple[int, ...]) -> tuple[int, int]:
        n = len(self.points)
        follow = zip(piece, piece[1:] + piece[:1], strict=True)
        return sum(1 << v for v in piece), sum(1 << a for a, b in follow if (b - a) % n == 1)

    def sub(self, piece: tuple[int, ...]) -> tuple[float, int, int]:
        key = self.key(piece)
        if key not in self.memo:
            length = perimeter(self.points[list(piece)])
            best = (spread(self.points[list(piece)]) / spread(self.points), 0, -1)
            for c, (i, j) in enumerate(self.chords):
                if available(piece, (i, j)):
                    left, right = (self.sub(part) for part in parted(piece, (i, j)))
                    price = float(np.linalg.norm(self.points[i] - self.points[j])) / length
                    cost = left[0] + right[0] + self.alpha * price
                    cuts = left[1] + right[1] + 1
                    tied = abs(cost - best[0]) <= 1e-11
                    if cost < best[0] - 1e-11 or (tied and cuts < best[1]):
                        best = (cost, cuts, c)
            self.memo[key] = best
        return self.memo[key]
