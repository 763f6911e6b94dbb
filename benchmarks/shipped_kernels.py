"""Kernels that come with a wheel against those compiled for this processor: the same work, paired.

    python benchmarks/shipped_kernels.py [--rounds 5] [--meshes FOLDER]

Runs query_speed.py and learn.py by turns with the pack of patterndb/data/kernels, which
scripts/pack_kernels.py makes, and without, each after a run that is not counted, in which what is
missing is compiled.
Counted are the CPU seconds of the process, user and system, which other processes disturb less than
the clock on the wall. The ratio is the median of the rounds' ratios; above one the pack is slower.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from patterndb.system.kernelpack import PACK_VARIABLE

HERE = Path(__file__).resolve().parent


def measure(command: list[str], environment: dict[str, str]) -> float:
    """CPU seconds of a run of the command, those of its own processes included."""
    with tempfile.TemporaryFile() as talk:
        process = subprocess.Popen(
            command, env={**os.environ, **environment}, stdout=talk, stderr=talk
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            talk.seek(0)
            sys.exit(f"{' '.join(command)} failed:\n{talk.read().decode()}")
    return usage.ru_utime + usage.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--meshes", type=Path, default=HERE.parent / "examples")
    given = parser.parse_args()
    work = {
        "query_speed.py": ["--each", "4", "--threads", "1"],
        "learn.py": [str(given.meshes), "--jobs", "1"],
    }
    print(f"{'':16} {'shipped':>9} {'compiled':>9}  ratio")
    for script, options in work.items():
        command = [sys.executable, str(HERE / script), *options]
        ways: tuple[dict[str, str], dict[str, str]] = ({}, {PACK_VARIABLE: ""})
        for way in ways:
            measure(command, way)
        rounds = [tuple(measure(command, way) for way in ways) for _ in range(given.rounds)]
        shipped, compiled = (statistics.median(column) for column in zip(*rounds, strict=True))
        ratio = statistics.median(one / other for one, other in rounds)
        print(f"{script:16} {shipped:7.2f} s {compiled:7.2f} s  {ratio:.3f}", flush=True)


if __name__ == "__main__":
    main()
