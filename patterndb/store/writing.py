"""Change a database: meshes, their patterns and occurrences, and how often fills were used.

Every function that takes a connection belongs inside one atomic(). The columns of schema.sql
stand here, for the statements that name them all.

A pattern that no mesh holds (a query made it, or another database learned it) is written when it
is first used, and says what it was then. Uses are no part of what was learned: they are neither in
the content hash nor merged nor in the compact file.
"""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Collection, Iterable, Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from patterndb.core import description as d
from patterndb.core.code import Code, format_id, pattern_id, pattern_ids
from patterndb.core.packing import pack, take_rows
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import ORIGINS
from patterndb.core.reduction import reduce_disk
from patterndb.core.shortcode import lengthen, pack_symbols, restore, shorten
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store.checksums import (
    add_to_sum,
    select_rows,
    sum_rows,
    summed,
    write_occurrence_sum,
)
from patterndb.store.records import Learned, LearningOptions, Provenance
from patterndb.store.tallies import (
    SIGNATURE_SIZE,
    TALLIED,
    add_met,
    add_tallied,
    removing_occurrences,
    take_off_tallied,
)

#: Patterns of a mesh that are described and written at a time: some ten megabytes, however many it
#: has.
WRITTEN_AT_ONCE = 20_000

#: Uses are kept in 63 bits; this many at once is a slip.
MOST_AT_ONCE = 1 << 40

MESH = (
    "sha256, name, author, source, licence, basic_limit, side_limit, convex_limit, prepared, "
    "quads_read, quads_used, basic_patches, side_patches, convex_patches, distinct_patches, "
    "origin, pattern_limit, patterns_left_out"
)
#: Picks the columns of the learning options from those of a mesh.
pick_options = itemgetter(5, 6, 7, 8, 16)

#: What a row of a pattern says of its code; :func:`describe_patterns` gives the values.
_DESCRIBED = "code, n_sides, n_reflex, n_quads, n_irregular, chiral, signature"


def _marks(columns: str) -> str:
    return ", ".join("?" for _ in columns.split(","))


# All put together from the constants above, and from nothing else.
SELECT_MESHES = f"SELECT id, {MESH} FROM mesh ORDER BY sha256"  # noqa: S608
INSERT_MESH = f"INSERT INTO mesh ({MESH}) VALUES ({_marks(MESH)})"  # noqa: S608
INSERT_MESH_WITH_ID = f"INSERT INTO mesh (id, {MESH}) VALUES (?, {_marks(MESH)})"  # noqa: S608
SELECT_PATTERNS = f"SELECT id, {_DESCRIBED} FROM pattern"  # noqa: S608
INSERT_PATTERN = (
    f"INSERT INTO pattern (id, {_DESCRIBED}, origin) "  # noqa: S608
    f"VALUES (?, {_marks(_DESCRIBED)}, ?)"
)
#: Picks what is tallied of a pattern from its described columns.
pick_tallied = itemgetter(*(_DESCRIBED.split(", ").index(name) for name in TALLIED.split(", ")))
#: As INSERT_PATTERN, with the frequency, for who writes occurrences without the triggers.
INSERT_COUNTED_PATTERN = (
    f"INSERT INTO pattern (id, {_DESCRIBED}, origin, frequency) "  # noqa: S608
    f"VALUES (?, {_marks(_DESCRIBED)}, ?, ?)"
)
INSERT_OCCURRENCE = (
    "INSERT INTO occurrence (pattern_id, mesh_id, patches, mirrored_patches, example) "
    "VALUES (?, ?, ?, ?, ?)"
)


def describe_patterns(short: Sequence[bytes]) -> list[tuple[int, tuple[Any, ...]]]:
    """Id and described columns of the patterns of short codes.

    Raises InvalidCodeError, with its row, if one is not the canonical code of a disk.
    """
    symbols, offsets = restore(short)
    told = d.describe_symbols(symbols, offsets)
    following = [d.N_CORNERS, d.N_REFLEX, d.N_QUADS, d.N_IRREGULAR, d.CHIRAL]
    counts = told.counts[:, following].tolist()
    return [
        (pattern_id(code, own[0]), (stored, *own, hash_signature(signature)))
        for code, stored, own, signature in zip(
            pack_symbols(symbols, offsets)[:], short, counts, told.split(d.SIGNATURE), strict=True
        )
    ]


def hash_signature(signature: bytes) -> bytes:
    """What stands for a signature (its numbers, 16 bits each) in the table of patterns."""
    return hashlib.blake2b(signature, digest_size=SIGNATURE_SIZE).digest()


def add_mesh(
    connection: sqlite3.Connection,
    name: str,
    sha256: bytes,
    provenance: Provenance,
    options: LearningOptions,
    learned: Learned,
) -> int:
    """Write a mesh that is not there yet, its patterns and occurrences.

    Returns how many of its patterns are new to the database.
    """
    cursor = connection.execute(
        INSERT_MESH,
        (
            sha256,
            name,
            provenance.author,
            provenance.source,
            provenance.licence,
            options.basic,
            options.side,
            options.convex,
            options.prepare,
            learned.quads_read,
            learned.quads_used,
            learned.basic,
            learned.side,
            learned.convex,
            learned.distinct,
            learned.origin,
            options.most_patterns,
            learned.left_out,
        ),
    )
    mesh_id = cursor.lastrowid or 0
    ids = pattern_ids(learned.codes, learned.sides)
    # In the order of the tables' keys, so that they are written front to back.
    order = np.argsort(ids)
    fresh = total = 0
    for first in range(0, len(order), WRITTEN_AT_ONCE):
        some = order[first : first + WRITTEN_AT_ONCE]
        numbers = ids[some].tolist()
        new = add_patterns(connection, numbers, take_rows(learned.codes, some)[:])
        fresh += len(new)
        occurrences = [
            (number, own + mirrored, mirrored, example)
            for number, (own, mirrored), example in zip(
                numbers,
                learned.patches[some].tolist(),
                take_rows(learned.examples, some)[:],
                strict=True,
            )
        ]
        total += _add_occurrences(connection, mesh_id, occurrences, new)
    _sum_mesh(connection, mesh_id, total)
    return fresh


def _add_occurrences(
    connection: sqlite3.Connection,
    mesh_id: int,
    rows: Sequence[tuple[Any, ...]],
    new: Collection[int],
) -> int:
    """Write occurrences of a mesh, each a row but for the mesh; return the sum of their hashes.

    new: which of their patterns were written for them."""
    add_met(connection, (row[:3] for row in rows), new)
    connection.executemany(INSERT_OCCURRENCE, ((row[0], mesh_id, *row[1:]) for row in rows))
    return sum_rows(rows)


def _sum_mesh(connection: sqlite3.Connection, mesh_id: int, total: int) -> None:
    """Write the sum of the occurrences of a mesh that is new, and add its row to that of meshes."""
    write_occurrence_sum(connection, mesh_id, total)
    add_to_sum(connection, "mesh", sum_rows(select_rows(connection, "mesh", "id = ?", (mesh_id,))))


def add_patterns(
    connection: sqlite3.Connection,
    ids: Sequence[int],
    codes: Sequence[bytes],
    origin: str = "learned",
) -> set[int]:
    """Write those of the patterns (packed canonical codes) that are missing; return their ids.

    origin: what they are until occurrences say it.

    Raises InvalidCodeError if one is not the canonical code of a disk, DatabaseError if an id
    does not follow from its code or stands for another one already.
    """
    connection.execute("CREATE TEMP TABLE incoming (id INTEGER PRIMARY KEY, code BLOB NOT NULL)")
    try:
        connection.executemany(
            "INSERT INTO incoming VALUES (?, ?)", zip(ids, shorten(codes), strict=True)
        )
        clash = connection.execute(
            "SELECT incoming.id FROM incoming JOIN pattern USING (id) "
            "WHERE pattern.code <> incoming.code"
        ).fetchone()
        if clash:
            raise DatabaseError(
                f"two patterns have the id {format_id(clash[0])}: their hashes collide"
            )
        missing = connection.execute(
            "SELECT id, code FROM incoming WHERE id NOT IN (SELECT id FROM pattern) ORDER BY id"
        ).fetchall()
    finally:
        connection.execute("DROP TABLE incoming")
    described = describe_patterns([short for _, short in missing])
    for (number, _), (expected, _) in zip(missing, described, strict=True):
        if number != expected:
            raise DatabaseError(
                f"the id {format_id(number)} does not follow from the pattern's code"
            )
    connection.executemany(
        INSERT_PATTERN, ((number, *columns, origin) for number, columns in described)
    )
    add_tallied(connection, [pick_tallied(columns) for _, columns in described])
    return {number for number, _ in missing}


def set_provenance(
    connection: sqlite3.Connection, sha256: bytes, name: str, provenance: Provenance
) -> None:
    """Change what is said of where a mesh comes from."""
    with summed(connection, "mesh", "sha256 = ?", (sha256,)):
        connection.execute(
            "UPDATE mesh SET name = ?, author = ?, source = ?, licence = ? WHERE sha256 = ?",
            (name, provenance.author, provenance.source, provenance.licence, sha256),
        )


def remove_meshes(connection: sqlite3.Connection, mesh_ids: Iterable[int]) -> int:
    """Take meshes out, with the patterns that no other mesh holds and that were never used;
    return how many went."""
    for mesh_id in mesh_ids:
        with removing_occurrences(connection, mesh_id):
            connection.execute("DELETE FROM occurrence WHERE mesh_id = ?", (mesh_id,))
        with summed(connection, "mesh", "id = ?", (mesh_id,)):
            connection.execute("DELETE FROM mesh WHERE id = ?", (mesh_id,))
    gone = connection.execute(
        "DELETE FROM pattern WHERE frequency = 0 "  # noqa: S608
        "AND id NOT IN (SELECT pattern_id FROM usage) "
        f"RETURNING {TALLIED}"
    ).fetchall()
    take_off_tallied(connection, gone)
    return len(gone)


def merge_database(
    connection: sqlite3.Connection, other: sqlite3.Connection
) -> tuple[int, int, int]:
    """Add the meshes of another database; return (added, replaced, already there).

    A mesh that is here with the same options stays; one learned with other options is
    replaced, as ingesting it again would. How often patterns were used is not taken over:
    merging twice would count it twice.
    """
    added = replaced = same = 0
    for row in other.execute(SELECT_MESHES):
        other_id, *values = row
        here = connection.execute(
            "SELECT id, basic_limit, side_limit, convex_limit, prepared, pattern_limit FROM mesh "
            "WHERE sha256 = ?",
            (values[0],),
        ).fetchone()
        if here is not None:
            if here[1:] == pick_options(values):
                same += 1
                continue
            remove_meshes(connection, [here[0]])
            replaced += 1
        else:
            added += 1
        mesh_id = connection.execute(INSERT_MESH, values).lastrowid or 0
        rows = other.execute(
            "SELECT pattern.id, code, patches, mirrored_patches, example FROM occurrence "
            "JOIN pattern ON pattern.id = pattern_id WHERE mesh_id = ? ORDER BY pattern_id",
            (other_id,),
        )
        total = 0
        while some := rows.fetchmany(WRITTEN_AT_ONCE):
            new = add_patterns(connection, [r[0] for r in some], lengthen([r[1] for r in some]))
            occurrences = [(r[0], *r[2:]) for r in some]
            total += _add_occurrences(connection, mesh_id, occurrences, new)
        _sum_mesh(connection, mesh_id, total)
    return added, replaced, same


def check_use(pattern: Pattern | Code, count: int) -> Pattern:
    """The pattern to be recorded, of itself or of its code.

    Raises InvalidCodeError if a code is not canonical or can be reduced further, ValueError
    for a count below 1 or an origin that is none of ORIGINS.
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
    """Count the pattern's use; return how often it was used now. Belongs inside atomic()."""
    add_patterns(connection, [pattern.id], [pack(pattern.code)], pattern.origin)
    with summed(connection, "usage", "pattern_id = ?", (pattern.id,)):
        return connection.execute(
            "INSERT INTO usage (pattern_id, uses, origin) "
            "SELECT id, ?, CASE frequency WHEN 0 THEN ? ELSE origin END FROM pattern WHERE id = ? "
            "ON CONFLICT (pattern_id) DO UPDATE SET uses = uses + excluded.uses RETURNING uses",
            (count, pattern.origin, pattern.id),
        ).fetchone()[0]
