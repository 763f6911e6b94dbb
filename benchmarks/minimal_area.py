"""How long the triangulation of least area takes, by the number of vertices.

    python benchmarks/minimal_area.py

Noisy loops around a bent disk; medians of 9 runs, after one that does not count. The ratio is
to the smallest loop in the same run: cubic growth would be the last column.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from patterndb_sketch.surfacing.tessellation import minimal_area

VERTICES = (50, 100, 130, 200, 300, 400)
RUNS, SEED = 9, 1


def loop(n: int) -> np.ndarray:
    """A closed polyline (n, 3)."""
    turn = 2.0 * np.pi * np.arange(n) / n
    chance = np.random.default_rng(SEED)
    points = np.stack([np.cos(turn), np.sin(turn), 0.5 * np.sin(3.0 * turn)], axis=1)
    return points + 0.02 * chance.normal(size=(n, 3))


def median(points: np.ndarray) -> float:
    """Milliseconds."""
    minimal_area(points)
    taken: list[float] = []
    for _ in range(RUNS):
        begin = time.perf_counter()
        minimal_area(points)
        taken.append(1e3 * (time.perf_counter() - begin))
    return float(np.median(taken))


def main() -> None:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    print("| vertices | ms | ratio | cubic |\n|---:|---:|---:|---:|")
    smallest = median(loop(VERTICES[0]))
    for n in VERTICES:
        taken = median(loop(n))
        cubic = (n / VERTICES[0]) ** 3
        print(f"| {n} | {taken:.2f} | {taken / smallest:.1f} | {cubic:.1f} |")


if __name__ == "__main__":
    main()
