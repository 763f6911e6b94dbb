"""Services that the tests ask: of the starter database, and of one that may be changed."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import patterndb
from patterndb.store import LearningOptions
from patterndb_app.service.context import ServiceSettings
from patterndb_app.service.limits import Limits
from tests.support.service.servedhere import PATIENCE, TOKEN, ServedHere, served
from tests.support.shared import EXAMPLES

#: Limits that learn a mesh at once, where it does not matter what is learned.
TINY = LearningOptions(basic=3, side=0, convex=0)


#: Narrow limits, so that what goes beyond them is met in no time.
NARROW = Limits(
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
        database.ingest([EXAMPLES / "jug.obj"], TINY)
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
    settings = ServiceSettings(databases=(learned,), limits=NARROW, warm=False)
    with served(settings) as running:
        yield running


@pytest.fixture
def occupied(learned: Path) -> Iterator[ServedHere]:
    """A service that does one thing at a time, and for which an answer is never too large: a long
    one that nobody reads keeps it occupied."""
    limits = replace(NARROW, seconds=PATIENCE, answer_bytes=2**28)
    settings = ServiceSettings(databases=(learned,), limits=limits, warm=False)
    with served(settings) as running:
        yield running
