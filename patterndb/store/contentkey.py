"""The key of a database's content: what is kept of it elsewhere is stale once its key is another.

The checksum of meshes (:mod:`patterndb.store.checksums`) tells it without a look at the rows, for
the sums of their occurrences are among what it sums: all else follows from these, but for the
patterns that are there only because they were used. These are part of the key; how often patterns
were used is not.

Two things a key does not do. Checksums are no protection against forgery, so what is kept goes by
the database's path, too: another file with the same sums cannot give its content out for that of
this one. And rows that were changed otherwise (a bad disk, another program) no longer add up to the
sums: what is kept then is of what was written. ``verify`` finds such rows.
"""

from __future__ import annotations

import sqlite3

from patterndb.store.checksums import read_sums
from patterndb.store.migrations import SCHEMA_VERSION
from patterndb.store.reading import get_id_range

#: The smallest and the largest id that SQLite has.
_ALL = (-(1 << 63), (1 << 63) - 1)


def read_content_key(connection: sqlite3.Connection, n_sides: int | None = None) -> str | None:
    """Read the key of what a database holds, used patterns of other classes than of ``n_sides``
    sides aside (None: of all classes). None where the file has no sums to know it by."""
    sums = read_sums(connection)
    if "mesh" not in sums:
        return None
    # Few patterns were used: a cross join begins with these, not with all patterns.
    unseen = connection.execute(
        "SELECT id, pattern.origin FROM usage CROSS JOIN pattern ON id = pattern_id "
        "WHERE pattern_id BETWEEN ? AND ? AND frequency = 0 ORDER BY id",
        _ALL if n_sides is None else get_id_range(n_sides),
    ).fetchall()
    return repr((SCHEMA_VERSION, sums["mesh"], unseen))
