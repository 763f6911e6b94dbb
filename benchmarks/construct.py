"""Constructed fills: how many irregular vertices they have, and how long they take.

    python benchmarks/construct.py --count 40 --seed 1

Random boundaries, parts looked up in the complete family of patterns with at most 4 irregular
vertices (made and kept on first use). Three Markdown tables:

- convex boundaries of 9 to 34 sides: t - (N - 4) of each construction by itself, where t is
  the number of irregular vertices and N - 4 what strict fills with valences 3 and 5 need;
- boundaries with reflex corners: t, and how many have a strict fill;
- the time to decide (all plans, by their counts), to the first fill, and for the whole list.

Beside them stand the figures of a prototype. Every fill that is listed is
checked against its boundary.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time

import numpy as np

from query import Boundary, Fill
from query.boundary import CornerKind
from query.construct import construct_fills
from query.construct.plan import Plan
from query.construct.planner import Planner
from query.listing.construction import FamilyLookup
from query.recognition import read_fill

SIDES = (9, 10, 12, 16, 20, 24, 28, 34)
LONGEST = 20

#: t - (N - 4), mean, of the prototype: keeping corners, cutting pentagons.
SPEC_KEPT = -1.0
SPEC_CUT = 0.44

#: t, mean, by the number of reflex corners.
SPEC_REFLEX = {1: 4.9, 2: 6.8, 3: 8.3, 4: 9.8}


def boundary(chance: random.Random, n: int, n_reflex: int, shortest: int) -> Boundary:
    lengths = [chance.randint(shortest, LONGEST) for _ in range(n)]
    if sum(lengths) % 2:
        lengths[chance.randrange(n)] += 1
    corners: list[CornerKind] = ["convex"] * n
    for i in chance.sample(range(n), n_reflex):
        corners[i] = "reflex"
    return Boundary(lengths, corners)


def least(plans: list[Plan]) -> int | None:
    return min((plan.count for plan in plans), default=None)


def checked(fills: list[Fill], asked: Boundary) -> list[Fill]:
    for fill in fills:
        again = read_fill(fill.quads, asked, "constructed")
        assert again.n_irregular == fill.n_irregular
        assert again.pattern == fill.pattern
    return fills


def spread(values: list[int | None]) -> str:
    """share answered, mean, worst"""
    known = [v for v in values if v is not None]
    if not known:
        return "0 % | - | -"
    share = len(known) / len(values)
    return f"{share:.0%} | {statistics.mean(known):.2f} | {max(known)}"


def milliseconds(seconds: list[float]) -> str:
    return f"{statistics.median(seconds) * 1e3:.1f} | {max(seconds) * 1e3:.0f}"


def convex(chance: random.Random, count: int, shortest: int) -> None:
    lookup = FamilyLookup()
    print(f"\nConvex, lengths {shortest}..{LONGEST}, t - (N - 4): share, mean, worst\n")
    print("| N | grid ||| corners kept ||| pentagons cut ||| all, strict ||| all |||")
    print("| ---: |" + " ---: |" * 15)
    best_of_all: list[int] = []
    for n in SIDES:
        rows: list[list[int | None]] = [[] for _ in range(5)]
        for _ in range(count):
            asked = boundary(chance, n, 0, shortest)
            planner = Planner(lookup)
            grid = least(planner.plan_rectangle(asked, False))
            kept = least(planner.plan_kept(asked))
            cut = least(planner.plan_trimmed(asked, False))
            first = checked(list(construct_fills(asked, lookup, limit=1)), asked)
            strict = checked(list(construct_fills(asked, lookup, limit=1, strict=True)), asked)
            found = (grid, kept, cut, *(f[0].n_irregular if f else None for f in (strict, first)))
            for row, t in zip(rows, found, strict=True):
                row.append(None if t is None else t - (n - 4))
        best_of_all += [t for t in rows[4] if t is not None]
        print(f"| {n} | " + " | ".join(spread(row) for row in rows) + " |", flush=True)
    print(f"\nSpecification: corners kept {SPEC_KEPT}, pentagons cut {SPEC_CUT}, in the mean.")
    print(f"The best of all constructions: {np.mean(best_of_all):.3f} in the mean.")


def reflex(chance: random.Random, count: int) -> None:
    lookup = FamilyLookup()
    print(f"\nReflex corners, N = 5..16, lengths 2..{LONGEST}: t\n")
    print("| reflex | mean t | worst | specification | mean above |convex - reflex - 4| | strict |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: |")
    for n_reflex, spec in SPEC_REFLEX.items():
        found: list[int] = []
        above: list[int] = []
        strict = 0
        for _ in range(count):
            n = chance.randint(max(5, n_reflex + 2), 16)
            asked = boundary(chance, n, n_reflex, 2)
            (fill,) = checked(list(construct_fills(asked, lookup, limit=1)), asked)
            found.append(fill.n_irregular)
            above.append(fill.n_irregular - abs(n - 2 * n_reflex - 4))
            strict += any(construct_fills(asked, lookup, limit=1, strict=True))
        print(
            f"| {n_reflex} | {np.mean(found):.2f} | {max(found)} | {spec} "
            f"| {np.mean(above):.2f} | {strict / count:.0%} |",
            flush=True,
        )


def times(chance: random.Random, count: int) -> None:
    print("\nMilliseconds of processor time, median and worst\n")
    print("| N | reflex | decide || first fill || whole list || fills |")
    print("| ---: | ---: |" + " ---: |" * 7)
    for n, n_reflex in ((9, 0), (12, 0), (20, 0), (34, 0), (8, 1), (12, 2), (16, 4)):
        spans: list[list[float]] = [[], [], []]
        fills: list[int] = []
        for _ in range(count):
            asked = boundary(chance, n, n_reflex, 1)
            begin = time.process_time()
            Planner(FamilyLookup()).plans(asked, False)
            spans[0].append(time.process_time() - begin)
            fresh = FamilyLookup()
            begin = time.process_time()
            next(construct_fills(asked, fresh, limit=1))
            spans[1].append(time.process_time() - begin)
            begin = time.process_time()
            fills.append(len(list(construct_fills(asked, fresh))))
            spans[2].append(time.process_time() - begin)
        cells = " | ".join(milliseconds(span) for span in spans)
        print(f"| {n} | {n_reflex} | {cells} | {np.mean(fills):.0f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40, help="boundaries per row")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    # Tables are made before any clock runs.
    for n_reflex in (0, 2):
        list(construct_fills(boundary(chance, 12, n_reflex, 1), FamilyLookup()))
    for shortest in (1, 2):
        convex(chance, arguments.count, shortest)
    reflex(chance, arguments.count)
    times(chance, arguments.count)


if __name__ == "__main__":
    main()
