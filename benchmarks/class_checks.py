"""Measure what checking the rows of a class takes of loading it from SQLite.

    python benchmarks/class_checks.py --runs 9

Loads classes of the starter database, from the SQLite file that is unpacked from it, and prints a
row for each: CPU seconds of loading, and of these the seconds in check_rows, which checks rows and
makes lengths and joins; medians over the runs.
"""

from __future__ import annotations

import argparse
import statistics
import time
from contextlib import closing
from typing import Any

import patterndb
from patterndb.core import rowcheck
from patterndb.store import reading
from patterndb.store.connection import connect

CLASSES = (4, 5, 6, 8, 12)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=int, default=9)
    given = parser.parse_args()
    spent = [0.0]

    def check_timed(*args: Any) -> rowcheck.CheckedRows:
        began = time.process_time()
        checked = rowcheck.check_rows(*args)
        spent[0] += time.process_time() - began
        return checked

    reading.check_rows = check_timed
    starter = patterndb.open()
    starter.content_hash()  # unpacks it
    print(
        "| sides | patterns | loading, ms | in check_rows, ms | share |\n|---:|---:|---:|---:|---:|"
    )
    with closing(connect(starter.path, immutable=True)) as connection:
        for n_sides in CLASSES:
            loading: list[float] = []
            checking: list[float] = []
            for _ in range(given.runs + 1):  # the first warms up
                spent[0] = 0.0
                began = time.process_time()
                patterns = reading.load_class(connection, n_sides)
                loading.append(time.process_time() - began)
                checking.append(spent[0])
            a, b = statistics.median(loading[1:]), statistics.median(checking[1:])
            print(
                f"| {n_sides} | {len(patterns):,} | {1e3 * a:.1f} | {1e3 * b:.1f} | {b / a:.0%} |"
            )


if __name__ == "__main__":
    main()
