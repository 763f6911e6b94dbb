"""How many different patterns does a person see first? Random boundaries of 3 to 12 sides.

    python benchmarks/different.py --db all.db

The boundaries are those of benchmarks/query_speed.py. For each, and in every order that needs no
points, it counts the patterns among the first eight fills of the flat list, and of the list that a
person sees, which has one fill of each pattern. Where that has fewer than eight it looks through
the flat list for a pattern that is not there. Prints a Markdown table.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from query_speed import boundaries

import patterndb
from query import Fill, fills
from query.listing.orders import ORDERS

#: So many fills are seen first.
SEEN = 8

#: Fills of the flat list that are looked through for patterns that a folded list has missed.
LONG = 3_000


def count_patterns(listed: list[Fill]) -> int:
    """How many patterns fills have."""
    return len({fill.pattern.id for fill in listed})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, help="default: the starter database")
    parser.add_argument("--each", type=int, default=20, help="boundaries of each number of sides")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    heads = ("flat: mean", "seen: mean", "fewest", "fewer than 8", f"of these more in {LONG:,}")
    print(f"| order | boundaries | {' | '.join(heads)} |")
    print("| --- |" + " ---: |" * (1 + len(heads)))
    with patterndb.open(given.db) as database:
        for order in (name for name, order in ORDERS.items() if not order.needs_points):
            flat: list[int] = []
            seen: list[int] = []
            missed = 0
            for boundary in boundaries(given.seed, given.each):
                first = fills(database, boundary, limit=SEEN, order=order)
                flat.append(count_patterns(list(first)))
                folded = fills(database, boundary, limit=SEEN, order=order, per_pattern=1)
                seen.append(count_patterns(list(folded)))
                if seen[-1] < SEEN:
                    every = fills(database, boundary, limit=LONG, order=order, pool=LONG)
                    missed += count_patterns(list(every)) > seen[-1]
            few = sum(number < SEEN for number in seen)
            means = f"{np.mean(flat):.1f} | {np.mean(seen):.1f}"
            print(
                f"| {order} | {len(seen)} | {means} | {min(seen)} | {few} | {missed} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
