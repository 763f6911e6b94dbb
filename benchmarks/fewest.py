"""The first fill beside a filler with 15 patterns: which has fewer irregular vertices?

    python benchmarks/fewest.py --fills ../shared/golden/fills.csv --db all.db

fills.csv has random boundaries with the irregular vertices of that filler's answer; rows that it
does not answer are left out. Asks for each the first fill of the default order, with the database
and with the complete family alone, and prints how often it has fewer, as many and more.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from pathlib import Path

import patterndb
from patterndb.core.patternclass import PatternClass
from query import best


def compared(ours: int, theirs: int) -> str:
    """In words."""
    if ours == theirs:
        return "as many"
    return "fewer" if ours < theirs else "more"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fills", type=Path, required=True)
    parser.add_argument("--db", type=Path, help="default: the starter database")
    given = parser.parse_args()
    with given.fills.open(newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if row["ok"] == "1"]
    counts: dict[str, Counter[str]] = {"database": Counter(), "family alone": Counter()}
    with patterndb.open(given.db) as database:
        for row in rows:
            lengths = [int(length) for length in row["lengths"].split("-")]
            nothing = PatternClass.from_patterns(len(lengths), [])
            for name, source in (("database", database), ("family alone", nothing)):
                fill = best(source, lengths)
                ours = (
                    "none"
                    if fill is None
                    else compared(fill.n_irregular, int(row["n_irregular_all"]))
                )
                counts[name][ours] += 1
    for name, count in counts.items():
        print(f"{name}: {dict(count)} of {len(rows)}")


if __name__ == "__main__":
    main()
