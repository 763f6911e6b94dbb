"""The content of a database as one hash, and the check that it is what it claims to be."""

from __future__ import annotations

import hashlib
import sqlite3

import numpy as np

from patterndb.core import description as d
from patterndb.core.code import canonical_code, decode, format_id, pattern_id
from patterndb.core.disk import Disk
from patterndb.core.packing import unpack
from patterndb.core.reduction import reduce_disk
from patterndb.errors import PatternDBError
from patterndb.store import writing

#: Findings after which verify() stops listing; a damaged database has as many as rows.
MAX_FINDINGS = 100


def hash_content(connection: sqlite3.Connection) -> str:
    """SHA-256 over meshes, patterns and occurrences, whatever order they came in.

    Equal hashes mean that the same was learned. Row ids, which depend on the order of
    ingestion, and everything that follows from a pattern's code are left out; so is how often
    patterns were used, with those that are there for nothing else.
    """
    total = hashlib.sha256()
    rank: dict[int, int] = {}
    for number, (mesh_id, *row) in enumerate(connection.execute(writing.SELECT_MESHES)):
        rank[mesh_id] = number
        # Learned meshes are hashed as in version 1 of the schema, which knew no others.
        total.update(repr(row[:-1] if row[-1] == "learned" else row).encode())
    for row in connection.execute("SELECT id, code FROM pattern WHERE frequency > 0 ORDER BY id"):
        total.update(repr(row).encode())
    # Row order within a pattern follows mesh ids, so it is sorted anew by the meshes' rank.
    group: list[tuple[int, ...]] = []
    current = None
    for pattern, mesh_id, patches, mirrored, example in connection.execute(
        "SELECT pattern_id, mesh_id, patches, mirrored_patches, example FROM occurrence "
        "ORDER BY pattern_id"
    ):
        if pattern != current:
            total.update(repr(sorted(group)).encode())
            group.clear()
            current = pattern
        group.append((pattern, rank[mesh_id], patches, mirrored, example))
    total.update(repr(sorted(group)).encode())
    return total.hexdigest()


#: Every pattern whose frequency or origin does not follow from its occurrences and uses.
_COUNTED = """
SELECT id, frequency, total, pattern.origin, coalesce(met, usage.origin) AS expected
FROM pattern LEFT JOIN usage ON usage.pattern_id = pattern.id JOIN (
    SELECT pattern.id AS counted, coalesce(sum(patches), 0) AS total, max(mesh.origin) AS met
    FROM pattern
        LEFT JOIN occurrence ON occurrence.pattern_id = pattern.id
        LEFT JOIN mesh ON mesh.id = mesh_id
    GROUP BY pattern.id
) ON counted = pattern.id
WHERE frequency <> total OR expected IS NULL OR pattern.origin <> expected
"""


def verify(connection: sqlite3.Connection) -> list[str]:
    """Everything that is wrong with the database, in words; empty where it is sound.

    Checks the file (SQLite's own integrity and foreign keys), every pattern (its code is a
    canonical disk's, reduced, its id and columns follow from it), that frequencies are the
    sums of the occurrences and origins follow from them, and that every pattern occurs in a
    mesh or was used.
    """
    try:
        return _findings(connection)[:MAX_FINDINGS]
    except sqlite3.DatabaseError as error:
        return [f"SQLite: {error}"]


def _findings(connection: sqlite3.Connection) -> list[str]:
    found = [f"SQLite: {row[0]}" for row in connection.execute("PRAGMA integrity_check(20)")]
    found = [] if found == ["SQLite: ok"] else found
    found += [
        f"row {row[1]} of {row[0]} refers to a row of {row[2]} that is missing"
        for row in connection.execute("PRAGMA foreign_key_check")
    ]
    for number, frequency, patches, origin, expected in connection.execute(_COUNTED):
        if frequency != patches or expected is None:
            found.append(
                f"pattern {format_id(number)} has frequency {frequency}, but {patches} patches"
                + ("" if patches else ", and was never used")
            )
        elif origin != expected:
            found.append(f"pattern {format_id(number)} is {expected}, but said to be {origin}")
    for name, patches, mirrored in connection.execute(
        "SELECT mesh.name, sum(patches), distinct_patches FROM mesh "
        "LEFT JOIN occurrence ON mesh_id = mesh.id GROUP BY mesh.id "
        "HAVING coalesce(sum(patches), 0) <> distinct_patches"
    ):
        found.append(f"mesh {name} has {patches} patches in its patterns, but counted {mirrored}")
    return found + _check_patterns(connection)


def _check_patterns(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    for number, packed, *stored in connection.execute(writing.SELECT_PATTERNS):
        if len(found) >= MAX_FINDINGS:
            break
        try:
            code = unpack(packed).astype(np.uint16)
            twin = decode(code)
            Disk.from_twin(twin)
            if not np.array_equal(canonical_code(twin)[0], code):
                found.append(f"pattern {format_id(number)} has a code that is not canonical")
                continue
            if len(reduce_disk(twin)) != len(twin):
                found.append(f"pattern {format_id(number)} can be reduced further")
                continue
        except (PatternDBError, ValueError) as error:
            found.append(f"pattern {format_id(number)}: {error}")
            continue
        rows = d.describe([code])
        counts: list[int] = rows.counts[0].tolist()
        expected = list(writing.derive_columns(counts, rows.packed()))
        if stored != expected or number != pattern_id(packed, counts[d.N_CORNERS]):
            found.append(
                f"pattern {format_id(number)} has columns that do not follow from its code"
            )
    return found
