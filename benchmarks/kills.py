"""Kill an ingest again and again, resume it each time, and see that nothing is lost or spoiled.

    python benchmarks/kills.py --kills 200 --seed 1

Each run ingests the example meshes into a database that is new or was left by a kill, and is
ended by SIGKILL at a random moment: anywhere, while the database is made or opened, or while a
mesh is written. After every kill SQLite must find the file whole; a run that gets through must
leave the content of an undisturbed one, and the next begins a new database.

Prints one JSON document; exits 1 if there were failures. Needs fork(): a run then costs no
start of the interpreter.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import random
import signal
import sqlite3
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from ctypes import c_int
from pathlib import Path

from ingest import ingest, learn, read_mesh
from patterndb.store import Database, Learned, LearningOptions, Provenance

EXAMPLES = sorted((Path(__file__).resolve().parent.parent / "examples").glob("*.obj"))
# A run takes about a second, of which writing is a good part.
OPTIONS = LearningOptions(basic=5, side=10, convex=20)
JOBS = 2

OPENING, LEARNING, WRITING, DONE = range(4)
PHASES = ("opening", "learning", "writing")

# Where kills are aimed, and how often: opening and writing are short, and would be hit seldom.
AIMS = {"anywhere": 3, "opening": 1, "writing": 2}
# Seconds after the start within which a database is opened or made.
OPENING_SECONDS = 0.008
# Seconds after a write has begun: most take less.
WRITING_SECONDS = 0.05


class WatchedDatabase(Database):
    """A database that says when it is being written."""

    phase: c_int

    def add_mesh(
        self,
        name: str,
        sha256: str,
        provenance: Provenance,
        options: LearningOptions,
        learned: Learned,
    ) -> int:
        self.phase.value = WRITING
        try:
            return super().add_mesh(name, sha256, provenance, options, learned)
        finally:
            self.phase.value = LEARNING


def run(path: Path, phase: c_int) -> None:
    """One ingest, in a process of its own."""
    with WatchedDatabase(path, "create") as db:
        db.phase = phase
        phase.value = LEARNING
        ingest(db, EXAMPLES, OPTIONS, jobs=JOBS)
    phase.value = DONE


def is_whole(path: Path) -> bool:
    """Does SQLite find the file sound? One that was not made yet is."""
    if not path.exists():
        return True
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]


def content(path: Path) -> tuple[str, int]:
    """The content hash, and how many findings verify() has."""
    with Database(path) as db:
        return db.content_hash(), len(db.verify())


def wait_for(condition: Callable[[], bool], alive: Callable[[], bool]) -> None:
    while alive() and not condition():
        time.sleep(0.0005)


def kill_at_random(path: Path, seconds: float, chance: random.Random) -> str | None:
    """Start a run and kill it; return the phase it was killed in, None if it got through."""
    context = multiprocessing.get_context("fork")
    phase: c_int = context.RawValue("i", OPENING)
    process = context.Process(target=run, args=(path, phase))
    process.start()
    (aim,) = chance.choices(list(AIMS), list(AIMS.values()))
    if aim == "writing":
        # One of the next few writes, at any moment of it.
        for _ in range(chance.randint(1, len(EXAMPLES))):
            wait_for(lambda: phase.value == WRITING, process.is_alive)
            time.sleep(chance.uniform(0, WRITING_SECONDS))
    else:
        time.sleep(chance.uniform(0, OPENING_SECONDS if aim == "opening" else seconds))
    hit = phase.value
    running = process.is_alive()
    if running and process.pid is not None:
        os.kill(process.pid, signal.SIGKILL)
    process.join()
    if process.exitcode == 0:
        return None
    if process.exitcode != -signal.SIGKILL:
        raise RuntimeError(f"an ingest ended by itself with exit code {process.exitcode}")
    return PHASES[min(hit, WRITING)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="runs to kill while they run")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)

    # Load all modules here, without starting a thread: a fork would not take it along.
    learn(read_mesh(EXAMPLES[0]).quads()[0], OPTIONS)
    started = runs = finished = 0
    killed: Counter[str] = Counter()
    integrity_failures = hash_mismatches = findings = 0
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "whole.db"
        context = multiprocessing.get_context("fork")
        begin = time.perf_counter()
        process = context.Process(target=run, args=(whole, context.RawValue("i", OPENING)))
        process.start()
        process.join()
        seconds = time.perf_counter() - begin
        expected = content(whole)
        path = whole
        while killed.total() < arguments.kills:
            if path == whole:
                started += 1
                path = Path(folder) / f"{started}.db"
            runs += 1
            phase = kill_at_random(path, seconds, chance)
            if phase is not None:
                killed[phase] += 1
                integrity_failures += not is_whole(path)
                continue
            finished += 1
            found = content(path)
            hash_mismatches += found[0] != expected[0]
            findings += found[1]
            path.unlink()
            path = whole
        if path != whole:
            # The last one is brought to its end undisturbed.
            run(path, context.RawValue("i", OPENING))
            finished += 1
            hash_mismatches += content(path)[0] != expected[0]
    print(
        json.dumps(
            {
                "kills": runs,
                "kills_while_running": killed.total(),
                "by_phase": {name: killed[name] for name in PHASES},
                "finished_databases": finished,
                "integrity_failures": integrity_failures,
                "hash_mismatches": hash_mismatches,
                "verify_findings": findings,
                "undisturbed_seconds": round(seconds, 2),
            }
        )
    )
    return 1 if integrity_failures or hash_mismatches or findings else 0


if __name__ == "__main__":
    sys.exit(main())
