"""The schema's version, and the steps from older ones.

``schema.sql`` is the present schema and the only place it stands. A step is added here,
never edited once released, whenever the schema changes: MIGRATIONS[n] brings a database of
version n - 1 to version n.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

APPLICATION_ID = 0x50617444
SCHEMA_VERSION = 1

MIGRATIONS: Mapping[int, str] = {}


def schema() -> str:
    """The text of schema.sql, from the installed package or from the checkout."""
    packaged = files("patterndb") / "schema.sql"
    if packaged.is_file():
        return packaged.read_text(encoding="utf-8")
    return (Path(__file__).parents[2] / "schema.sql").read_text(encoding="utf-8")


def create(connection: sqlite3.Connection) -> None:
    """Make an empty database; a crash on the way leaves an empty file."""
    connection.executescript(f"BEGIN IMMEDIATE;\n{schema()}\nCOMMIT;")


def migrate(
    connection: sqlite3.Connection,
    steps: Mapping[int, str] = MIGRATIONS,
    target: int = SCHEMA_VERSION,
) -> list[int]:
    """Apply the steps that are missing, each in one transaction with its own number."""
    done: list[int] = []
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    for number in range(version + 1, target + 1):
        try:
            connection.executescript(
                f"BEGIN IMMEDIATE;\n{steps[number]}\n;PRAGMA user_version = {number:d};\nCOMMIT;"
            )
        except BaseException:
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            raise
        done.append(number)
    return done
