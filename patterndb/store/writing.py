"""Changes to a database. Every function here belongs inside one atomic()."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Sequence

from patterndb.core import description as d
from patterndb.core.code import format_id, pattern_id
from patterndb.errors import DatabaseError
from patterndb.store import columns
from patterndb.store.records import Learned, LearningOptions, Provenance


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
        columns.INSERT_MESH,
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
        ),
    )
    mesh_id = cursor.lastrowid
    ids = [
        pattern_id(code, sides)
        for code, sides in zip(learned.codes, learned.sides.tolist(), strict=True)
    ]
    fresh = add_patterns(connection, ids, learned.codes)
    connection.executemany(
        columns.INSERT_OCCURRENCE,
        # In the order of the table's key, so that it is written front to back.
        sorted(
            (i, mesh_id, own + mirrored, mirrored, example)
            for i, (own, mirrored), example in zip(
                ids, learned.patches.tolist(), learned.examples, strict=True
            )
        ),
    )
    return fresh


def add_patterns(
    connection: sqlite3.Connection,
    ids: Sequence[int],
    codes: Sequence[bytes],
    origin: str = "learned",
) -> int:
    """Write those of the patterns (packed canonical codes) that are missing; return how many.

    origin: what they are until occurrences say it.

    Raises InvalidCodeError if one is not the canonical code of a disk, DatabaseError if an id
    does not follow from its code or stands for another one already.
    """
    connection.execute("CREATE TEMP TABLE incoming (id INTEGER PRIMARY KEY, code BLOB NOT NULL)")
    try:
        connection.executemany("INSERT INTO incoming VALUES (?, ?)", zip(ids, codes, strict=True))
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
    rows = d.describe([code for _, code in missing])
    lists = rows.packed()
    patterns: list[tuple[object, ...]] = []
    for i, ((number, code), counts) in enumerate(zip(missing, rows.counts.tolist(), strict=True)):
        if number != pattern_id(code, counts[d.N_CORNERS]):
            raise DatabaseError(
                f"the id {format_id(number)} does not follow from the pattern's code"
            )
        own = lists[d.LISTS * i : d.LISTS * (i + 1)]
        patterns.append((number, code, *columns.derived(counts, own), origin))
    connection.executemany(columns.INSERT_PATTERN, patterns)
    return len(patterns)


def set_provenance(
    connection: sqlite3.Connection, sha256: bytes, name: str, provenance: Provenance
) -> None:
    """Change what is said of where a mesh comes from."""
    connection.execute(
        "UPDATE mesh SET name = ?, author = ?, source = ?, licence = ? WHERE sha256 = ?",
        (name, provenance.author, provenance.source, provenance.licence, sha256),
    )


def remove_meshes(connection: sqlite3.Connection, mesh_ids: Iterable[int]) -> int:
    """Take meshes out, with the patterns that no other mesh holds and that were never used;
    return how many went."""
    for mesh_id in mesh_ids:
        connection.execute("DELETE FROM occurrence WHERE mesh_id = ?", (mesh_id,))
        connection.execute("DELETE FROM mesh WHERE id = ?", (mesh_id,))
    return connection.execute(
        "DELETE FROM pattern WHERE frequency = 0 AND id NOT IN (SELECT pattern_id FROM usage)"
    ).rowcount


def merge(connection: sqlite3.Connection, other: sqlite3.Connection) -> tuple[int, int, int]:
    """Add the meshes of another database; return (added, replaced, already there).

    A mesh that is here with the same options stays; one learned with other options is
    replaced, as ingesting it again would. How often patterns were used is not taken over:
    merging twice would count it twice.
    """
    added = replaced = same = 0
    for row in other.execute(columns.SELECT_MESHES):
        other_id, *values = row
        here = connection.execute(
            "SELECT id, basic_limit, side_limit, convex_limit, prepared FROM mesh WHERE sha256 = ?",
            (values[0],),
        ).fetchone()
        if here is not None:
            if here[1:] == tuple(values[columns.OPTIONS]):
                same += 1
                continue
            remove_meshes(connection, [here[0]])
            replaced += 1
        else:
            added += 1
        mesh_id = connection.execute(columns.INSERT_MESH, values).lastrowid
        rows = other.execute(
            "SELECT pattern.id, code, patches, mirrored_patches, example FROM occurrence "
            "JOIN pattern ON pattern.id = pattern_id WHERE mesh_id = ? ORDER BY pattern.id",
            (other_id,),
        ).fetchall()
        add_patterns(connection, [r[0] for r in rows], [r[1] for r in rows])
        connection.executemany(
            columns.INSERT_OCCURRENCE,
            ((r[0], mesh_id, r[2], r[3], r[4]) for r in rows),
        )
    return added, replaced, same
