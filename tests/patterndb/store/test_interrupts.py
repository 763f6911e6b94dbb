"""Breaking off an ingest, politely and not: what was committed stays, and it can go on."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ingest import MeshReport, ingest
from patterndb.store import Database, LearningOptions
from tests.support.meshes import examples
from tests.support.store.learnt import OPTIONS, content, learned

SCRIPT = """
import sys
from ingest import ingest
from patterndb.store import Database, LearningOptions
with Database(sys.argv[1], "create") as db:
    print("begin", flush=True)
    report = ingest(db, sys.argv[2:], LearningOptions(5, 9, 14), jobs=2,
                    report=lambda mesh: print(mesh.name, flush=True))
print("interrupted" if report.interrupted else "done", flush=True)
"""
LEARNING = LearningOptions(5, 9, 14)
KILLS = 5


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = learned(tmp_path_factory.mktemp("whole") / "whole.db", examples(), LEARNING)
    return content(path)


def start(path: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", SCRIPT, os.fspath(path), *map(os.fspath, examples())]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begin\n"
    return process


def test_an_interrupt_after_a_mesh_keeps_it(tmp_path: Path, files: dict[str, Path]) -> None:
    path = tmp_path / "half.db"
    paths = list(files.values())
    done: list[str] = []

    def interrupt(mesh: MeshReport) -> None:
        done.append(mesh.name)
        if len(done) == 2:
            raise KeyboardInterrupt

    with Database(path, "create") as db:
        report = ingest(db, paths, OPTIONS, jobs=1, report=interrupt)
        assert report.interrupted
        assert sorted(m.name for m in report.meshes) == sorted(done)
        assert sorted(m.name for m in db.meshes()) == sorted(done)
        assert db.verify() == []
        again = ingest(db, paths, OPTIONS)
        assert not again.interrupted
        assert [m.outcome for m in again.meshes].count("unchanged") == 2
    assert content(path) == content(learned(tmp_path / "whole.db", paths))


def test_an_interrupt_while_nothing_is_written_leaves_the_database_as_it_was(
    tmp_path: Path, files: dict[str, Path]
) -> None:
    path = tmp_path / "none.db"

    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    with Database(path, "create") as db:
        before = db.content_hash()
        report = ingest(db, examples(), LEARNING, progress=interrupt)
        assert report.interrupted
        assert len(report.meshes) == len(db.meshes())
        assert db.verify() == []
        if not report.meshes:
            assert db.content_hash() == before


def test_control_c_in_another_process(tmp_path: Path, undisturbed: str) -> None:
    path = tmp_path / "half.db"
    process = start(path)
    assert process.stdout is not None
    first = process.stdout.readline().strip()
    process.send_signal(signal.SIGINT)
    rest = process.communicate()[0].split()
    assert process.returncode == 0
    # It may have been done before the signal came.
    assert rest[-1] in ("interrupted", "done")
    with Database(path) as db:
        assert sorted(m.name for m in db.meshes()) == sorted([first, *rest[:-1]])
        assert db.verify() == []
    learned(path, examples(), LEARNING, "write")
    assert content(path) == undisturbed


def test_kills_at_random_moments(tmp_path: Path, undisturbed: str) -> None:
    path = tmp_path / "killed.db"
    chance = random.Random(1)
    for _ in range(KILLS):
        process = start(path)
        time.sleep(chance.uniform(0, 0.5))
        process.kill()
        process.communicate()
        connection = sqlite3.connect(path)
        assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        connection.close()
        with Database(path) as db:
            assert db.verify() == []
    process = start(path)
    assert process.communicate()[0].split()[-1] == "done"
    assert content(path) == undisturbed
