"""The databases that the tests of the command line ask and change."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.support.cli.commandline import SMALL, TINY, run, write_obj
from tests.support.shared import EXAMPLES

#: A disk with one corner (vertex 0), which the examples do not hold.
DROP = ((0, 1, 6, 5), (6, 1, 2, 7), (5, 6, 8, 4), (7, 2, 3, 9), (6, 7, 9, 8), (4, 8, 9, 3))


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave no screen to open a window on, which would wait for somebody to close it.

    Tests of windows that ran before in this process have set one on which nothing is seen.
    """
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let windows, which the test replaces, open as if there were a screen."""
    monkeypatch.setattr("viewer.shell.probe.check_display", lambda: None)


@pytest.fixture(scope="session")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database of the examples and of a drop. Not to be changed: it is everyone's."""
    folder = tmp_path_factory.mktemp("learned")
    db = folder / "learned.db"
    drop = write_obj(folder / "drop.obj", DROP)
    result = run("ingest", *sorted(EXAMPLES.glob("*.obj")), drop, "--db", db, *SMALL)
    assert result.code == 0, result.err
    return db


@pytest.fixture
def db(learned: Path, tmp_path: Path) -> Path:
    """A copy of the learned database, to be changed."""
    return Path(shutil.copy(learned, tmp_path / "copy.db"))


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """A small database of two meshes, to be changed."""
    path = tmp_path / "tiny.db"
    result = run("ingest", EXAMPLES / "jug.obj", EXAMPLES / "hand.obj", "--db", path, *TINY)
    assert result.code == 0, result.err
    return path
