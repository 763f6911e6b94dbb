"""Compare the schema of a file with schema.sql: what stands in a file's schema is run.

A trigger or a view planted in a database would act whenever it is read or written, and a trigger
that is missing leaves frequencies wrong. So a file with another schema than ours is refused.
"""

from __future__ import annotations

import re
import sqlite3
from functools import cache

from patterndb.store.migrations import SCHEMA_VERSION, schema

#: What ANALYZE makes: tables of SQLite's own, by which it plans.
_OF_SQLITE = {
    "sqlite_stat1": "CREATE TABLE sqlite_stat1(tbl,idx,stat)",
    "sqlite_stat4": "CREATE TABLE sqlite_stat4(tbl,idx,neq,nlt,ndlt,sample)",
}

#: Entries that are read: ours has a tenth, and one too many is named.
_MOST_OBJECTS = 100

_TOKEN = re.compile(r"--[^\n]*|/\*.*?\*/|'(?:[^']|'')*'|\w+|\s+|.", re.DOTALL)


def find_schema_change(connection: sqlite3.Connection, version: int = SCHEMA_VERSION) -> str | None:
    """What in a file's schema is not as in schema.sql, in words; None where all is.

    version: what the file says. Of an older one only that nothing stands in it that is not in
    schema.sql as well: the steps to the present one change the rest.
    """
    expected = _list_expected()
    found: dict[str, tuple[str, str, str]] = {}
    rows = connection.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema")
    for kind, name, table, sql in rows.fetchmany(_MOST_OBJECTS):
        if any(not isinstance(x, str) for x in (kind, name, table)) or name in found:
            return "an entry of its schema is damaged"
        if kind != "table" or _OF_SQLITE.get(name) != sql:
            found[name] = (kind, table, _normalise(sql))
    for name, (kind, table, sql) in found.items():
        if name not in expected or expected[name][0] != kind:
            return f"it has a {kind} {name!r} that is none of ours"
        if version == SCHEMA_VERSION and expected[name] != (kind, table, sql):
            return f"its {kind} {name!r} is not as we make it"
    if version == SCHEMA_VERSION:
        for name, (kind, _, _) in expected.items():
            if name not in found:
                return f"it has no {kind} {name!r}"
    return None


@cache
def _list_expected() -> dict[str, tuple[str, str, str]]:
    """Kind, table and statement of all that schema.sql makes, by name."""
    fresh = sqlite3.connect(":memory:")
    try:
        fresh.executescript(schema())
        rows = fresh.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema").fetchall()
    finally:
        fresh.close()
    return {name: (kind, table, _normalise(sql)) for kind, name, table, sql in rows}


def _normalise(sql: object) -> str:
    """A statement without comments and with single spaces, as two may differ that mean the same:
    a column that a migration added stands as that wrote it."""
    if sql is None:  # SQLite's own indices
        return ""
    tokens = [t for t in _TOKEN.findall(str(sql)) if not t.startswith(("--", "/*"))]
    return " ".join(t for t in tokens if not t.isspace())
