"""Classes of patterns as arrays in the user's cache folder, mapped: ready at once in a new process.

Loading a large class reads and checks every row; its arrays are so kept once they are made
(:mod:`patterndb.system.mappedarrays`), under the database's path and what it holds: the checksums
of its meshes and occurrences (:mod:`patterndb.store.checksums`), from which all else of a class
follows, but for patterns that are there only because they were used; these are part of the key
too. How often patterns were used is not kept: it changes with every accepted fill, and is read each
time. The path is in the key since checksums are no protection against forgery: another database
cannot give its arrays out for those of this one.

Where rows were changed otherwise (a bad disk, another program), so that they do not add up to the
checksums, the arrays are those of what was written; ``verify`` finds such rows.
"""

from __future__ import annotations

import sqlite3
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.packing import PackedRows
from patterndb.core.patternclass import PatternClass
from patterndb.store.checksums import read_sums
from patterndb.store.migrations import SCHEMA_VERSION
from patterndb.store.reading import get_id_range, load_class
from patterndb.system.mappedarrays import ArrayShelf

#: What arrays of a class are kept as; changed whenever what they hold is.
FORMAT = "class-1"

#: Patterns from which on a class is kept: a smaller one loads in some tenth of a second.
LEAST_KEPT = 4096

#: What a class has that is no array, or is not kept.
_APART = {"n_sides", "uses", "codes", "shelf"}
_ARRAYS = [field.name for field in fields(PatternClass) if field.name not in _APART]


def read_class(connection: sqlite3.Connection, path: Path, n_sides: int) -> PatternClass:
    """The class, as :func:`patterndb.store.reading.load_class` loads it: mapped from the cache
    folder where its arrays are kept and of this content, else loaded, and kept if it is large."""
    if connection.in_transaction:
        # What is read then may never be committed.
        return load_class(connection, n_sides)
    # One state of the file for the key and the rows.
    connection.execute("BEGIN")
    try:
        shelf = _find_shelf(connection, path, n_sides)
        if shelf is None:
            return load_class(connection, n_sides)
        what = f"{n_sides}-{FORMAT}"
        arrays = shelf.find(what)
        if arrays is None:
            loaded = load_class(connection, n_sides)
            if len(loaded) < LEAST_KEPT:
                return loaded
            if not shelf.keep(what, _to_arrays(loaded)):
                return loaded
            arrays = shelf.find(what)
            if arrays is None:  # another process has replaced it
                return loaded
            del loaded
        return _from_arrays(n_sides, arrays, _read_uses(connection, n_sides, arrays["ids"]), shelf)
    finally:
        connection.execute("COMMIT")


def _find_shelf(connection: sqlite3.Connection, path: Path, n_sides: int) -> ArrayShelf | None:
    """Where arrays of a class are kept; None where the file has no sums to know its content by."""
    sums = read_sums(connection)
    if not {"mesh", "occurrence"} <= sums.keys():
        return None
    low, high = get_id_range(n_sides)
    # Few patterns were used: a cross join begins with these, not with all patterns of the class.
    unseen = connection.execute(
        "SELECT id, pattern.origin FROM usage CROSS JOIN pattern ON id = pattern_id "
        "WHERE pattern_id BETWEEN ? AND ? AND frequency = 0 ORDER BY id",
        (low, high),
    ).fetchall()
    return ArrayShelf(
        str(path.resolve()), repr((SCHEMA_VERSION, sums["mesh"], sums["occurrence"], unseen))
    )


def _to_arrays(patterns: PatternClass) -> dict[str, NDArray[Any]]:
    codes = PackedRows.from_rows(patterns.codes)
    return {name: getattr(patterns, name) for name in _ARRAYS} | {
        "code_bytes": codes.raw,
        "code_ends": codes.ends,
    }


def _from_arrays(
    n_sides: int, arrays: dict[str, NDArray[Any]], uses: NDArray[np.int64], shelf: ArrayShelf
) -> PatternClass:
    return PatternClass(
        n_sides=n_sides,
        uses=uses,
        codes=PackedRows(arrays["code_bytes"], arrays["code_ends"]),
        shelf=shelf,
        **{name: arrays[name] for name in _ARRAYS},
    )


def _read_uses(
    connection: sqlite3.Connection, n_sides: int, ids: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(p,) int64 how often the patterns of these ids were used."""
    low, high = get_id_range(n_sides)
    used = dict(
        connection.execute(
            "SELECT pattern_id, uses FROM usage WHERE pattern_id BETWEEN ? AND ?", (low, high)
        ).fetchall()
    )
    uses = np.zeros(len(ids), np.int64)
    if used:
        for row in np.flatnonzero(np.isin(ids, np.array(list(used), np.int64))).tolist():
            uses[row] = used[int(ids[row])]
    return uses
