"""One query from the command line: class loaded and fills expanded, apart from imports.

    python benchmarks/query_start.py --db all.db

Runs, in turn, the whole query process and a process that only imports what the query does,
and takes the medians' difference. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from pathlib import Path

#: What the query imports, and nothing run.
IMPORTS = "import patterndb_app.cli, query, query.engine"


def timed(command: list[str]) -> tuple[float, str]:
    started = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return time.perf_counter() - started, done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, required=True)
    parser.add_argument("--sides", default="8,8,8,8,8,8")
    parser.add_argument("--limit", type=int, default=100)
    parser.add_argument("--runs", type=int, default=7)
    arguments = parser.parse_args()
    query = [sys.executable, "-m", "patterndb", "query", "--sides", arguments.sides]
    query += ["--limit", str(arguments.limit), "--db", str(arguments.db), "--json"]
    imports = [sys.executable, "-c", IMPORTS]
    timed(query)  # brings the files into memory
    whole, bare = [], []
    out = ""
    for _ in range(arguments.runs):
        seconds, out = timed(query)
        whole.append(seconds)
        bare.append(timed(imports)[0])
    answer = json.loads(out)
    difference = statistics.median(whole) - statistics.median(bare)
    print(
        f"{len(answer['fills'])} fills of {arguments.sides} out of {answer['feasible_patterns']} "
        f"patterns that fit, {arguments.runs} runs: whole process median "
        f"{statistics.median(whole):.2f} s (min {min(whole):.2f}, max {max(whole):.2f}), imports "
        f"alone {statistics.median(bare):.2f} s, difference {difference:.2f} s"
    )


if __name__ == "__main__":
    main()
