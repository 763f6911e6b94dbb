"""Which patterns fit a random boundary: milliseconds a query, and beside CP-SAT.

    python benchmarks/feasibility.py --db all.db

Boundaries have N = 3 to 12 sides of 2 to 10 edges and an even perimeter; the class's arrays
are warm. Prints a Markdown table a number of sides: median, 95th percentile and maximum
over the boundaries, with one thread and with two, for any orientation
(``feasible_rows``) and for all 2N (``feasible_orientations``). Then some of the systems
that are not too short for their boundary, chosen at random, are given to CP-SAT one by one: how
many times as long it takes for one as the kernel for one of its own in the same query, and
how often the two answers differ. Last, the flow alone
(:func:`query.solving.halves.find_transport`) beside ``scipy.sparse.csgraph.maximum_flow``, system
by system: why the own kernel is kept.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_flow

import patterndb
from patterndb._native.query.solving.halves import find_transport
from patterndb.core.patternclass import PatternClass
from query import Boundary
from query.orientation import list_orientations
from query.request import PatternFilter
from query.solving import cpsat
from query.solving.feasibility import find_feasible_orientations, find_feasible_rows
from query.solving.systems import Chords

THREADS = (1, 2)

Ask = Callable[..., NDArray[np.generic]]
ASKED: tuple[tuple[str, Ask], ...] = (
    ("any orientation", find_feasible_rows),
    ("every orientation", find_feasible_orientations),
)


def random_boundary(chance: random.Random, n_sides: int, low: int, high: int) -> Boundary:
    """Lengths drawn evenly until their sum is even."""
    while True:
        lengths = [chance.randint(low, high) for _ in range(n_sides)]
        if sum(lengths) % 2 == 0 and sum(lengths) >= 4:
            return Boundary(lengths)


def milliseconds(
    ask: Ask, patterns: PatternClass, boundary: Boundary, rows: NDArray[np.int64], threads: int
) -> float:
    begin = time.perf_counter()
    ask(patterns, boundary, rows, threads=threads)
    return 1000 * (time.perf_counter() - begin)


def long_enough(patterns: PatternClass, rows: NDArray[np.int64], boundary: Boundary) -> int:
    """How many (row, orientation) there are in which no side is too short."""
    n = boundary.n_sides
    lengths = np.array([o.seen(boundary)[0] for o in list_orientations(n)])
    base = patterns.lengths[patterns.signature[rows]]
    # Over all orientations, the order of a signature's sides does not matter.
    return sum(int((base <= asked).all(axis=1).sum()) for asked in lengths)


def beside_cpsat(
    chance: random.Random,
    patterns: PatternClass,
    rows: NDArray[np.int64],
    boundary: Boundary,
    n_systems: int,
) -> tuple[list[float], int]:
    """Milliseconds of CP-SAT for each of some systems, and how often the kernel differs."""
    fit = find_feasible_orientations(patterns, boundary, rows)
    taken: list[float] = []
    differ = 0
    for _ in range(1000 * n_systems):
        if len(taken) == n_systems:
            break
        at = chance.randrange(len(rows))
        which = chance.randrange(fit.shape[1])
        lengths = list_orientations(boundary.n_sides)[which].seen(boundary)[0]
        chords = Chords.from_label(patterns.pattern(int(rows[at])).label)
        if (chords.base_lengths() > lengths).any():
            continue
        begin = time.perf_counter()
        differ += cpsat.is_feasible(chords, lengths) != fit[at, which]
        taken.append(1000 * (time.perf_counter() - begin))
    return taken, differ


def beside_scipy(
    chance: random.Random, patterns: PatternClass, boundary: Boundary, n_systems: int
) -> tuple[float, float, int]:
    """(kernel, scipy) median microseconds for the flow of a system, and how often they differ."""
    n = boundary.n_sides
    lengths = np.array(boundary.lengths, np.int32)
    base = patterns.lengths[patterns.signature]
    fit = patterns.signature[(base <= lengths).all(axis=1)]
    kernel: list[float] = []
    other: list[float] = []
    differ = 0
    for s in chance.choices(fit.tolist(), k=n_systems) if len(fit) else ():
        slack = (lengths - patterns.lengths[s]).astype(np.int32)
        joined = patterns.joins[s] > 0
        i, j = (ends.astype(np.int32) for ends in np.nonzero(np.triu(joined)))
        closed, flow = np.zeros(len(i), np.bool_), np.empty((2, len(i)), np.int32)
        find_transport(slack, i, j, len(i), closed, flow)  # compiles
        begin = time.perf_counter()
        met = find_transport(slack, i, j, len(i), closed, flow)
        kernel.append(time.perf_counter() - begin)
        # From a source to the sides, from these to the copies, from these to a sink.
        a, b = np.nonzero(joined)
        side = np.arange(n)
        tail = np.concatenate([np.full(n, 2 * n), a, n + side])
        head = np.concatenate([side, n + b, np.full(n, 2 * n + 1)])
        begin = time.perf_counter()
        whole = int(slack.sum())
        capacity = np.concatenate([slack, np.full(len(a), whole, np.int32), slack])
        graph = csr_array((capacity, (tail, head)), shape=(2 * n + 2, 2 * n + 2))
        found = maximum_flow(graph, 2 * n, 2 * n + 1).flow_value == whole
        other.append(time.perf_counter() - begin)
        differ += bool(found != met)
    if not kernel:
        return 0.0, 0.0, 0
    return 1e6 * statistics.median(kernel), 1e6 * statistics.median(other), differ


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, help="default: the starter database")
    parser.add_argument("--boundaries", type=int, default=100, help="for each number of sides")
    parser.add_argument("--systems", type=int, default=20, help="for CP-SAT, for each N")
    parser.add_argument("--sides", type=int, nargs="+", default=tuple(range(3, 13)))
    parser.add_argument("--lengths", type=int, nargs=2, default=(2, 10))
    parser.add_argument("--flows", type=int, default=200, help="for scipy, for each N")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    print(
        "| N | candidates | fit, median | asked | "
        + " | ".join(f"{t} thread{'s' * (t > 1)}: median, p95, max ms" for t in THREADS)
        + " | CP-SAT / kernel per system | answers that differ |"
    )
    print("| ---: | ---: | ---: | --- " + "| ---: " * (len(THREADS) + 2) + "|")
    flows: list[tuple[int, float, float, int]] = []
    with patterndb.open(arguments.db) as database:
        for n in arguments.sides:
            patterns = database.pattern_class(n)
            asked = [
                random_boundary(chance, n, *arguments.lengths) for _ in range(arguments.boundaries)
            ]
            rows = PatternFilter().choose_rows(patterns, asked[0])
            fitting = [len(find_feasible_rows(patterns, b, rows)) for b in asked]
            for name, ask in ASKED:
                ask(patterns, asked[0], rows)  # compiles
                times = {
                    t: [milliseconds(ask, patterns, b, rows, t) for b in asked] for t in THREADS
                }
                cells = [
                    f"{statistics.median(ms):.1f}, {np.percentile(ms, 95):.1f}, {max(ms):.1f}"
                    for ms in times.values()
                ]
                ratio, differ = "", ""
                if ask is find_feasible_orientations and arguments.systems:
                    one = times[1][0] / max(long_enough(patterns, rows, asked[0]), 1)
                    taken, wrong = beside_cpsat(chance, patterns, rows, asked[0], arguments.systems)
                    ratio = f"{statistics.median(taken) / one:,.0f}" if taken else "none"
                    differ = f"{wrong} of {len(taken)}"
                print(
                    f"| {n} | {len(rows):,} | {statistics.median(fitting):,.0f} | {name} | "
                    f"{' | '.join(cells)} | {ratio} | {differ} |",
                    flush=True,
                )
            flows.append((n, *beside_scipy(chance, patterns, asked[0], arguments.flows)))
    print("\n| N | flow by the kernel, us | by scipy, us | answers that differ |")
    print("| ---: | ---: | ---: | ---: |")
    for n, mine, scipys, differ in flows:
        print(f"| {n} | {mine:.1f} | {scipys:.1f} | {differ} |")


if __name__ == "__main__":
    main()
