"""One Database for many threads, several programs for one file, and statements that do not end."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import perf_counter

import pytest

from ingest import ingest
from patterndb.errors import DatabaseError, TimeLimitError
from patterndb.store import Database, connection
from patterndb.system.deadline import end_by
from query import fills
from tests.support.store.learnt import OPTIONS, content

#: Rows without end, as a view of someone else's could have.
ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT count(*) FROM n"


def test_readers_and_writers_in_threads_lose_nothing(full: Path) -> None:
    with Database(full, "write") as db:
        pattern = db.pattern_class(4).pattern(0)
        expected = [fill.pattern.name for fill in fills(db, (3, 4, 3, 4), limit=10)]

        def write(_: int) -> None:
            db.record_use(pattern)

        def read(_: int) -> list[str]:
            assert db.statistics().meshes == 6
            return [fill.pattern.name for fill in fills(db, (3, 4, 3, 4), limit=10)]

        with ThreadPoolExecutor(8) as pool:
            written = pool.map(write, range(60))
            answers = list(pool.map(read, range(12)))
            list(written)
        assert db.uses() == {pattern.id: 60}
        assert answers == [expected] * 12
        assert db.verify() == []


def test_two_databases_merged_into_each_other_by_threads_do_not_wait_for_ever(
    full: Path, tmp_path: Path
) -> None:
    with Database(full, "write") as one, Database(tmp_path / "other.db", "create") as other:
        with ThreadPoolExecutor(2) as pool:
            both = [pool.submit(one.merge, other), pool.submit(other.merge, one)]
            for each in both:
                each.result(timeout=60)
        assert other.content_hash() == one.content_hash()


def test_a_reader_notices_what_another_program_wrote(full: Path, files: dict[str, Path]) -> None:
    with Database(full) as reader, Database(full, "write") as writer:
        before = reader.pattern_class(4)
        assert reader.pattern_class(4) is before
        writer.remove(["grid.obj"])
        after = reader.pattern_class(4)
        assert after is not before
        assert after.frequency.sum() < before.frequency.sum()
        ingest(writer, [files["grid"]], OPTIONS, jobs=1)
        assert reader.pattern_class(4).frequency.sum() == before.frequency.sum()


def test_a_use_recorded_after_another_programs_write_keeps_no_old_class(full: Path) -> None:
    with Database(full, "write") as one, Database(full, "write") as other:
        pattern = one.pattern_class(4).pattern(0)
        before = one.pattern_class(5)
        other.remove(["star.obj"])
        one.record_use(pattern)
        assert one.pattern_class(5).frequency.sum() < before.frequency.sum()


@pytest.fixture
def half_written(full: Path) -> Iterator[tuple[Path, str]]:
    """A database whose writer was killed half-way, and the content it had."""
    before = content(full)
    pid = os.fork()
    if pid == 0:
        writer = sqlite3.connect(full, isolation_level=None)
        # Pages go to the file before the end of the transaction.
        writer.execute("PRAGMA cache_size = 2")
        writer.execute("BEGIN IMMEDIATE")
        writer.execute("UPDATE occurrence SET example = zeroblob(900)")
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(pid, 0)
    assert full.with_name(full.name + "-journal").stat().st_size > 0
    yield full, before


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that every user may read: those of pytest are for its own."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        yield Path(name)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork()")
def test_a_reader_takes_back_what_a_killed_writer_left(half_written: tuple[Path, str]) -> None:
    path, before = half_written
    with Database(path) as db:
        assert db.content_hash() == before
    assert not path.with_name(path.name + "-journal").exists()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork()")
def test_a_reader_that_is_open_goes_on_after_a_writer_was_killed(full: Path) -> None:
    with Database(full) as db:
        before = db.content_hash()
        pid = os.fork()
        if pid == 0:
            writer = sqlite3.connect(full, isolation_level=None)
            writer.execute("PRAGMA cache_size = 2")
            writer.execute("BEGIN IMMEDIATE")
            writer.execute("UPDATE occurrence SET example = zeroblob(900)")
            os.kill(os.getpid(), signal.SIGKILL)
        os.waitpid(pid, 0)
        assert db.content_hash() == before


@pytest.mark.skipif(
    not hasattr(os, "fork") or os.geteuid() != 0, reason="needs to become another user"
)
def test_a_reader_that_may_not_write_is_told_what_is_the_matter(
    half_written: tuple[Path, str], open_folder: Path
) -> None:
    path, before = half_written
    for left in (path, path.with_name(path.name + "-journal")):
        (open_folder / left.name).write_bytes(left.read_bytes())
    path = open_folder / path.name
    mine, theirs = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.setuid(65534)
        try:
            Database(path)
            said = "opened"
        except DatabaseError as error:
            said = str(error)
        os.write(theirs, said.encode())
        os._exit(0)
    os.waitpid(pid, 0)
    said = os.read(mine, 4096).decode()
    assert "was broken off" in said and "you may not write" in said, said
    assert content(path) == before


def test_a_writer_that_waits_for_a_reader_is_told_of_readers(
    full: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_SECONDS", 0.05)
    reader = sqlite3.connect(full, isolation_level=None)
    reader.execute("BEGIN")
    reader.execute("SELECT count(*) FROM mesh").fetchone()
    with Database(full, "write") as db, pytest.raises(DatabaseError, match="is being read"):
        db.remove(["cup.obj"])
    reader.close()


def ask_for_ever(db: Database) -> object:
    return db._ask(lambda held: held.execute(ENDLESS).fetchone())


def test_a_statement_without_end_ends_at_the_deadline(full: Path) -> None:
    with Database(full) as db:
        with pytest.raises(TimeLimitError, match="time limit"), end_by(perf_counter() + 0.05):
            ask_for_ever(db)
        assert db.verify() == []


def test_a_deadline_is_of_its_thread_and_of_its_block(full: Path) -> None:
    with Database(full) as db, end_by(perf_counter() - 1), ThreadPoolExecutor(1) as pool:
        assert pool.submit(db.content_hash).result() == db_content(full)
    with end_by(perf_counter() - 1), pytest.raises(TimeLimitError), Database(full) as db:
        ask_for_ever(db)


def db_content(path: Path) -> str:
    found: list[str] = []
    worker = threading.Thread(target=lambda: found.append(content(path)))
    worker.start()
    worker.join()
    return found[0]


#: A program of its own, since what a key ends here would be the one that runs the tests.
PRESSED = f"""
import signal, sys
from patterndb.store import Database

# A shell that starts programs in the background has them ignore the key.
signal.signal(signal.SIGINT, signal.default_int_handler)

def ask(held):
    print("running", flush=True)
    return held.execute("{ENDLESS}").fetchone()

with Database(sys.argv[1]) as db:
    try:
        db._ask(ask)
    except KeyboardInterrupt:
        print("ended", db.verify(), flush=True)
"""


def test_control_c_ends_a_statement_without_end(full: Path) -> None:
    command = [sys.executable, "-c", PRESSED, str(full)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == "running\n"
            time.sleep(0.2)
            process.send_signal(signal.SIGINT)
            assert process.communicate(timeout=60)[0] == "ended []\n"
        finally:
            process.kill()
    assert process.returncode == 0
