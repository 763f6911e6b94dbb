"""Change a database: meshes, their patterns and occurrences, and how often fills were used.

Every function that takes a connection belongs inside one atomic().

A pattern that no mesh has (a query made it, or another database learned it) is written when it is
first used. Uses are not part of what was learned: they are neither in the content hash nor merged
nor in the compact file.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from patterndb.core import description as d
from patterndb.core.code import Code, format_id, pattern_id, pattern_ids
from patterndb.core.packing import pack, take_rows
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import ORIGINS
from patterndb.core.reduction import reduce_disk
from patterndb.core.shortcode import lengthen, pack_symbols, restore, shorten
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store.reading import find_mesh, select_meshes, sum_occurrences
from patterndb.store.records import (
    INSERT_OCCURRENCE,
    INSERT_PATTERN,
    Learned,
    Mesh,
    OccurrenceRow,
    PatternRow,
    Provenance,
    make_insert,
)

#: Patterns of a mesh that are described and written at a time: some ten megabytes, however many it
#: has.
WRITTEN_AT_ONCE = 20_000

#: Uses are kept in 63 bits; this many at once is a slip.
MOST_AT_ONCE = 1 << 40

#: Bytes of the hash that stands for a signature: among ten million, two that are equal by chance
#: are not to be expected.
SIGNATURE_SIZE = 8


def describe_patterns(short: Sequence[bytes]) -> list[PatternRow]:
    """Return the rows of the patterns of short codes.

    Raises InvalidCodeError, with its row, if one is not the canonical code of a disk.
    """
    symbols, offsets = restore(short)
    described = d.describe_symbols(symbols, offsets)
    following = [d.N_CORNERS, d.N_REFLEX, d.N_QUADS, d.N_IRREGULAR, d.CHIRAL]
    codes = pack_symbols(symbols, offsets)[:]
    signatures = described.split(d.SIGNATURE)
    return [
        PatternRow(
            pattern_id(code, n_sides),
            stored,
            n_sides,
            n_reflex,
            n_quads,
            n_irregular,
            chiral,
            hashlib.blake2b(signature, digest_size=SIGNATURE_SIZE).digest(),
        )
        for code, stored, (n_sides, n_reflex, n_quads, n_irregular, chiral), signature in zip(
            codes, short, described.counts[:, following].tolist(), signatures, strict=True
        )
    ]


def insert_mesh(
    connection: sqlite3.Connection, mesh: Mesh, occurrence_sum: bytes, mesh_id: int | None = None
) -> int:
    """Write the row of a mesh; return its id."""
    values = {"id": mesh_id, **mesh.to_columns(), "occurrence_sum": occurrence_sum}
    cursor = connection.execute(make_insert("mesh", list(values)), list(values.values()))
    return cursor.lastrowid or 0


def add_mesh(connection: sqlite3.Connection, mesh: Mesh, learned: Learned) -> int:
    """Write a mesh that is not there yet, its patterns and occurrences.

    Returns how many of its patterns are new to the database.
    """
    mesh_id = insert_mesh(connection, mesh, bytes(16))
    ids = pattern_ids(learned.codes, learned.sides)
    # In the order of the tables' keys, so that they are written front to back.
    order = np.argsort(ids)
    fresh = total = 0
    for first in range(0, len(order), WRITTEN_AT_ONCE):
        some = order[first : first + WRITTEN_AT_ONCE]
        numbers = ids[some].tolist()
        fresh += add_patterns(connection, numbers, take_rows(learned.codes, some)[:])
        occurrences = [
            OccurrenceRow(number, mesh_id, own + mirrored, mirrored, example)
            for number, (own, mirrored), example in zip(
                numbers,
                learned.patches[some].tolist(),
                take_rows(learned.examples, some)[:],
                strict=True,
            )
        ]
        connection.executemany(INSERT_OCCURRENCE, occurrences)
        total = sum_occurrences(occurrences, total)
    connection.execute(
        "UPDATE mesh SET occurrence_sum = ? WHERE id = ?", (total.to_bytes(16, "big"), mesh_id)
    )
    return fresh


def add_patterns(connection: sqlite3.Connection, ids: Sequence[int], codes: Sequence[bytes]) -> int:
    """Write those of the patterns (packed canonical codes) that are missing; return how many.

    Raises InvalidCodeError if one is not the canonical code of a disk, DatabaseError if an id
    does not follow from its code or stands for another one already.
    """
    incoming = dict(zip(ids, shorten(codes), strict=True))
    held = connection.execute(
        "SELECT id, code FROM pattern WHERE id IN (SELECT value FROM json_each(?))",
        (json.dumps(list(incoming)),),
    )
    for number, code in held.fetchall():
        if incoming.pop(number) != code:
            raise DatabaseError(
                f"two patterns have the id {format_id(number)}: their hashes collide"
            )
    missing = sorted(incoming)
    rows = describe_patterns([incoming[number] for number in missing])
    for number, row in zip(missing, rows, strict=True):
        if number != row.id:
            raise DatabaseError(
                f"the id {format_id(number)} does not follow from the pattern's code"
            )
    connection.executemany(INSERT_PATTERN, rows)
    return len(rows)


def update_provenance(
    connection: sqlite3.Connection, sha256: bytes, name: str, provenance: Provenance
) -> None:
    """Change the name of a mesh and where it comes from."""
    connection.execute(
        "UPDATE mesh SET name = ?, author = ?, source = ?, licence = ? WHERE sha256 = ?",
        (name, provenance.author, provenance.source, provenance.licence, sha256),
    )


def remove_meshes(connection: sqlite3.Connection, mesh_ids: Iterable[int]) -> int:
    """Take meshes out, with the patterns that no other mesh has and that were never used;
    return how many patterns went."""
    removed = 0
    for mesh_id in mesh_ids:
        alone = connection.execute(
            "SELECT pattern_id FROM occurrence AS here WHERE mesh_id = ? AND NOT EXISTS ("
            "SELECT 1 FROM occurrence WHERE pattern_id = here.pattern_id AND mesh_id <> ?"
            ") AND pattern_id NOT IN (SELECT pattern_id FROM usage)",
            (mesh_id, mesh_id),
        ).fetchall()
        connection.execute("DELETE FROM occurrence WHERE mesh_id = ?", (mesh_id,))
        connection.executemany("DELETE FROM pattern WHERE id = ?", alone)
        connection.execute("DELETE FROM mesh WHERE id = ?", (mesh_id,))
        removed += len(alone)
    return removed


class _CodedOccurrence(NamedTuple):
    """An occurrence of a mesh of another database, with the short code of its pattern."""

    pattern_id: int
    code: bytes
    patches: int
    mirrored_patches: int
    example: bytes


def merge_database(
    connection: sqlite3.Connection, other: sqlite3.Connection
) -> tuple[int, int, int]:
    """Add the meshes of another database, which is sound; return (added, replaced, already there).

    A mesh that is here with the same options stays; one learned with other options is
    replaced, as ingesting it again would. How often patterns were used is not taken over:
    merging twice would count it twice.
    """
    added = replaced = same = 0
    for row in select_meshes(other, "ORDER BY sha256"):
        mesh = Mesh.from_columns(row)
        here = find_mesh(connection, row["sha256"])
        if here is not None:
            if here.options == mesh.options:
                same += 1
                continue
            held = connection.execute("SELECT id FROM mesh WHERE sha256 = ?", (row["sha256"],))
            remove_meshes(connection, [number for (number,) in held.fetchall()])
            replaced += 1
        else:
            added += 1
        mesh_id = insert_mesh(connection, mesh, row["occurrence_sum"])
        rows = other.execute(
            f"SELECT {', '.join(_CodedOccurrence._fields)} FROM occurrence "  # noqa: S608
            "JOIN pattern ON pattern.id = pattern_id WHERE mesh_id = ? ORDER BY pattern_id",
            (row["id"],),
        )
        while some := list(map(_CodedOccurrence._make, rows.fetchmany(WRITTEN_AT_ONCE))):
            codes = lengthen([one.code for one in some])
            add_patterns(connection, [one.pattern_id for one in some], codes)
            connection.executemany(
                INSERT_OCCURRENCE,
                (
                    OccurrenceRow(
                        one.pattern_id, mesh_id, one.patches, one.mirrored_patches, one.example
                    )
                    for one in some
                ),
            )
    return added, replaced, same


def check_use(pattern: Pattern | Code, count: int) -> Pattern:
    """Return the pattern to be recorded, of itself or of its code.

    Raises InvalidCodeError if a code is not canonical or can be reduced further, ValueError
    for a count below 1 or an origin that is not one of ORIGINS.
    """
    if not 1 <= count <= MOST_AT_ONCE:
        raise ValueError(f"count must lie in 1..{MOST_AT_ONCE}, not {count}")
    if not isinstance(pattern, Pattern):
        pattern = Pattern.from_code(np.asarray(pattern))
    if pattern.origin not in ORIGINS:
        raise ValueError(f"the origin of a pattern is one of {ORIGINS}, not {pattern.origin!r}")
    twin = pattern.twin()
    if len(reduce_disk(twin)) != len(twin):
        raise InvalidCodeError(
            "the pattern can be reduced further; record the one that its fill reduces to"
        )
    return pattern


def record_use(connection: sqlite3.Connection, pattern: Pattern, count: int) -> int:
    """Count the pattern's use; return how often it was used now."""
    add_patterns(connection, [pattern.id], [pack(pattern.code)])
    return connection.execute(
        "INSERT INTO usage (pattern_id, uses, origin) "
        "SELECT id, ?, coalesce(origin, ?) FROM counted_pattern WHERE id = ? "
        "ON CONFLICT (pattern_id) DO UPDATE SET uses = uses + excluded.uses RETURNING uses",
        (count, pattern.origin, pattern.id),
    ).fetchone()[0]
