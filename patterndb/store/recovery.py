"""Recover what can be read of a damaged database into a new one.

The rows of each table are read in order of their keys, from the first up to what cannot be read,
and from the last down to it. A row is recovered that the new file's schema accepts and that can be
checked: patterns whose code is the canonical one of a reduced disk (their other columns follow from
it), meshes, and the occurrences and uses that belong to recovered ones.
"""

from __future__ import annotations

import contextlib
import sqlite3
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

from patterndb.errors import DatabaseError
from patterndb.store.connection import atomic, connect, connect_unchecked
from patterndb.store.reading import select_meshes, sum_occurrences
from patterndb.store.records import (
    INSERT_OCCURRENCE,
    INSERT_PATTERN,
    INSERT_USAGE,
    SELECT_OCCURRENCES,
    SELECT_PATTERNS,
    SELECT_USAGE,
    Mesh,
    OccurrenceRow,
    PatternRow,
    UsageRow,
)
from patterndb.store.verification import (
    READ_AT_ONCE,
    UNREADABLE,
    are_examples_sound,
    describe_sound,
    list_mesh_faults,
)
from patterndb.store.writing import insert_mesh
from patterndb.system.files import write_beside

#: The tables of which rows are recovered, and how many columns their keys have.
TABLES = {"mesh": 1, "pattern": 1, "occurrence": 2, "usage": 1}


#: Patches of one occurrence, at most: sums over millions of rows stay far below 2**63.
MOST_PATCHES = 1 << 40


@dataclass
class RecoveryReport:
    """What was recovered of a damaged database.

    saved:      rows of each table that are in the new file.
    lost:       of each table, rows that were read and are not sound, by the reason.
    unreadable: tables in which some rows could not be read at all.
    incomplete: names of meshes whose occurrences or counts are not those that were written;
                learning them again makes them whole.
    """

    saved: dict[str, int] = field(default_factory=dict[str, int])
    lost: dict[str, Counter[str]] = field(
        default_factory=lambda: {table: Counter[str]() for table in TABLES}
    )
    unreadable: list[str] = field(default_factory=list[str])
    incomplete: list[str] = field(default_factory=list[str])

    @property
    def is_whole(self) -> bool:
        """Was everything recovered?"""
        return not (any(self.lost.values()) or self.unreadable or self.incomplete)


def recover_database(path: Path, into: Path) -> RecoveryReport:
    """Recover what is sound in a damaged database into a new file.

    path: read only; it stays as it is. into: must not be there yet; it appears when it is whole,
    and :meth:`Database.verify` finds nothing wrong with it.

    Raises DatabaseError if nothing of the file can be read, or ``into`` is there or cannot be
    written.
    """
    if into.exists():
        raise DatabaseError(f"{into} is there already; name a new file")
    found = RecoveryReport()
    with contextlib.closing(connect_unchecked(path)) as source:
        _check_tables(source, path)
        with (
            write_beside(into) as fresh,
            contextlib.closing(connect(fresh, "create")) as target,
            atomic(target),
        ):
            sums = _recover_meshes(source, target, found)
            patterns = _recover_patterns(source, target, found)
            _recover_occurrences(source, target, found, patterns)
            _recover_uses(source, target, found)
            _drop_unheld(target, found)
            _fit_meshes(target, found, sums)
            for table in TABLES:
                count = target.execute(f"SELECT count(*) FROM {table}").fetchone()  # noqa: S608
                found.saved[table] = count[0]
    return found


def _check_tables(source: sqlite3.Connection, path: Path) -> None:
    try:
        tables = {row[0] for row in source.execute("SELECT name FROM sqlite_schema")}
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        raise DatabaseError(
            f"nothing of {path} can be read ({error}); restore it from a copy, or learn its "
            "meshes again"
        ) from error
    if not set(TABLES) <= tables:
        raise DatabaseError(f"{path} lacks the tables of a pattern database")


def _read_rows(
    source: sqlite3.Connection, select: str, table: str, found: RecoveryReport
) -> Iterator[tuple[Any, ...]]:
    """Read the rows of a table by key, around what cannot be read; the key comes first."""
    n_key = TABLES[table]
    key = ", ".join(str(number + 1) for number in range(n_key))
    last: tuple[Any, ...] | None = None
    try:
        for row in source.execute(f"{select} ORDER BY {key}"):
            # In a damaged tree keys may come again, for ever.
            if last is not None and not row[:n_key] > last:
                raise sqlite3.DatabaseError("keys do not ascend")
            last = row[:n_key]
            yield row
        return
    except (sqlite3.DatabaseError, TypeError, UnicodeDecodeError):
        found.unreadable.append(table)
    later: tuple[Any, ...] | None = None
    order = ", ".join(f"{number + 1} DESC" for number in range(n_key))
    with contextlib.suppress(sqlite3.DatabaseError, TypeError, UnicodeDecodeError):
        for row in source.execute(f"{select} ORDER BY {order}"):
            is_new = last is None or row[:n_key] > last
            if not is_new or (later is not None and not row[:n_key] < later):
                return
            later = row[:n_key]
            yield row


def _insert(
    target: sqlite3.Connection, insert: str, row: Sequence[Any], table: str, found: RecoveryReport
) -> bool:
    """Insert a row, if the schema accepts it; else count it as lost."""
    try:
        target.execute(insert, row)
    except (sqlite3.IntegrityError, sqlite3.DataError, OverflowError) as error:
        found.lost[table][str(error)] += 1
        return False
    return True


def _recover_meshes(
    source: sqlite3.Connection, target: sqlite3.Connection, found: RecoveryReport
) -> dict[int, bytes]:
    """Write meshes; return the sums of their occurrences by id."""
    names = [row[1] for row in source.execute("PRAGMA table_info(mesh)")]
    sums: dict[int, bytes] = {}
    for values in _read_rows(source, "SELECT * FROM mesh", "mesh", found):
        row = dict(zip(names, values, strict=True))
        try:
            mesh = Mesh.from_columns({**row, "patterns": 0})
            insert_mesh(target, mesh, row["occurrence_sum"], row["id"])
            sums[row["id"]] = row["occurrence_sum"]
        except (sqlite3.Error, *UNREADABLE) as error:
            found.lost["mesh"][str(error)] += 1
    return sums


def _recover_patterns(
    source: sqlite3.Connection, target: sqlite3.Connection, found: RecoveryReport
) -> dict[int, PatternRow]:
    """Write patterns; return them by id."""
    patterns: dict[int, PatternRow] = {}
    rows = map(PatternRow._make, _read_rows(source, SELECT_PATTERNS, "pattern", found))
    while some := list(islice(rows, READ_AT_ONCE)):
        described = describe_sound([row.code for row in some])
        for row, expected in zip(some, described, strict=True):
            if isinstance(expected, Exception):
                found.lost["pattern"][str(expected)] += 1
            elif row.id != expected.id:
                found.lost["pattern"]["the id does not follow from the code"] += 1
            elif _insert(target, INSERT_PATTERN, expected, "pattern", found):
                patterns[row.id] = expected
    return patterns


def _recover_occurrences(
    source: sqlite3.Connection,
    target: sqlite3.Connection,
    found: RecoveryReport,
    patterns: dict[int, PatternRow],
) -> None:
    origins = dict(target.execute("SELECT id, origin FROM mesh").fetchall())
    lost = found.lost["occurrence"]
    for values in _read_rows(source, SELECT_OCCURRENCES, "occurrence", found):
        row = OccurrenceRow._make(values)
        pattern = patterns.get(row.pattern_id)
        if pattern is None or row.mesh_id not in origins:
            lost["its pattern or its mesh is lost"] += 1
        elif type(row.patches) is not int or row.patches > MOST_PATCHES:
            lost["its number of patches cannot be"] += 1
        elif row.mirrored_patches and not pattern.chiral:
            lost["its pattern is its own mirror image, but has others"] += 1
        elif not are_examples_sound(
            [row.example], [pattern.n_quads if origins[row.mesh_id] == "learned" else 0]
        ):
            lost["its example cannot be read, or has too few quads"] += 1
        else:
            _insert(target, INSERT_OCCURRENCE, row, "occurrence", found)


def _recover_uses(
    source: sqlite3.Connection, target: sqlite3.Connection, found: RecoveryReport
) -> None:
    for row in map(UsageRow._make, _read_rows(source, SELECT_USAGE, "usage", found)):
        held = target.execute("SELECT 1 FROM pattern WHERE id = ?", (row.pattern_id,)).fetchone()
        if held is None:
            found.lost["usage"]["its pattern is lost"] += 1
        else:
            _insert(target, INSERT_USAGE, row, "usage", found)


def _drop_unheld(target: sqlite3.Connection, found: RecoveryReport) -> None:
    """Drop the patterns that no recovered mesh has and that were never used."""
    dropped = target.execute(
        "DELETE FROM pattern WHERE id NOT IN (SELECT pattern_id FROM usage) "
        "AND NOT EXISTS (SELECT 1 FROM occurrence WHERE pattern_id = pattern.id)"
    ).rowcount
    if dropped:
        found.lost["pattern"]["no recovered mesh has it, and it was never used"] += dropped


def _fit_meshes(target: sqlite3.Connection, found: RecoveryReport, sums: dict[int, bytes]) -> None:
    """Give each mesh that lost something the counts and the sum of what is left of it."""
    for row in list(select_meshes(target, "ORDER BY id")):
        mesh = Mesh.from_columns(row)
        total = patches = 0
        own = target.execute(f"{SELECT_OCCURRENCES} WHERE mesh_id = ?", (row["id"],))
        for one in map(OccurrenceRow._make, own):
            total = sum_occurrences([one], total)
            patches += one.patches
        kept_sum = total.to_bytes(16, "big")
        if kept_sum == sums[row["id"]] and not list_mesh_faults(mesh, patches):
            continue
        found.incomplete.append(mesh.name)
        basic, side, convex = (
            min(count, patches) for count in (mesh.basic, mesh.side, mesh.convex)
        )
        if basic + side + convex < patches:  # each patch is found by one mode or more
            basic = patches
        fitted = replace(mesh, basic=basic, side=side, convex=convex, distinct=patches, left_out=0)
        values = fitted.to_columns() | {"occurrence_sum": kept_sum}
        changes = ", ".join(f"{column} = ?" for column in values)
        target.execute(
            f"UPDATE mesh SET {changes} WHERE id = ?",  # noqa: S608
            (*values.values(), row["id"]),
        )
