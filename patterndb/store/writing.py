"""Changes to a database. Every function here belongs inside one atomic()."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Sequence

from patterndb import description as d
from patterndb.code import format_id, pattern_id
from patterndb.errors import DatabaseError
from patterndb.store.records import Learned, LearningOptions, Provenance

_INSERT_PATTERN = """
INSERT INTO pattern (id, code, n_sides, corners, n_reflex, n_quads, n_irregular, valences,
    n_chords, n_loops, self_crossing, rotations, chiral, label, signature, sig_rotation,
    sig_reflected, lengths, joins)
VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)
"""

_INSERT_MESH = """
INSERT INTO mesh (sha256, name, author, source, licence, basic_limit, side_limit, convex_limit,
    prepared, quads_read, quads_used, basic_patches, side_patches, convex_patches,
    distinct_patches)
VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)
"""


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
        _INSERT_MESH,
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
        ),
    )
    mesh_id = cursor.lastrowid
    ids = [
        pattern_id(code, sides)
        for code, sides in zip(learned.codes, learned.sides.tolist(), strict=True)
    ]
    fresh = add_patterns(connection, ids, learned.codes)
    connection.executemany(
        "INSERT INTO occurrence (pattern_id, mesh_id, patches, mirrored_patches, example) "
        "VALUES (?, ?, ?, ?, ?)",
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
) -> int:
    """Write those of the patterns (packed canonical codes) that are missing; return how many.

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
        corners, valences, label, signature, lengths, joins = lists[d.LISTS * i : d.LISTS * (i + 1)]
        if number != pattern_id(code, counts[d.N_CORNERS]):
            raise DatabaseError(
                f"the id {format_id(number)} does not follow from the pattern's code"
            )
        patterns.append(
            (
                number,
                code,
                counts[d.N_CORNERS],
                corners,
                counts[d.N_REFLEX],
                counts[d.N_QUADS],
                counts[d.N_IRREGULAR],
                valences,
                counts[d.N_CHORDS],
                counts[d.N_LOOPS],
                counts[d.SELF_CROSSING],
                counts[d.ROTATIONS],
                counts[d.CHIRAL],
                label,
                signature,
                counts[d.SIG_ROTATION],
                counts[d.SIG_REFLECTED],
                lengths,
                joins,
            )
        )
    connection.executemany(_INSERT_PATTERN, patterns)
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
    """Take meshes out, with the patterns that no other mesh holds; return how many went."""
    for mesh_id in mesh_ids:
        connection.execute("DELETE FROM occurrence WHERE mesh_id = ?", (mesh_id,))
        connection.execute("DELETE FROM mesh WHERE id = ?", (mesh_id,))
    gone = connection.execute("DELETE FROM pattern WHERE frequency = 0").rowcount
    return gone


def merge(connection: sqlite3.Connection, other: sqlite3.Connection) -> tuple[int, int, int]:
    """Add the meshes of another database; return (added, replaced, already there).

    A mesh that is here with the same options stays; one learned with other options is
    replaced, as ingesting it again would.
    """
    added = replaced = same = 0
    columns = (
        "sha256, name, author, source, licence, basic_limit, side_limit, convex_limit, "
        "prepared, quads_read, quads_used, basic_patches, side_patches, convex_patches, "
        "distinct_patches"
    )
    for row in other.execute(f"SELECT id, {columns} FROM mesh ORDER BY sha256"):  # noqa: S608
        other_id, *values = row
        here = connection.execute(
            "SELECT id, basic_limit, side_limit, convex_limit, prepared FROM mesh WHERE sha256 = ?",
            (values[0],),
        ).fetchone()
        if here is not None:
            if here[1:] == tuple(values[5:9]):
                same += 1
                continue
            remove_meshes(connection, [here[0]])
            replaced += 1
        else:
            added += 1
        mesh_id = connection.execute(_INSERT_MESH, values).lastrowid
        rows = other.execute(
            "SELECT pattern.id, code, patches, mirrored_patches, example FROM occurrence "
            "JOIN pattern ON pattern.id = pattern_id WHERE mesh_id = ? ORDER BY pattern.id",
            (other_id,),
        ).fetchall()
        add_patterns(connection, [r[0] for r in rows], [r[1] for r in rows])
        connection.executemany(
            "INSERT INTO occurrence (pattern_id, mesh_id, patches, mirrored_patches, example) "
            "VALUES (?, ?, ?, ?, ?)",
            ((r[0], mesh_id, r[2], r[3], r[4]) for r in rows),
        )
    return added, replaced, same
