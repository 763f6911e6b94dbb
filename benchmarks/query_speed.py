"""How fast a query answers: random boundaries of 3 to 12 sides with 2 to 10 edges each.

    python benchmarks/query_speed.py --db all.db

Classes are in memory. For each boundary: all patterns that fit strictly, the
first fill, the first 100 fills in the default order (ranked and expanded), and the same with two
strokes, which are strands of one of the fills. Beside it CP-SAT decides systems of the same
patterns and boundaries, one worker each, one after the other. Last, how long a query that is
busy takes to come back once it is cancelled. Prints Markdown tables.
"""

from __future__ import annotations

import argparse
import random
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import patterndb
from patterndb.store import Database
from query import Boundary, Fill, Stroke, fills
from query.listing.table import get_strict_table
from query.placing import find_strand
from query.solving.problem import build_width_problem
from query.solving.widths import WidthSolver

SIDES = range(3, 13)
SHORTEST, LONGEST = 2, 10
PAGE = 100


def boundaries(seed: int, each: int) -> Iterator[Boundary]:
    """Random boundaries with an even perimeter, as many of each number of sides."""
    chance = random.Random(seed)
    for n in SIDES:
        for _ in range(each):
            while True:
                lengths = [chance.randint(SHORTEST, LONGEST) for _ in range(n)]
                if sum(lengths) % 2 == 0:
                    break
            yield Boundary(lengths)


def two_strokes(chance: random.Random, fill: Fill) -> list[Stroke]:
    """Two different strands of a fill, as strokes."""
    found: list[Stroke] = []
    while len(found) < 2:
        side = chance.randrange(len(fill.lengths))
        ends = find_strand(fill, (side, chance.randrange(fill.lengths[side]))).ends
        assert ends is not None, "a strand from the boundary ends on it"
        stroke = Stroke(*ends)
        if stroke not in found and Stroke(*ends[::-1]) not in found:
            found.append(stroke)
    return found


def timed(work: Callable[[], object]) -> tuple[float, object]:
    """Milliseconds, and what came of it."""
    begin = time.perf_counter()
    result = work()
    return 1e3 * (time.perf_counter() - begin), result


def row(name: str, by_sides: dict[int, list[float]]) -> str:
    """A line of the table: all boundaries together, and medians of some numbers of sides."""
    every = np.concatenate(list(by_sides.values()))
    some = " | ".join(f"{np.median(by_sides[n]):.1f}" for n in (3, 5, 8, 12))
    p95 = np.quantile(every, 0.95)
    return f"| {name} | {np.median(every):.1f} | {p95:.1f} | {every.max():.1f} | {some} |"


def cpsat_ratio(database: Database, seed: int, each: int) -> tuple[float, float, int, int]:
    """(kernel, CP-SAT) milliseconds per system, systems tried, and how many answers differ."""
    chance = random.Random(seed)
    kernel = other = 0.0
    tried = differ = 0
    for boundary in boundaries(seed + 1, each):
        patterns = database.pattern_class(boundary.n_sides)
        table = get_strict_table(patterns)
        rows = np.arange(len(patterns))
        n_orientations = 2 * boundary.n_sides
        every = np.packbits(np.ones((len(rows), n_orientations), np.bool_), axis=1)
        problem = build_width_problem(boundary)
        ms, found = timed(
            lambda t=table, q=problem, r=rows, e=every: WidthSolver(q).find_feasible(t, r, e)
        )
        kernel += ms / (len(rows) * n_orientations)
        at = chance.randrange(len(patterns))
        o = chance.randrange(n_orientations)
        allowed = np.zeros((1, n_orientations), np.bool_)
        allowed[0, o] = True
        packed = np.packbits(allowed, axis=1)
        solver = WidthSolver(problem, threads=1, by_cpsat=True)
        ms, answer = timed(
            lambda s=solver, t=table, a=at, w=packed: s.find_feasible(t, np.array([a]), w)
        )
        other += ms
        tried += 1
        differ += bool(found[at, o] != answer[0, o])  # pyright: ignore
    return kernel / tried, other / tried, tried, differ


def cancelling(database: Database, tries: int) -> list[float]:
    """Milliseconds from a cancel to the end of the list, of queries that are busy."""
    found: list[float] = []
    for k in range(tries):
        stream = fills(database, (9, 8, 9, 10, 9, 8, 9, 10, 9, 9), limit=None)
        done = threading.Event()

        def run(stream: Iterator[Fill] = stream, done: threading.Event = done) -> None:
            for _ in stream:
                pass
            done.set()

        threading.Thread(target=run, daemon=True).start()
        time.sleep(0.02 + 0.01 * (k % 20))
        begin = time.perf_counter()
        stream.cancel()
        done.wait()
        found.append(1e3 * (time.perf_counter() - begin))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, help="default: the starter database")
    parser.add_argument("--each", type=int, default=20, help="boundaries of each number of sides")
    parser.add_argument("--threads", type=int, help="default: one a processor")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    chance = random.Random(given.seed)
    names = (
        "all patterns that fit",
        "first fill",
        f"first {PAGE} fills",
        "two strokes: all patterns that fit",
        "two strokes: first fill",
        f"two strokes: first {PAGE} fills",
    )
    taken: dict[str, dict[int, list[float]]] = {name: {n: [] for n in SIDES} for name in names}
    with patterndb.open(given.db) as database:
        for n in SIDES:
            for warm in ((4,) * n, (6,) * n):
                page = list(fills(database, warm, limit=PAGE))
                list(fills(database, warm, limit=PAGE, strokes=two_strokes(chance, page[-1])))
        for boundary in boundaries(given.seed, given.each):
            n = boundary.n_sides

            def ask(strokes: list[Stroke], limit: int, boundary: Boundary = boundary) -> list[Fill]:
                stream = fills(
                    database, boundary, strokes=strokes, limit=limit, threads=given.threads
                )
                return [fill for fill, _ in zip(stream, range(limit), strict=False)]

            def fitting(strokes: list[Stroke], boundary: Boundary = boundary) -> int:
                stream = fills(database, boundary, strokes=strokes, threads=given.threads)
                return stream.feasible_patterns

            page = ask([], PAGE)
            strokes = two_strokes(chance, chance.choice(page))
            work: tuple[Callable[[], object], ...] = (
                lambda: fitting([]),
                lambda: ask([], 1),
                lambda: ask([], PAGE),
                lambda s=strokes: fitting(s),
                lambda s=strokes: ask(s, 1),
                lambda s=strokes: ask(s, PAGE),
            )
            for name, step in zip(names, work, strict=True):
                taken[name][n].append(timed(step)[0])
        print("| ms | median | p95 | most | N = 3 | N = 5 | N = 8 | N = 12 |")
        print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
        for name in names:
            print(row(name, taken[name]))
        kernel, other, tried, differ = cpsat_ratio(database, given.seed, max(1, given.each // 4))
        print(
            f"\none system decided: kernel {1e3 * kernel:.2f} us, CP-SAT {1e3 * other:.0f} us, "
            f"{other / kernel:,.0f} times as long ({tried} systems, {differ} answers differ)"
        )
        late = cancelling(database, 40)
        print(
            f"cancelled queries end after {np.median(late):.1f} ms (median), "
            f"{max(late):.1f} ms (most of {len(late)})"
        )


if __name__ == "__main__":
    main()
