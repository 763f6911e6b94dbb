"""Kill every way to write a database at random moments, and see that it is before or after.

    python benchmarks/kill_writes.py --kills 200 --seed 1

What benchmarks/kills.py does for ingest, for merge, remove, import of a table, migration and the
recording of uses. Each run copies a sound database, writes to it in a process of its own, and ends
that by SIGKILL at a random moment of the time that the write takes. Then the file is opened for
reading, as ``stats`` does: what it holds must be the content before or after the write, SQLite must
find it whole, and verify() must find nothing.

Prints one JSON document; exits 1 if there were failures. Needs fork(): a run then costs no start of
the interpreter.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import random
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from ingest import ingest
from patterndb.core.shortcode import lengthen
from patterndb.store import Database, LearningOptions, read_table
from patterndb.store.migrations import DROPPED, SCHEMA_VERSION

EXAMPLES = sorted((Path(__file__).resolve().parent.parent / "examples").glob("*.obj"))
OPTIONS = LearningOptions(basic=4, side=8, convex=12)

#: Uses that one run records.
USES = 20


def merge(path: Path, folder: Path) -> None:
    with Database(path, "write") as db, Database(folder / "other.db") as other:
        db.merge(other)


def remove(path: Path, folder: Path) -> None:
    with Database(path, "write") as db:
        db.remove([db.meshes()[0].name])


def import_table(path: Path, folder: Path) -> None:
    with Database(path, "write") as db:
        db.import_ddq(read_table(folder / "table.db"))


def migrate(path: Path, folder: Path) -> None:
    Database(path, "write").close()


def record_uses(path: Path, folder: Path) -> None:
    with Database(path, "write") as db:
        pattern = db.pattern_class(4).pattern(0)
        for _ in range(USES):
            db.record_use(pattern)


#: Ways to write, by name. One that commits several times may be between any two.
WAYS: dict[str, Callable[[Path, Path], None]] = {
    "merge": merge,
    "remove": remove,
    "import": import_table,
    "migration": migrate,
    "uses": record_uses,
}


def make_sound(folder: Path) -> None:
    """Write what the ways begin with: sound.db, other.db, table.db, and old.db of schema 2."""
    with Database(folder / "sound.db", "create") as db:
        ingest(db, EXAMPLES[:2], OPTIONS, jobs=1)
    with Database(folder / "other.db", "create") as db:
        ingest(db, EXAMPLES[2:4], OPTIONS, jobs=1)
        db.export_ddq(folder / "table.db")
    shutil.copy(folder / "sound.db", folder / "old.db")
    with closing(sqlite3.connect(folder / "old.db")) as held:
        held.executescript("DROP TABLE checksum; PRAGMA user_version = 2;")
        for column in ("patterns_left_out", "pattern_limit"):  # of step 5, the last first
            held.execute(f"ALTER TABLE mesh DROP COLUMN {column}")
        # What step 4 drops, which may be anything, and packed codes.
        for column in DROPPED:
            held.execute(f"ALTER TABLE pattern ADD COLUMN {column} BLOB NOT NULL DEFAULT x''")
        rows = held.execute("SELECT id, code FROM pattern").fetchall()
        codes = lengthen([short for _, short in rows])
        held.executemany(
            "UPDATE pattern SET code = ? WHERE id = ?",
            [(code, number) for (number, _), code in zip(rows, codes, strict=True)],
        )
        held.commit()


def tell_content(path: Path) -> tuple[object, ...]:
    """What a database holds, as its content hash and its uses."""
    with Database(path) as db:
        return db.content_hash(), tuple(sorted(db.uses().items()))


def find_faults(path: Path, allowed: set[object], old: bool) -> list[str]:
    """What is wrong with a database after a kill."""
    if old:
        # Before the migration it is refused to readers; what is there is brought up to date.
        with closing(sqlite3.connect(path)) as held:
            (version,) = held.execute("PRAGMA user_version").fetchone()
        if version not in range(2, SCHEMA_VERSION + 1):
            return [f"it has schema {version}"]
        Database(path, "write").close()
    try:
        held_content = tell_content(path)
        with Database(path) as db:
            found = db.verify()
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
    if held_content not in allowed:
        found.append("the content is neither that before nor that after")
    return found


def run(kills: int, seed: int, ways: list[str] | None = None) -> dict[str, object]:
    """Kill so many writes; the counts, and a line for each that went wrong."""
    chance = random.Random(seed)
    context = multiprocessing.get_context("fork")
    killed: Counter[str] = Counter()
    finished: Counter[str] = Counter()
    journals = 0
    faults: list[str] = []
    names = ways or list(WAYS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_sound(folder)
        seconds: dict[str, float] = {}
        allowed: dict[str, set[object]] = {}
        path = folder / "killed.db"
        for way in names:
            source = folder / ("old.db" if way == "migration" else "sound.db")
            shutil.copy(source, path)
            before = tell_content(folder / "sound.db")
            # The first time loads kernels, which the forks then have.
            WAYS[way](path, folder)
            allowed[way] = {before, tell_content(path)}
            if way == "uses":
                with Database(path) as db:
                    (used,) = db.uses()
                hashed = before[0]
                allowed[way] |= {(hashed, ((used, n),)) for n in range(1, USES + 1)}
            shutil.copy(source, path)
            process = context.Process(target=WAYS[way], args=(path, folder))
            begin = time.perf_counter()
            process.start()
            process.join()
            seconds[way] = time.perf_counter() - begin
        while killed.total() < kills:
            way = names[killed.total() % len(names)]
            shutil.copy(folder / ("old.db" if way == "migration" else "sound.db"), path)
            process = context.Process(target=WAYS[way], args=(path, folder))
            process.start()
            time.sleep(chance.uniform(0, seconds[way]))
            if process.is_alive() and process.pid is not None:
                os.kill(process.pid, signal.SIGKILL)
            process.join()
            if process.exitcode == -signal.SIGKILL:
                killed[way] += 1
            elif process.exitcode == 0:
                finished[way] += 1
            else:
                faults.append(f"{way}: it ended by itself with exit code {process.exitcode}")
                break
            journal = path.with_name(path.name + "-journal")
            journals += journal.exists() and journal.stat().st_size > 0
            faults += [f"{way}: {f}" for f in find_faults(path, allowed[way], way == "migration")]
            for left in folder.glob("killed.db*"):
                left.unlink()
    return {
        "seed": seed,
        "killed": dict(killed),
        "got_through": dict(finished),
        "left_a_journal": journals,
        "faults": faults,
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--way", choices=list(WAYS), action="append", help="all if not given")
    given = parser.parse_args()
    result = run(given.kills, given.seed, given.way)
    print(json.dumps(result, indent=1))
    return int(bool(result["faults"]))


if __name__ == "__main__":
    sys.exit(main())
