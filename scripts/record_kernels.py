"""Write patterndb/data/kernels.jsonl: the kernels that the verbs call, with the types of arguments.

    python scripts/record_kernels.py [VERB...] [--shared]

To be run when a kernel is added, renamed or called with other types; a test says when it is. Runs
what scripts/verb_runs.py lists for the verbs, all if none is named; the lines of other verbs stay.
With --shared, what needs the shared folder beside the clone is run as well. Then every kernel that
is not kept yet is compiled, for the seconds that it takes. Then scripts/record_parts.py tells which
call which.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path

from verb_runs import RUNS, run_apart

from patterndb.system.files import replace_file
from patterndb.system.kernellist import (
    LIST_NAME,
    format_kernel,
    parse_kernel,
    read_list,
)

TARGET = Path(__file__).resolve().parents[1] / "patterndb" / "data" / LIST_NAME


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("verbs", nargs="*", metavar="VERB", help="all if not given")
    parser.add_argument("--shared", action="store_true", help="run what needs ../shared, too")
    given = parser.parse_args()
    verbs = given.verbs or list(RUNS)
    known = {kernel.key: kernel for kernel in read_list()} if TARGET.is_file() else {}
    called: dict[tuple[str, str, str], set[str]] = {}
    plain: dict[tuple[str, str, str], set[str]] = {}
    for key, kernel in known.items():
        called[key] = set(kernel.verbs) - set(verbs)
        plain[key] = set(kernel.plain) - set(verbs)
    for verb in verbs:
        answer = run_apart(verb, shared=given.shared)
        if answer["failed"]:
            sys.exit(f"{verb}: " + "; ".join(answer["failed"]))
        for line in answer["calls"]:
            kernel = parse_kernel(line)
            old = known.get(kernel.key)
            # Times differ from run to run: a line changes where it is another kernel's by far.
            if old is None or not 0.5 <= old.seconds / kernel.seconds <= 2:
                known[kernel.key] = kernel
            called.setdefault(kernel.key, set()).add(verb)
            plain.setdefault(kernel.key, set()).update(kernel.plain)
        print(
            f"{verb}: {len(answer['calls'])} kernels, {answer['compiled']} compiled",
            file=sys.stderr,
        )
    lines = [
        format_kernel(
            dataclasses.replace(
                known[key], verbs=tuple(sorted(called[key])), plain=tuple(sorted(plain[key]))
            )
        )
        for key in sorted(called)
        if called[key]
    ]
    replace_file(TARGET, "".join(line + "\n" for line in lines))
    print(f"{len(lines)} kernels: {TARGET}")


if __name__ == "__main__":
    main()
