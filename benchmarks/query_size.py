"""What a query costs as databases grow: start, classes, fills and memory, side by side.

    python benchmarks/query_size.py all.db million.db

A process of its own for each database and run, in turn. The first loads every class and keeps it in
the cache folder; that is told apart. Then, in new processes: the imports, each class ready (its
arrays and its systems), and over random boundaries of 3 to 12 sides the first fill, the first 100,
and the count of all patterns that fit; each class is warmed by two boundaries. Last, memory of 1, 2
and 4 processes that have each asked boundaries of all numbers of sides: all together, each page
that they share counted once (PSS), and the largest (RSS). Linux alone tells these. Prints Markdown
for RESULTS.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

SEED = 7

#: Processes whose memory is measured together.
TOGETHER = (1, 2, 4)

PAGE = 100


def ask(path: Path, each: int, *, wait: bool) -> None:
    """Ask one database, in this process; print what it took as JSON. wait: then for a line."""
    begun = time.perf_counter()
    from query_speed import SIDES, boundaries

    from patterndb.store import Database
    from query import fills
    from query.solving.systems import systems_of

    imported = time.perf_counter()
    found: dict[str, list[float]] = {"ready": [], "first": [], "page": [], "all": []}
    sizes: dict[int, int] = {}

    def timed(name: str, work: Callable[[], object]) -> None:
        start = time.perf_counter()
        work()
        found[name].append(1e3 * (time.perf_counter() - start))

    with Database(path) as database:
        for n in SIDES:
            timed("ready", lambda n=n: systems_of(database.pattern_class(n)))
            sizes[n] = len(database.pattern_class(n))
            for warm in ((4,) * n, (6,) * n):
                list(fills(database, warm, limit=PAGE))
        for boundary in boundaries(SEED, each):
            timed("first", lambda b=boundary: next(fills(database, b, limit=1), None))
            timed("page", lambda b=boundary: list(fills(database, b, limit=PAGE)))
            timed("all", lambda b=boundary: fills(database, b).feasible_patterns)
        told = {"imports": 1e3 * (imported - begun), "sizes": sizes, **found}
        print(json.dumps(told), flush=True)
        if wait:
            sys.stdin.readline()


def start(path: Path, each: int, *, wait: bool = False) -> subprocess.Popen[str]:
    command = [sys.executable, __file__, "--child", "--each", str(each), str(path)]
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [*command, *(["--wait"] if wait else [])], stdin=pipe, stdout=pipe, text=True
    )


def run(path: Path, each: int) -> dict[str, Any]:
    """What one process told."""
    out, _ = start(path, each).communicate()
    return json.loads(out)


def measure_memory(path: Path, together: int) -> tuple[float, float]:
    """Megabytes of so many processes: all together, and the largest with what it shares."""
    running = [start(path, 1, wait=True) for _ in range(together)]
    for child in running:
        assert child.stdout is not None
        child.stdout.readline()
    told = [read_memory(child.pid) for child in running]
    for child in running:
        child.communicate("\n")
    return sum(pss for pss, _ in told), max(rss for _, rss in told)


def read_memory(pid: int) -> tuple[float, float]:
    """PSS and RSS of a process, megabytes."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()[1:]
    kib = {line.split(":")[0]: int(line.split()[1]) for line in lines}
    return kib["Pss"] / 1024, kib["Rss"] / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("databases", type=Path, nargs="+")
    parser.add_argument("--each", type=int, default=10, help="boundaries of each number of sides")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--wait", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        ask(given.databases[0], given.each, wait=given.wait)
        return
    columns: list[dict[str, str]] = []
    for path in given.databases:
        begun = time.perf_counter()
        first = run(path, 1)
        made = time.perf_counter() - begun
        told = [run(path, given.each) for _ in range(given.runs)]
        largest = int(np.argmax(list(told[0]["sizes"].values())))
        ready = np.median([one["ready"] for one in told], axis=0)
        column = {
            "patterns of 3 to 12 sides": f"{sum(told[0]['sizes'].values()):,}",
            "of the largest class": f"{max(told[0]['sizes'].values()):,}",
            "first process of all, s": f"{made:.1f}",
            "of that, classes loaded and kept, s": f"{sum(first['ready']) / 1e3:.1f}",
            "imports, ms": f"{np.median([one['imports'] for one in told]):.0f}",
            "largest class ready, ms": f"{ready[largest]:.0f}",
            "all classes ready, ms": f"{ready.sum():.0f}",
        }
        for name, words in (
            ("first", "first fill"),
            ("page", f"first {PAGE}"),
            ("all", "all that fit"),
        ):
            every = np.concatenate([one[name] for one in told])
            column[f"{words}, median and p95, ms"] = (
                f"{np.median(every):.1f}, {np.quantile(every, 0.95):.1f}"
            )
        for together in TOGETHER:
            pss, rss = measure_memory(path, together)
            s = "" if together == 1 else "es"
            column[f"{together} process{s}: together, largest, MB"] = f"{pss:.0f}, {rss:.0f}"
        columns.append(column)
    print("| | " + " | ".join(path.stem for path in given.databases) + " |")
    print("| --- |" + " ---: |" * len(columns))
    for name in columns[0]:
        print(f"| {name} | " + " | ".join(column[name] for column in columns) + " |")


if __name__ == "__main__":
    main()
