"""How long does the search for chords take, on real cycles and on ones sized like the paper's?

    python benchmarks/chord_search.py ../shared/data/curves/cassie/graph
        [--baseline ../shared/prototypes/chords.py]

Finds the cycles of all CASSIE networks and cuts each by chords; then the same with synthetic
strips that have as many sub-problems as the patches of the paper's Table 1, and more. The
baseline is a throw-away program that searches with a hash table; it gets the same candidates, up
to 64 ends, and its cost is compared. Times are the best of some repeats
before. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import CORNER_ANGLE
from patterndb_sketch.surfacing.chords import (
    ALPHA,
    MAX_SUBPROBLEMS,
    Decomposition,
    count_subproblems,
    decompose,
    find_candidates,
    find_endpoints,
    search_cuts,
)
from patterndb_sketch.surfacing.cycles import find_cycles
from patterndb_sketch.surfacing.networkfile import read_network
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)

REPEATS = 5

#: Table 1 of Abbasinejad et al. 2013: sub-problems and seconds of its patches.
PAPER = {
    "teacup, front right": (119, 0.01),
    "roadster, side": (251, 0.02),
    "dolphin, bottom right": (467, 0.19),
    "horse, shoulder": (699, 0.14),
    "dolphin, top left": (930, 0.83),
    "roadster, front": (1_108, 0.14),
    "dolphin, top right": (1_484, 0.47),
    "horse, back": (12_319, 6.5),
}

#: Larger ones, about up to the budget.
LARGER = (24_000, 60_000, 200_000)

#: More ends than this do not go into the baseline's keys.
BASELINE_ENDS = 64


def quickest(call: Callable[[], object], repeats: int = REPEATS) -> float:
    """Seconds of the quickest of some calls."""
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        call()
        times.append(time.perf_counter() - started)
    return min(times)


def real_loops(folder: Path) -> list[Loop]:
    """The loops of all cycles found in the folder's networks."""
    loops: list[Loop] = []
    for path in sorted(folder.glob("*.json")):
        network = read_network(path)
        sampling = sample(network)
        for cycle in find_cycles(network).cycles:
            try:
                loops.append(loop_of(network, sampling, cycle))
            except InvalidNetworkError as error:
                print(f"{path.name}: {error}", file=sys.stderr)
    return loops


def strip(turns: float, pitch: float, n: int) -> Loop:
    """A strip of two times n vertices that winds up around an axis."""
    t = np.linspace(0, 2 * math.pi * turns, n)
    inner, outer = (
        np.c_[r * np.cos(t), r * np.sin(t), pitch * t / (2 * math.pi)] for r in (1.0, 1.5)
    )
    points = np.concatenate([inner, outer[::-1]])
    steps = np.roll(points, -1, axis=0) - points
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    corners = (steps * np.roll(steps, 1, axis=0)).sum(axis=1) < math.cos(CORNER_ANGLE)
    return Loop(points, corners, np.arange(len(points)))


def strips() -> Iterator[tuple[Loop, NDArray[np.int64], int]]:
    """Strips of many sizes, their candidates, and the number of sub-problems."""
    for turns in np.arange(0.4, 4.2, 0.1):
        for pitch in (0.2, 0.5, 0.8, 1.2):
            loop = strip(turns, pitch, 12 + round(20 * turns))
            chords = find_candidates(loop, find_endpoints(loop)).chords
            yield loop, chords, count_subproblems(len(loop.points), chords)


def row(values: NDArray[np.float64], digits: int) -> str:
    """Median, 95th percentile and maximum as cells."""
    figures = (*np.percentile(values, [50, 95]), values.max())
    return " | ".join(f"{figure:,.{digits}f}" for figure in figures)


def of_real_loops(loops: list[Loop]) -> None:
    """Print the table of the cycles found in networks."""
    cut: list[Decomposition] = []
    search: list[float] = []
    whole: list[float] = []
    ends: list[float] = []
    for loop in loops:
        cut.append(decompose(loop))
        chords = cut[-1].candidates
        search.append(quickest(lambda loop=loop, chords=chords: search_cuts(loop.points, chords)))
        whole.append(quickest(lambda loop=loop: decompose(loop)))
        ends.append(quickest(lambda loop=loop: find_candidates(loop, find_endpoints(loop))))
    planar = sum(d.cost == 0 for d in cut)
    print(
        f"{len(loops)} cycles, {planar} of them planar, alpha {ALPHA:g}; "
        f"{sum(d.n_dropped > 0 for d in cut)} exceeded the budget of {MAX_SUBPROBLEMS:,}, "
        f"{sum(d.exhausted for d in cut)} searches were given up; "
        f"{sum(d.n_unmatched for d in cut)} ends have no chord.\n"
    )
    print("| per cycle | median | 95 % | most |\n| --- | ---: | ---: | ---: |")
    print(f"| vertices | {row(np.array([len(x.points) for x in loops], float), 0)} |")
    for name, counts in (
        ("candidates", [len(d.candidates) for d in cut]),
        ("chosen", [len(d.chords) for d in cut]),
        ("sub-problems", [d.n_subproblems for d in cut]),
    ):
        print(f"| {name} | {row(np.array(counts, float), 0)} |")
    for name, seconds in (
        ("ms: the search", search),
        ("ms: ends and candidates", ends),
        ("ms: all together", whole),
    ):
        print(f"| {name} | {row(1e3 * np.array(seconds), 3)} |")


def of_strips(baseline: ModuleType | None) -> None:
    """Print the table of strips sized like the paper's patches."""
    family = list(strips())
    columns = ["strip like", "sub-problems", "ends", "candidates", "chosen", "ms", "ns each"]
    columns += ["paper: sub-problems", "paper: ms"] + ["baseline: ms", "ratio"] * bool(baseline)
    print("\n| " + " | ".join(columns) + " |")
    print("| --- " + "| ---: " * (len(columns) - 1) + "|")
    rows = [(name, count, f"{1e3 * seconds:,.0f}") for name, (count, seconds) in PAPER.items()]
    rows += [("", count, "") for count in LARGER]
    for name, count, paper in rows:
        loop, chords, n = min(family, key=lambda case: abs(math.log(case[2] / count)))
        cuts = search_cuts(loop.points, chords)
        seconds = quickest(lambda loop=loop, chords=chords: search_cuts(loop.points, chords))
        ends = len(np.unique(chords))
        cells = [name, f"{n:,}", ends, len(chords), len(cuts.chosen), f"{1e3 * seconds:.2f}"]
        cells += [f"{1e9 * seconds / n:.0f}", f"{count:,}" if paper else "", paper]
        if baseline is not None and ends <= BASELINE_ENDS:
            cells += against(baseline, loop.points, chords, cuts.cost, seconds)
        elif baseline is not None:
            cells += ["", ""]
        print("| " + " | ".join(map(str, cells)) + " |")


def against(
    baseline: ModuleType, points: Points, chords: NDArray[np.int64], cost: float, seconds: float
) -> list[str]:
    """The baseline's milliseconds, and what share of them ours are.

    Raises AssertionError if it finds another cost.
    """
    spread = math.sqrt(np.linalg.det(np.cov(points.T, bias=True)))

    def run() -> dict[str, float]:
        return baseline.run_nb(points, chords, ALPHA, 1, 1 / spread)

    assert abs(run()["cost"] - cost) < 1e-6
    slower = min(run()["t"] for _ in range(REPEATS))
    return [f"{1e3 * slower:.2f}", f"{seconds / slower:.2f}"]


def module_at(path: Path) -> ModuleType:
    """The program at a path as a module, without a cache: its folder is not ours to write to."""
    module = ModuleType("baseline")
    text = path.read_text(encoding="utf-8").replace("@njit(cache=True)", "@njit")
    exec(compile(text, str(path), "exec"), module.__dict__)
    return module


def main() -> None:
    parser = argparse.ArgumentParser(description="Time the search for chords.")
    parser.add_argument("folder", type=Path, help="CASSIE stroke graphs")
    parser.add_argument("--baseline", type=Path, help="the program to compare with")
    arguments = parser.parse_args()
    decompose(strip(1.0, 0.5, 30))
    of_real_loops(real_loops(arguments.folder))
    of_strips(module_at(arguments.baseline) if arguments.baseline else None)


if __name__ == "__main__":
    main()
