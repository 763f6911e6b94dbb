from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.support.store.learnt import learned, write_meshes


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """Mesh files by name."""
    return write_meshes(tmp_path)


@pytest.fixture(scope="session")
def learned_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database with all of them, not to be changed."""
    folder = tmp_path_factory.mktemp("learned")
    return learned(folder / "full.db", list(write_meshes(folder).values()))


@pytest.fixture
def full(tmp_path: Path, learned_once: Path) -> Path:
    """A copy of that database."""
    return Path(shutil.copy(learned_once, tmp_path / "full.db"))
