"""Measure what loading a class from SQLite takes, and of this restoring and describing its codes.

    python benchmarks/class_loading.py --runs 9

Loads classes of the starter database, from the SQLite file that is unpacked from it, and prints a
row for each: CPU milliseconds, medians over the runs.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from contextlib import closing
from typing import Any

import patterndb
from patterndb.core import description as d
from patterndb.store import classes
from patterndb.store.connection import connect

CLASSES = (4, 5, 6, 8, 12)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=int, default=9)
    given = parser.parse_args()
    spent = {"restore": 0.0, "describe": 0.0}

    def timed(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def run(*args: Any) -> Any:
            began = time.process_time()
            made = function(*args)
            spent[name] += time.process_time() - began
            return made

        return run

    classes.restore = timed("restore", classes.restore)
    d.describe_symbols = timed("describe", d.describe_symbols)
    starter = patterndb.open()
    starter.content_hash()  # unpacks it
    print("| sides | patterns | loading, ms | restoring codes | describing them |")
    print("|---:|---:|---:|---:|---:|")
    with closing(connect(starter.path, immutable=True)) as connection:
        for n_sides in CLASSES:
            rows: list[tuple[float, float, float]] = []
            n_patterns = 0
            for _ in range(given.runs + 1):  # the first warms up
                spent.update(restore=0.0, describe=0.0)
                began = time.process_time()
                n_patterns = len(classes.load_class(connection, n_sides))
                took = time.process_time() - began
                rows.append((took, spent["restore"], spent["describe"]))
            cells = " | ".join(
                f"{1e3 * statistics.median(values):.1f}" for values in zip(*rows[1:], strict=True)
            )
            print(f"| {n_sides} | {n_patterns:,} | {cells} |")


if __name__ == "__main__":
    main()
