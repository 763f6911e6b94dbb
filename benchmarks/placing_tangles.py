"""Large fills where smoothing tangles: what placing them takes, and what stays flipped.

    OMP_NUM_THREADS=1 python benchmarks/placing_tangles.py [--edges 50,100]

Grids within outlines that swing out and in, stars and spirals, in the plane and on a sheet of
folds, of steep folds, of terraces and of bumps hardly larger than a quad. "angles" is the mean
squared deviation from right angles, in radians squared
(:func:`patterndb.geometry.quadshape.quality`). Seconds are of the processor. Prints Markdown.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator

import numpy as np

from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import sample_polyline
from patterndb.geometry.quadshape import quality
from query.expand import expand_pattern
from query.fill import Fill
from query.placing import Surface, place

Height = Callable[[Points, Points], Points]

#: Points along a side before it is divided.
SAMPLES = 2001

GROUNDS: dict[str, Height | None] = {
    "plane": None,
    "folds": lambda x, y: 0.5 * np.sin(4.0 * x) * np.cos(2.4 * y),
    "steep folds": lambda x, y: 0.9 * np.sin(5.0 * x) * np.cos(3.0 * y),
    "terraces": lambda x, y: 0.3 * np.sign(np.sin(7.0 * x)) * np.abs(np.sin(7.0 * x)) ** 0.3,
    "bumps": lambda x, y: 0.05 * np.sin(40.0 * x) * np.sin(37.0 * y),
}


def sheet(height: Height, n: int = 300) -> Surface:
    """A sheet from -2 to 2 both ways."""
    x, y = np.meshgrid(*[np.linspace(-2.0, 2.0, n + 1)] * 2, indexing="ij")
    k = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([k, k + n + 1, k + n + 2, k + 1], axis=1)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    return Surface.from_arrays(np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3), faces)


def wavy() -> list[Points]:
    """The sides of a square, each swinging out and in twice."""
    t = np.linspace(0.0, 1.0, SAMPLES)
    side = np.stack([2.0 * t - 1.0, -1.0 + 0.25 * np.sin(4.0 * np.pi * t)], axis=1)
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    return [side @ np.linalg.matrix_power(quarter, k) for k in range(4)]


def star() -> list[Points]:
    """A star of seven arms in four parts."""
    sides: list[Points] = []
    for k in range(4):
        t = np.linspace(0.5 * np.pi * k, 0.5 * np.pi * (k + 1), SAMPLES)
        sides.append((1.0 + 0.45 * np.cos(7.0 * t)) * np.stack([np.cos(t), np.sin(t)]))
    return [side.T for side in sides]


def spiral() -> list[Points]:
    """A band that winds 1.6 times."""
    t = np.linspace(0.0, 3.2 * np.pi, SAMPLES)
    way = np.stack([np.cos(t), np.sin(t)])
    outer, inner = ((0.35 + 0.33 * t / np.pi + off) * way for off in (0.25, -0.25))
    across = np.linspace(0.0, 1.0, SAMPLES)
    end = outer[:, -1:] + (inner - outer)[:, -1:] * across
    begin = inner[:, :1] + (outer - inner)[:, :1] * across
    return [side.T for side in (outer, end, inner[:, ::-1], begin)]


def cases(edges: int) -> Iterator[tuple[str, tuple[int, int], list[Points]]]:
    yield "wavy square", (edges, edges), wavy()
    yield "star", (edges, edges), star()
    yield "spiral", (3 * edges, edges // 2), spiral()


def outline(sides: list[Points], counts: tuple[int, ...]) -> Points:
    """(P, 3) points around the outline, at equal arc lengths along each side."""
    parts = [
        sample_polyline(np.c_[side, np.zeros(len(side))], n)[:-1]
        for side, n in zip(sides, counts, strict=True)
    ]
    return np.concatenate(parts)


def grid(columns: int, rows: int) -> Fill:
    square = Pattern.from_code(np.zeros(4, np.uint16))
    fill = expand_pattern(square, (columns, rows))
    return fill if fill.lengths[0] == columns else expand_pattern(square, (rows, columns))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--edges", default="50,100", help="edges of a side, with commas")
    options = parser.parse_args()
    place(grid(8, 8), outline(wavy(), (8, 8, 8, 8)))
    print("| outline | ground | quads | flipped | angles | rounds | s |\n|---|---|" + "---:|" * 5)
    total = 0.0
    for size in options.edges.split(","):
        for ground, height in GROUNDS.items():
            surface = None if height is None else sheet(height)
            for name, (columns, rows), sides in cases(int(size)):
                fill = grid(columns, rows)
                points = outline(sides, (columns, rows, columns, rows))
                if surface is not None and height is not None:
                    points[:, 2] = height(points[:, 0], points[:, 1])
                    points = surface.nearest(points).points
                begun = time.process_time()
                placed = place(fill, points, surface)
                seconds = time.process_time() - begun
                total += seconds
                print(
                    f"| {name} | {ground} | {len(fill.quads):,} | {len(placed.flipped)} | "
                    f"{quality(fill.quads, placed.vertices):.2f} | {placed.rounds} | "
                    f"{seconds:.2f} |",
                    flush=True,
                )
    print(f"\n{total:.1f} s in all.")


if __name__ == "__main__":
    main()
