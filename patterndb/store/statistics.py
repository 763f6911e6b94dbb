"""Statistics: counts over all rows of a database, which its writes keep."""

from __future__ import annotations

import sqlite3
from collections import Counter

from patterndb.store.contents import hash_content
from patterndb.store.records import Statistics
from patterndb.store.tallies import count_signatures, read_handednesses, read_tally


def count_by_sides(connection: sqlite3.Connection) -> dict[int, int]:
    """Patterns by number of sides."""
    return _count_by(0, read_tally(connection))


def _count_by(column: int, tally: list[tuple[int, int, int, int]]) -> dict[int, int]:
    counts: Counter[int] = Counter()
    for row in tally:
        counts[row[column]] += row[-1]
    return dict(sorted(counts.items()))


def read_statistics(connection: sqlite3.Connection) -> Statistics:
    """Counts over the whole database, beside its content hash."""
    tally = read_tally(connection)
    chirality = _count_by(2, tally)
    patterns = sum(chirality.values())
    meshes, patches = connection.execute(
        "SELECT count(*), coalesce(sum(distinct_patches), 0) FROM mesh"
    ).fetchone()
    return Statistics(
        patterns=patterns,
        patterns_oriented=patterns + chirality.get(1, 0),
        patterns_met=read_handednesses(connection),
        by_sides=_count_by(0, tally),
        by_irregular=_count_by(1, tally),
        signatures=count_signatures(connection),
        meshes=meshes,
        patches=patches,
        content_hash=hash_content(connection),
    )
