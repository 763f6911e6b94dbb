"""Which patterns fit a random boundary: milliseconds a query, and beside CP-SAT.

    python benchmarks/feasibility.py --db all.db

Boundaries have N = 3 to 12 sides of 2 to 10 edges and an even perimeter; the class's arrays
are warm. Prints a Markdown table a number of sides: median, 95th percentile and maximum
over the boundaries, with one thread and with two, for any orientation (``is_feasible`` of
:class:`query.solving.widths.WidthSolver`) and for all (``find_feasible``). Then some of the systems
that are not too short for their boundary, chosen at random, are given to CP-SAT one by one: how
many times as long it takes for one as the kernel for one of its own in the same query, and
how often the two answers differ. Last, a matching decided
(rust/query/src/solving/matching.rs) beside ``scipy.sparse.csgraph.maximum_flow``, which decides
only whether there is one with halves: why the own kernel is kept.
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
from patterndb._native.query.solving.systems import decide_matching
from patterndb.core.label import split_word
from patterndb.core.patternclass import PatternClass
from query import Boundary
from query.listing.table import StrictTable, TableEntries, get_strict_table
from query.solving.problem import build_width_problem
from query.solving.systems import systems_of
from query.solving.widths import WidthSolver

THREADS = (1, 2)

Ask = Callable[..., NDArray[np.bool_]]
ASKED: tuple[tuple[str, Ask], ...] = (
    ("any orientation", WidthSolver.is_feasible),
    ("every orientation", WidthSolver.find_feasible),
)


def random_boundary(chance: random.Random, n_sides: int, low: int, high: int) -> Boundary:
    """Lengths drawn evenly until their sum is even."""
    while True:
        lengths = [chance.randint(low, high) for _ in range(n_sides)]
        if sum(lengths) % 2 == 0 and sum(lengths) >= 4:
            return Boundary(lengths)


def milliseconds(
    ask: Ask, table: StrictTable, boundary: Boundary, entries: TableEntries, threads: int
) -> float:
    begin = time.perf_counter()
    solver = WidthSolver(build_width_problem(boundary), threads=threads)
    ask(solver, table, entries.row, entries.packed)
    return 1000 * (time.perf_counter() - begin)


def long_enough(table: StrictTable, entries: TableEntries, boundary: Boundary) -> int:
    """How many (row, allowed orientation) there are in which no side is too short."""
    allowed = np.unpackbits(entries.packed, axis=1, count=entries.n_orientations).view(np.bool_)
    return int((allowed & _list_long_enough(table, entries, boundary)).sum())


def _list_long_enough(
    table: StrictTable, entries: TableEntries, boundary: Boundary
) -> NDArray[np.bool_]:
    """(e, o) bool: is no side too short?"""
    patterns, n = table.patterns, boundary.n_sides
    lengths = build_width_problem(boundary).lengths
    found = np.empty((len(entries), len(lengths)), np.bool_)
    for at, row in enumerate(entries.row.tolist()):
        word = patterns.words[patterns.word_start[row] : patterns.word_start[row + 1]]
        base = [len(side) for side in split_word(word, n)]
        found[at] = (np.array(base) <= lengths).all(axis=1)
    return found


def beside_cpsat(
    chance: random.Random,
    table: StrictTable,
    entries: TableEntries,
    boundary: Boundary,
    n_systems: int,
) -> tuple[list[float], int]:
    """Milliseconds of CP-SAT for each of some systems, and how often the kernel differs."""
    problem = build_width_problem(boundary)
    asked = table, entries.row, entries.packed
    fit = WidthSolver(problem).find_feasible(*asked)
    places = np.argwhere(
        _list_long_enough(table, entries, boundary)
        & np.unpackbits(entries.packed, axis=1, count=entries.n_orientations).view(np.bool_)
    ).tolist()
    cpsat = WidthSolver(problem, threads=1, by_cpsat=True)
    taken: list[float] = []
    differ = 0
    for at, which in chance.sample(places, min(n_systems, len(places))):
        allowed = np.zeros((1, entries.n_orientations), np.bool_)
        allowed[0, which] = True
        packed = np.packbits(allowed, axis=1)
        begin = time.perf_counter()
        answer = cpsat.is_feasible(table, entries.row[at : at + 1], packed)
        taken.append(1000 * (time.perf_counter() - begin))
        differ += bool(answer[0] != fit[at, which])
    return taken, differ


def beside_scipy(
    chance: random.Random, patterns: PatternClass, boundary: Boundary, n_systems: int
) -> tuple[float, float, int]:
    """(kernel, scipy) median microseconds for the flow of a system, and how often they differ."""
    n = boundary.n_sides
    systems = systems_of(patterns)
    lengths = np.array(boundary.lengths, np.int32)
    base = patterns.lengths[patterns.signature]
    fit = patterns.signature[(base <= lengths).all(axis=1)]
    kernel: list[float] = []
    other: list[float] = []
    differ = 0
    for s in chance.choices(fit.tolist(), k=n_systems) if len(fit) else ():
        slack = (lengths - patterns.lengths[s]).astype(np.int32)
        joined = patterns.joins[s] > 0
        begin = time.perf_counter()
        met, cut = decide_matching(systems, s, slack)
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
        # Without a cut, there is a matching with halves.
        differ += bool(found != (met or not cut))
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
            table = get_strict_table(patterns)
            asked = [
                random_boundary(chance, n, *arguments.lengths) for _ in range(arguments.boundaries)
            ]
            entries = table.entries(asked[0], np.ones(len(patterns), np.bool_))
            fitting = [
                WidthSolver(build_width_problem(b))
                .is_feasible(table, entries.row, entries.packed)
                .sum()
                for b in asked
            ]
            for name, ask in ASKED:
                times = {
                    t: [milliseconds(ask, table, b, entries, t) for b in asked] for t in THREADS
                }
                cells = [
                    f"{statistics.median(ms):.1f}, {np.percentile(ms, 95):.1f}, {max(ms):.1f}"
                    for ms in times.values()
                ]
                ratio, differ = "", ""
                if ask is WidthSolver.find_feasible and arguments.systems:
                    one = times[1][0] / max(long_enough(table, entries, asked[0]), 1)
                    taken, wrong = beside_cpsat(chance, table, entries, asked[0], arguments.systems)
                    ratio = f"{statistics.median(taken) / one:,.0f}" if taken else "none"
                    differ = f"{wrong} of {len(taken)}"
                print(
                    f"| {n} | {len(entries):,} | {statistics.median(fitting):,.0f} | {name} | "
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
