"""Statistics: counts over all rows of a database."""

from __future__ import annotations

import sqlite3

import numpy as np
from numpy.typing import NDArray

from patterndb.store.columns import MOST_64
from patterndb.store.records import Statistics


def count_by_sides(connection: sqlite3.Connection) -> dict[int, int]:
    """Patterns by number of sides."""
    query = "SELECT n_sides, count(*) FROM pattern GROUP BY 1 ORDER BY 1"
    return dict(connection.execute(query).fetchall())


#: Patterns whose columns statistics read at a time: some megabytes.
COUNTED_AT_ONCE = 500_000

#: Digits in which statistics read a number, and bytes of a signature's hash.
_DIGITS, _SIGNATURE = 6, 8

#: Of the first ids of a range: the largest, how many, how many are chiral, the least and the
#: greatest number, and for each the signature and the numbers of irregular vertices and sides as
#: decimals, all in one blob. That SQLite makes in a third of the time that it needs to sort or to
#: hand over rows.
_SELECT_COUNTED = """
SELECT max(id), count(*), sum(chiral), min(min(n_irregular, n_sides)),
    max(max(n_irregular, n_sides)), CAST(group_concat(
        signature || substr(1000000000000 + 1000000 * n_irregular + n_sides, 2), ''
    ) AS BLOB)
FROM (
    SELECT id, signature, n_irregular, n_sides, chiral FROM pattern
    WHERE id BETWEEN ? AND ? ORDER BY id LIMIT ?
)
"""


class _PatternCounts:
    """What statistics count of patterns, in one look at each row, class by class.

    patterns, chiral, signatures: how many. sides, irregular: how many have so many, by number.
    """

    def __init__(self, connection: sqlite3.Connection) -> None:
        self.patterns = self.chiral = self.signatures = 0
        self._sides = self._irregular = np.zeros(0, np.int64)
        low = -1 << 63
        while (first := self._find_next(connection, low)) is not None:
            # Patterns of one signature have one number of sides, and so are of one class.
            low = (first | ((1 << 56) - 1)) + 1
            parts: list[NDArray[np.uint64]] = []
            at: int = first
            while at < low:
                row = connection.execute(_SELECT_COUNTED, (at, low - 1, COUNTED_AT_ONCE)).fetchone()
                if not row[1]:
                    break
                parts.append(self._count(*row[1:]))
                at = row[0] + 1
            self.signatures += len(np.unique(np.concatenate(parts)))
            if low > MOST_64:
                break

    @staticmethod
    def _find_next(connection: sqlite3.Connection, low: int) -> int | None:
        return connection.execute("SELECT min(id) FROM pattern WHERE id >= ?", (low,)).fetchone()[0]

    def _count(
        self, patterns: int, chiral: int, least: int, greatest: int, told: bytes
    ) -> NDArray[np.uint64]:
        """Count some patterns; their signatures' hashes (patterns,) as numbers."""
        size = _SIGNATURE + 2 * _DIGITS
        if least < 0 or greatest >= 10**_DIGITS or len(told) != patterns * size:
            raise ValueError("the signature of a pattern is no hash of 8 bytes, or a count is none")
        rows = np.frombuffer(told, np.uint8).reshape(patterns, size)
        digits = rows[:, _SIGNATURE:].reshape(-1, 2, _DIGITS).astype(np.int64) - ord("0")
        irregular, sides = (digits @ 10 ** np.arange(_DIGITS)[::-1]).T
        self.patterns += patterns
        self.chiral += chiral
        self._irregular = _add_counts(self._irregular, np.bincount(irregular))
        self._sides = _add_counts(self._sides, np.bincount(sides))
        return np.ascontiguousarray(rows[:, :_SIGNATURE]).view(np.uint64)[:, 0]

    @property
    def sides(self) -> dict[int, int]:
        return _list_counts(self._sides)

    @property
    def irregular(self) -> dict[int, int]:
        return _list_counts(self._irregular)


def _add_counts(one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.int64]:
    total = np.zeros(max(len(one), len(other)), np.int64)
    total[: len(one)] += one
    total[: len(other)] += other
    return total


def _list_counts(counts: NDArray[np.int64]) -> dict[int, int]:
    return {n: int(counts[n]) for n in np.flatnonzero(counts).tolist()}


def read_statistics(connection: sqlite3.Connection, content_hash: str) -> Statistics:
    """Counts over the whole database, beside its content hash."""
    one = connection.execute
    counts = _PatternCounts(connection)
    met = one(
        "SELECT coalesce(sum((own > 0) + (mirrored > 0)), 0) FROM "
        "(SELECT sum(patches - mirrored_patches) AS own, sum(mirrored_patches) AS mirrored "
        "FROM occurrence GROUP BY pattern_id)"
    ).fetchone()[0]
    meshes, patches = one(
        "SELECT count(*), coalesce(sum(distinct_patches), 0) FROM mesh"
    ).fetchone()
    return Statistics(
        patterns=counts.patterns,
        patterns_oriented=counts.patterns + counts.chiral,
        patterns_met=met,
        by_sides=counts.sides,
        by_irregular=counts.irregular,
        signatures=counts.signatures,
        meshes=meshes,
        patches=patches,
        content_hash=content_hash,
    )
