"""How often the fills of a pattern were accepted: the record behind ranking by use.

A pattern that no mesh holds (a query made it, or another database learned it) is written
when it is first used, and says what it was then. Uses are no part of what was learned: they
are neither in the content hash nor merged nor in the compact file.
"""

from __future__ import annotations

import sqlite3

import numpy as np

from patterndb.core.code import Code
from patterndb.core.packing import pack
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import ORIGINS
from patterndb.core.reduction import reduce_disk
from patterndb.errors import InvalidCodeError
from patterndb.store import writing

#: Uses are kept in 63 bits; this many at once is a slip.
MOST_AT_ONCE = 1 << 40


def checked(pattern: Pattern | Code, count: int) -> Pattern:
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


def record(connection: sqlite3.Connection, pattern: Pattern, count: int) -> int:
    """Count the pattern's use; return how often it was used now. Belongs inside atomic()."""
    writing.add_patterns(connection, [pattern.id], [pack(pattern.code)], pattern.origin)
    return connection.execute(
        "INSERT INTO usage (pattern_id, uses, origin) "
        "SELECT id, ?, CASE frequency WHEN 0 THEN ? ELSE origin END FROM pattern WHERE id = ? "
        "ON CONFLICT (pattern_id) DO UPDATE SET uses = uses + excluded.uses RETURNING uses",
        (count, pattern.origin, pattern.id),
    ).fetchone()[0]


def uses(connection: sqlite3.Connection) -> dict[int, int]:
    """Uses by pattern id, of those that were used."""
    rows = connection.execute("SELECT pattern_id, uses FROM usage ORDER BY pattern_id")
    return dict(rows.fetchall())
