"""A teacup drawn as curves in space: a network to surface, in the order of its strokes.

Two silhouettes, rim, waist and foot, which meet where they cross, and the outline of a handle,
which touches nothing. Centimetres.
"""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

#: Radius of the cup at heights, from the foot to the rim.
PROFILE = ((0.0, 2.0), (0.4, 2.5), (1.2, 3.3), (2.4, 4.0), (3.8, 4.4), (5.2, 4.6), (6.0, 4.8))

#: Points between neighbouring entries of the profile, and around a quarter of a ring.
FINENESS = 4
QUARTER = 10

WAIST = 2.4
HEIGHT = 6.0

#: Width of the handle, and how far its ends stay away from the wall.
WIDTH = 1.2
GAP = 0.15

Point = tuple[float, float, float]


def radius(z: float) -> float:
    """The cup's radius at height z, a smooth curve through PROFILE (Catmull and Rom)."""
    at = max(i for i in range(len(PROFILE) - 1) if PROFILE[i][0] <= z)
    (z1, r1), (z2, r2) = PROFILE[at], PROFILE[at + 1]
    z0, r0 = PROFILE[at - 1] if at else (2 * z1 - z2, 2 * r1 - r2)
    z3, r3 = PROFILE[at + 2] if at + 2 < len(PROFILE) else (2 * z2 - z1, 2 * r2 - r1)
    t = (z - z1) / (z2 - z1)
    a = (r2 - r0) * (z2 - z1) / (z2 - z0)
    b = (r3 - r1) * (z2 - z1) / (z3 - z1)
    return (
        (2 * t**3 - 3 * t**2 + 1) * r1
        + (t**3 - 2 * t**2 + t) * a
        + (3 * t**2 - 2 * t**3) * r2
        + (t**3 - t**2) * b
    )


def on_cup(turn: float, z: float) -> Point:
    """The point of the cup at an angle in radians and a height."""
    r = radius(z)
    return (r * math.cos(turn), r * math.sin(turn), z)


def ring(z: float) -> list[Point]:
    """The horizontal circle at a height, closed."""
    turns = [2 * math.pi * i / (4 * QUARTER) for i in range(4 * QUARTER)]
    points = [on_cup(turn, z) for turn in turns]
    return [*points, points[0]]


def silhouette(turn: float) -> list[Point]:
    """From rim to rim over the foot: down on one side, across, up on the other."""
    heights = sorted(
        z1 + (z2 - z1) * i / FINENESS
        for (z1, _), (z2, _) in pairwise(PROFILE)
        for i in range(FINENESS)
    )
    side = [on_cup(turn, z) for z in [*heights, HEIGHT]]
    other = [on_cup(turn + math.pi, z) for z in [*heights, HEIGHT]]
    return [*reversed(side), (0.0, 0.0, 0.0), *other]


def handle() -> list[Point]:
    """The outline of a band along a C, from below the rim to the waist, closed."""
    upper, lower = radius(5.2) + GAP, radius(WAIST) + GAP
    middle, half = (5.2 + WAIST) / 2, (5.2 - WAIST) / 2
    n = 24
    edge: list[tuple[float, float]] = []
    for i in range(n + 1):
        t = math.pi * i / n
        x = upper + (lower - upper) * i / n + 2.8 * math.sin(t) ** 0.8
        edge.append((x, middle + half * math.cos(t)))
    left = [(x, WIDTH / 2, z) for x, z in edge]
    right = [(x, -WIDTH / 2, z) for x, z in reversed(edge)]
    return [*left, *right, left[0]]


def strokes() -> dict[str, list[Point]]:
    """The strokes by name, in the order of drawing."""
    return {
        "front": silhouette(math.pi / 2),
        "side": silhouette(0.0),
        "rim": ring(HEIGHT),
        "foot": ring(0.0),
        "waist": ring(WAIST),
        "handle": handle(),
    }


def write(path: Path) -> int:
    """Write the network as JSON, the second axis up; returns the number of strokes."""
    curves = [
        {"id": name, "points": [[round(c, 4) for c in (x, z, -y)] for x, y, z in points]}
        for name, points in strokes().items()
    ]
    document = {"curves": curves, "tolerance": 0.02, "stages": [[name] for name in strokes()]}
    path.write_text(json.dumps(document, separators=(",", ":")) + "\n", encoding="ascii")
    return len(curves)


if __name__ == "__main__":
    write(Path(__file__).resolve().parent / "networks" / "teacup.json")
