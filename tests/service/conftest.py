"""Services that the tests ask: of the starter database, and of one that may be changed."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from servedhere import TOKEN, ServedHere, served
from shared import EXAMPLES

import patterndb
from patterndb.store import LearningOptions
from patterndb_app.service.context import ServiceSettings
from patterndb_app.service.limits import Limits

#: Limits that learn a mesh at once, where it does not matter what is learned.
TINY = LearningOptions(basic=3, side=0, convex=0)


@pytest.fixture(scope="session")
def starter() -> Iterator[ServedHere]:
    """A service of the starter database. Nobody changes it."""
    with served(ServiceSettings(warm=False)) as running:
        yield running


@pytest.fixture(scope="session")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small database. Not to be changed: copies are."""
    path = tmp_path_factory.mktemp("served") / "learned.db"
    with patterndb.open(path, "create") as database:
        patterndb.ingest(database, [EXAMPLES / "jug.obj"], TINY)
    return path


@pytest.fixture
def db(learned: Path, tmp_path: Path) -> Path:
    """A copy of the small database, to be changed."""
    return Path(shutil.copy(learned, tmp_path / "my.db"))


@pytest.fixture
def writable(db: Path) -> Iterator[ServedHere]:
    """A service of a database that who shows the token may change."""
    settings = ServiceSettings(databases=(db,), token=TOKEN, warm=False)
    with served(settings) as running:
        yield running


@pytest.fixture
def strict(learned: Path) -> Iterator[ServedHere]:
    """A service with narrow limits."""
    limits = Limits(
        question_bytes=20_000,
        mesh_bytes=40_000,
        header_seconds=0.5,
        body_seconds=0.5,
        at_work=1,
        waiting=1,
        waiting_seconds=0.3,
        per_client=2,
        seconds=5.0,
        fills=1_000,
        answer_bytes=200_000,
    )
    with served(ServiceSettings(databases=(learned,), limits=limits, warm=False)) as running:
        yield running
