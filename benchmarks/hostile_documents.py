"""Feed damaged documents to their readers: boundaries, networks, strokes, sessions and more.

    python benchmarks/hostile_documents.py --cases 100000 --seed 1

Each document is a small valid one with a damage or more: values of other types, huge and tiny
numbers, deep nesting, entries that are missing, unknown or there twice, other lengths, bytes that
are flipped, cut off or repeated; in archives also members that are missing or damaged one by one.
It must be read, or refused with an error of ours, within a second of the processor's time. All
else is a failure: another exception, a slow read, one that hangs (20 s by the clock), a process
that died, or one that came above a gigabyte.
``--only KIND:N`` reads case N of a kind alone, in this process, and prints what becomes of it.

Prints one JSON document; exits 1 if there were failures.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import sys
import time
from collections import Counter
from multiprocessing.sharedctypes import Synchronized, SynchronizedArray
from typing import Any

from tests.support.hostiledocuments import KINDS, judge, make_case

HANG_SECONDS = 20.0
MOST_BYTES = 1_000_000_000
MOST_SHOWN = 20

#: Cases between two looks of the parent at what its child counts.
SLICE = 500


def work(
    kind: str,
    seed: int,
    first: int,
    last: int,
    at: Synchronized[int],
    counts: SynchronizedArray[int],
    failures: Any,
) -> None:
    """Judge cases, in a process of their own."""
    make_seeds, make_reader = KINDS[kind]
    seeds, read = make_seeds(), make_reader()
    for data in seeds:
        read(data)  # what is not damaged must be read
    for number in range(first, last):
        at.value = number
        result, more, _ = judge(read, make_case(kind, seeds, seed, number))
        if result in ("read", "refused"):
            counts[result == "refused"] += 1
        else:
            failures.put((kind, number, result, more))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    counts[2] = max(counts[2], peak // 2**20)
    if peak > MOST_BYTES:
        failures.put((kind, last - 1, "memory", f"{peak / 1e6:.0f} MB by this case"))


def run_kind(kind: str, seed: int, cases: int) -> tuple[dict[str, int], list[tuple[Any, ...]]]:
    """Judge the cases of a kind; a case that kills or hangs its process is passed over."""
    context = multiprocessing.get_context("spawn")
    counts = context.Array("q", 3)
    failures: list[tuple[Any, ...]] = []
    first = 0
    while first < cases:
        at, queue = context.Value("q", -1), context.Queue()
        last = min(cases, first + 20 * SLICE)
        process = context.Process(target=work, args=(kind, seed, first, last, at, counts, queue))
        process.start()
        seen, since = -1, time.monotonic()
        while process.is_alive():
            process.join(0.1)
            while not queue.empty():
                failures.append(queue.get())
            if at.value != seen:
                seen, since = at.value, time.monotonic()
            # The first case waits for imports, which on a busy machine may take a minute.
            elif time.monotonic() - since > HANG_SECONDS * (30 if seen < 0 else 1):
                failures.append((kind, seen, "hang", ""))
                process.kill()
                process.join()
        while not queue.empty():
            failures.append(queue.get())
        if at.value < 0:
            raise RuntimeError(f"the seeds of {kind} cannot be made or read")
        if process.exitcode != 0 and (not failures or failures[-1][2] != "hang"):
            failures.append((kind, at.value, "died", f"exit code {process.exitcode}"))
        first = last if process.exitcode == 0 else at.value + 1
    names = ("read", "refused", "peak_mb")
    return dict(zip(names, counts[:], strict=True)), failures


def main() -> int:
    parser = argparse.ArgumentParser(description="feed damaged documents to their readers")
    parser.add_argument("--cases", type=int, default=10_000, help="documents, over all kinds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=list(KINDS), action="append", help="these kinds alone")
    parser.add_argument("--only", metavar="KIND:N", help="one case, in this process")
    asked = parser.parse_args()
    if asked.only:
        kind, _, number = asked.only.rpartition(":")
        make_seeds, make_reader = KINDS[kind]
        data = make_case(kind, make_seeds(), asked.seed, int(number))
        print(data[:2000])
        print(make_reader()(data))
        return 0
    kinds = asked.kind or list(KINDS)
    report: dict[str, Any] = {"seed": asked.seed, "kinds": {}}
    failures: list[tuple[Any, ...]] = []
    for kind in kinds:
        counts, failed = run_kind(kind, asked.seed, -(-asked.cases // len(kinds)))
        report["kinds"][kind] = counts
        failures += failed
        print(f"{kind}: {counts}, {len(failed)} failures", file=sys.stderr, flush=True)
    report["failures"] = dict(Counter(one[2] for one in failures))
    report["shown"] = [
        {"case": f"{kind}:{number}", "what": what, "more": more}
        for kind, number, what, more in failures[:MOST_SHOWN]
    ]
    print(json.dumps(report, indent=2))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
