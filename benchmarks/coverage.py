"""Which boundaries have a strict fill: all of N = 3..6 sides with lengths 2..7.

    python benchmarks/coverage.py --db all.db

Boundaries are taken once up to rotation and mirror image, and only with an even perimeter (no
other has a fill). For every fill found the independent checks are the tests'; here only
existence counts. Prints a Markdown table and the first boundaries without a fill.
"""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path

import patterndb
from query import Boundary, fills

SHOWN = 12


def boundaries(n: int, low: int, high: int) -> list[tuple[int, ...]]:
    """Lengths up to rotation and mirror image, with an even sum."""
    kept = []
    for lengths in itertools.product(range(low, high + 1), repeat=n):
        if sum(lengths) % 2:
            continue
        turned = [lengths[i:] + lengths[:i] for i in range(n)]
        if lengths == min(turned + [t[::-1] for t in turned]):
            kept.append(lengths)
    return kept


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, help="default: the starter database")
    parser.add_argument("--lengths", type=int, nargs=2, default=(2, 7))
    parser.add_argument("--sides", type=int, nargs="+", default=(3, 4, 5, 6))
    arguments = parser.parse_args()
    print("| N | boundaries | with a strict fill | share | without |")
    print("| ---: | ---: | ---: | ---: | --- |")
    with patterndb.open(arguments.db) as database:
        for n in arguments.sides:
            asked = boundaries(n, *arguments.lengths)
            empty = [
                b for b in asked if not fills(database, Boundary(b), limit=1).feasible_patterns
            ]
            found = len(asked) - len(empty)
            shown = "; ".join(",".join(map(str, b)) for b in empty[:SHOWN])
            more = " ..." if len(empty) > SHOWN else ""
            share = found / len(asked)
            print(f"| {n} | {len(asked):,} | {found:,} | {share:.1%} | {shown}{more} |", flush=True)


if __name__ == "__main__":
    main()
