"""How long commands are silent, with nothing kept from earlier runs: CPU, wall, longest silence.

    python benchmarks/silence.py "patterndb query --sides 3,5,4,6" ["patterndb stats" ...]

Each command is run by a shell in a new, empty folder with an empty cache folder of its own; with
--together they share both, as the lines of a page do. It sees a terminal. A silence is a stretch
without a byte on that, from the start to the end of the process.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import pty
import re
import resource
import subprocess
import tempfile
import time


def measure(command: str, folder: str) -> tuple[float, float, float, int, str]:
    """CPU, wall and longest silent seconds, exit code, and the last line that was said."""
    environment = {
        **os.environ,
        "PATTERNDB_CACHE": os.path.join(folder, "cache"),  # noqa: PTH118
        "PYTHONUNBUFFERED": "1",
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = last = time.monotonic()
    silent = 0.0
    said = b""
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        command, shell=True, cwd=folder, env=environment, stdin=theirs, stdout=theirs, stderr=theirs
    ) as process:
        os.close(theirs)
        with contextlib.suppress(OSError):  # Linux's way to say that the terminal is closed
            while piece := os.read(ours, 65536):
                now = time.monotonic()
                silent, last, said = max(silent, now - last), now, said + piece
    os.close(ours)
    end = time.monotonic()
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
    lines = re.sub(r"\r\x1b\[K[^\r\n]*(?=\r\x1b\[K)|\r(?=\n)", "", said.decode(errors="replace"))
    lines = lines.replace("\r\x1b[K", "").split("\n")
    told = next((line for line in reversed(lines) if line.strip()), "")
    return cpu, end - began, max(silent, end - last), process.returncode, told


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("commands", nargs="+", metavar="COMMAND")
    parser.add_argument("--together", action="store_true", help="one folder and cache for all")
    given = parser.parse_args()
    print("    cpu     wall  silent  exit")
    with tempfile.TemporaryDirectory() as shared:
        for command in given.commands:
            with tempfile.TemporaryDirectory() as own:
                cpu, wall, silent, code, told = measure(command, shared if given.together else own)
            print(f"{cpu:5.1f} s {wall:6.1f} s {silent:5.1f} s {code:5}  {command}\n  {told[:90]}")


if __name__ == "__main__":
    main()
