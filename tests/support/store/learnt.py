"""Databases to test with, learned from a few small meshes."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path

from ingest import ingest
from patterndb.store import Database, LearningOptions
from tests.support.meshes import CUP, DOUBLET, Quads, beside, grid, refined, star, write_obj

#: Small meshes that share patterns, and each has some of its own.
MESHES: Mapping[str, Quads] = {
    "cup": CUP,
    "star": star(5, 2),
    "grid": grid(4, 5),
    "pair": DOUBLET,
    "stars": beside(star(3, 2), star(7)),
    "fine": refined(CUP),
}
OPTIONS = LearningOptions(4, 8, 10, prepare=False)
OTHER = LearningOptions(3, 5, 0, prepare=True)


def write_meshes(folder: Path) -> dict[str, Path]:
    return {name: write_obj(folder / f"{name}.obj", quads) for name, quads in MESHES.items()}


def learned(
    path: Path, files: Sequence[Path], options: LearningOptions = OPTIONS, mode: str = "create"
) -> Path:
    """The database at ``path``, with the files ingested one by one."""
    with Database(path, mode) as db:  # type: ignore[arg-type]
        for file in files:
            ingest(db, [file], options, jobs=1)
    return path


def content(path: Path) -> str:
    """The content hash of a sound database."""
    with Database(path) as db:
        assert db.verify() == []
        return db.content_hash()


def rows(path: Path, table: str) -> list[tuple[object, ...]]:
    """Every row of a table, in order."""
    connection = sqlite3.connect(path)
    try:
        return sorted(connection.execute(f"SELECT * FROM {table}").fetchall())
    finally:
        connection.close()


def change(path: Path, *statements: str) -> None:
    """Change a database behind its back."""
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()
