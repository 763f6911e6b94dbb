"""Spoil databases in every way, and see that nothing crashes, hangs, or goes unseen.

    python benchmarks/hostile_database.py --files 3000 --seed 1

Each file is a copy of a small database that was spoiled once: bits flipped, pages swapped, sectors
zeroed, cut short, a hostile value in a column, or the schema tampered with. Then it is asked what
verbs ask: to be opened, classes, strict fills, statistics, meshes, occurrences, verify, a write.
An answer must be what the sound database gives, or an error of ours.

Nearly all are copies of a database of a few dozen patterns, whose every page is hit often; every
LARGE_EVERYth is of one of some thousand, which has inner pages and overflow. Files lie in memory
where there is a file system for it: a write then waits for no disk.

A batch of files is tried in a process of its own, so that a crash is counted and the rest goes on.
Prints one JSON document; exits 1 if there was a crash, a file that took too long, or an unforeseen
error. ``unseen`` counts files whose content differs though neither verify nor a question said so.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import random
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

from ingest import ingest
from patterndb.store import Database, LearningOptions
from tests.support.store.hostile import WAYS, ask_everything, judge, read_content

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.obj"))
OPTIONS = LearningOptions(basic=4, side=6, convex=8)
LARGE_OPTIONS = LearningOptions(basic=6, side=10, convex=18)

#: Of so many files one is a copy of the large database.
LARGE_EVERY = 50

#: Files in a process; a crash ends the process, and the next goes on behind the file.
BATCH = 2000

#: Where files may lie in memory.
MEMORY = Path("/dev/shm")
#: Seconds of the processor for one file: more is a hang. The sound large one takes a tenth.
HANG_SECONDS = 5.0
#: Seconds by the clock, for what hangs without working.
STUCK_SECONDS = 300.0
#: Seconds until a process has started and has asked the sound ones.
START_SECONDS = 180.0


def make_sound(path: Path, options: LearningOptions = OPTIONS) -> None:
    """A database with a table of everything: meshes, patterns, occurrences, uses."""
    with Database(path, "create") as database:
        ingest(database, EXAMPLES[:2], options, jobs=1)
        for row in range(3):
            database.record_use(database.pattern_class(4).pattern(row))


def _work(folder: Path, files: list[tuple[int, str]], seed: int, results: Connection) -> None:
    known: dict[str, tuple[list[str], object]] = {}
    for name in SOUND:
        copied = Path(shutil.copy(folder / name, folder / "asked.db"))
        known[name] = ask_everything(copied), read_content(folder / name)
    results.send(None)
    # The timer's signal ends the process, as nothing here handles it.
    for number, way in files:
        path = folder / "spoiled.db"
        for left in folder.glob("spoiled.db*"):
            left.unlink()
        name = SOUND[number // len(WAYS) % LARGE_EVERY == 0]
        shutil.copy(folder / name, path)
        signal.setitimer(signal.ITIMER_PROF, HANG_SECONDS)
        try:
            WAYS[way](path, random.Random(f"{seed} {number}"))
        except sqlite3.Error:
            results.send((number, way, "unchanged", "", 0.0))
            continue
        began = time.process_time()
        results.send((number, way, *judge(path, *known[name]), time.process_time() - began))


#: The names of the databases that are spoiled: the small one and the large one.
SOUND = ("sound.db", "large.db")


def run(n_files: int, seed: int, ways: list[str] | None = None) -> dict[str, object]:
    """Try so many files; the counts, and one line for every file that did what none may."""
    names = ways or list(WAYS)
    counts: Counter[str] = Counter()
    by_way: dict[str, Counter[str]] = {name: Counter() for name in names}
    bad: list[dict[str, object]] = []
    slowest = 0.0
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as name:
        folder = Path(name)
        make_sound(folder / SOUND[0])
        make_sound(folder / SOUND[1], LARGE_OPTIONS)
        waiting = [(number, names[number % len(names)]) for number in range(n_files)]
        context = multiprocessing.get_context("spawn")
        while waiting:
            batch = waiting[:BATCH]
            mine, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_work, args=(folder, batch, seed, theirs))
            process.start()
            theirs.close()
            done = 0
            try:
                # The first word waits for the interpreter.
                if not mine.poll(START_SECONDS) or mine.recv() is not None:
                    raise RuntimeError("the sound databases cannot be asked")
                while done < len(batch) and mine.poll(STUCK_SECONDS):
                    number, way, word, text, seconds = mine.recv()
                    done += 1
                    counts[word] += 1
                    by_way[way][word] += 1
                    slowest = max(slowest, seconds)
                    if word in ("unforeseen", "unseen"):
                        bad.append({"file": number, "way": way, "what": word, "text": text})
            except EOFError:
                pass
            if done < len(batch):
                number, way = batch[done]
                process.join(1.0)
                is_over_time = process.exitcode in (None, -signal.SIGPROF)
                word = "hang" if is_over_time else "crash"
                process.kill()
                counts[word] += 1
                by_way[way][word] += 1
                bad.append({"file": number, "way": way, "what": word, "text": ""})
                done += 1
            process.join()
            waiting = waiting[done:]
            print(f"{n_files - len(waiting):,} files: {dict(counts)}", file=sys.stderr, flush=True)
    changes = sum(counts[word] for word in ("refused", "found", "unseen"))
    return {
        "files": n_files,
        "seed": seed,
        "counts": dict(counts),
        "by_way": {name: dict(each) for name, each in by_way.items()},
        "share_seen": None if not changes else 1 - counts["unseen"] / changes,
        "slowest_seconds": round(slowest, 2),
        "bad": bad,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--files", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--way", choices=list(WAYS), action="append", help="all if not given")
    given = parser.parse_args()
    result = run(given.files, given.seed, given.way)
    print(json.dumps(result, indent=1))
    counts = result["counts"]
    assert isinstance(counts, dict)
    sys.exit(any(counts.get(word) for word in ("crash", "hang", "unforeseen")))


if __name__ == "__main__":
    main()
