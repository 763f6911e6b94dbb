from __future__ import annotations

from pathlib import Path

import pytest
from learnt import learned, write_meshes


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """Mesh files by name."""
    return write_meshes(tmp_path)


@pytest.fixture
def full(tmp_path: Path, files: dict[str, Path]) -> Path:
    """A database with all of them."""
    return learned(tmp_path / "full.db", list(files.values()))
