"""Learn a folder of meshes: time, memory and size beside a baseline program, in one run.

    python benchmarks/learn.py ../shared/data/meshes --baseline ../shared/prototypes/baseline.py

The baseline learns the same meshes on one core and stores nothing; ours runs on all cores and
ends with a database. Then the same command runs
once more (nothing may change), and patterns per number of sides are set beside the paper's
Table 1. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

#: Marcias et al. 2015, Table 1: 477,567 patterns of 40 meshes, by number of corners.
PAPER = (
    *(88, 44, 649, 1650, 5537, 11201, 20553, 31747, 45692, 56144, 61023, 59257, 51447, 40189),
    *(30816, 21578, 14638, 9318, 6182, 3501, 2412, 1179, 1439, 589, 516, 135, 17, 4, 1, 1, 15),
    *(1, 2, 1, 1),
)


def run(command: list[str]) -> tuple[str, float, float]:
    """stdout, wall seconds and peak resident megabytes of a command; stderr goes through."""
    started = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    out = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"{command[0]} ended with {child.returncode}")
    return out, time.perf_counter() - started, usage.ru_maxrss / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--baseline", type=Path, help="a script that takes meshes as arguments")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", type=Path, help="leave the database here")
    arguments = parser.parse_args()
    meshes = sorted(str(path) for path in arguments.folder.glob("*.obj"))
    ours = [sys.executable, "-m", "patterndb", "ingest", *meshes, "--json"]
    ours += ["--jobs", str(arguments.jobs)]

    with tempfile.TemporaryDirectory() as folder:
        warm = ["--basic", "2", "--side", "2", "--convex", "4"]
        smallest = min(meshes, key=lambda path: Path(path).stat().st_size)
        small = [sys.executable, "-m", "patterndb", "ingest", smallest, *warm]
        run([*small, "--db", f"{folder}/warm.db", "--json"])

        baseline = None
        if arguments.baseline:
            out, _, megabytes = run([sys.executable, str(arguments.baseline), *meshes])
            baseline = json.loads(out)
            print(f"baseline, one core: {baseline['seconds']} s, {baseline['patches']:,} patches, ")
            print(f"{baseline['patterns']:,} patterns, peak memory {megabytes:,.0f} MB\n")

        path = arguments.keep or Path(folder) / "all.db"
        path.unlink(missing_ok=True)
        out, seconds, megabytes = run([*ours, "--db", str(path)])
        report = json.loads(out)
        patches = sum(m["patches"]["distinct"] for m in report["meshes"])
        size = path.stat().st_size / 1e6
        before = stats(path)
        _, again, _ = run([*ours, "--db", str(path)])
        after = stats(path)

    print(f"ours, {arguments.jobs} threads, the whole process: {seconds:.1f} s", end="")
    if baseline:
        print(f", {seconds / baseline['seconds']:.2f} of the baseline", end="")
    print(f"; {patches:,} distinct patches, {report['patterns']:,} patterns; ")
    print(f"peak memory {megabytes:,.0f} MB; database {size:.1f} MB")
    same = before["content_hash"] == after["content_hash"]
    print(f"\nthe same command again: {again:.1f} s, content hash {'un' if same else ''}changed\n")
    table(before["by_sides"])


def stats(path: Path) -> dict[str, object]:
    command = [sys.executable, "-m", "patterndb", "stats", "--db", str(path), "--json"]
    return json.loads(run(command)[0])


def table(by_sides: dict[str, int]) -> None:
    print("| corners | patterns | paper |\n| ---: | ---: | ---: |")
    for n in range(max(len(PAPER), 1 + max(map(int, by_sides)))):
        paper = f"{PAPER[n]:,}" if n < len(PAPER) else ""
        print(f"| {n} | {by_sides.get(str(n), 0):,} | {paper} |")
    print(f"| all | {sum(by_sides.values()):,} | {sum(PAPER):,} |")


if __name__ == "__main__":
    main()
