"""Classes of patterns as arrays in the user's cache folder, mapped: ready at once in a new process.

Loading a large class reads and checks every row; its arrays are so kept once they are made
(:mod:`patterndb.system.mappedarrays`), under the database's path and its content's key
(:mod:`patterndb.store.contentkey`). How often patterns were used is not kept: it changes with every
accepted fill, and is read each time. Handles of one process that ask for the same have one class.
"""

from __future__ import annotations

import sqlite3
from dataclasses import fields
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from patterndb.core.packing import PackedRows
from patterndb.core.patternclass import PatternClass
from patterndb.store.contentkey import read_content_key
from patterndb.store.reading import get_id_range, load_class
from patterndb.system.mappedarrays import ArrayShelf
from patterndb.system.memory import return_freed_memory

#: What arrays of a class are kept as; changed whenever what they hold is.
FORMAT = "class-2"

#: Patterns from which on a class is kept: a smaller one loads in some tenth of a second.
LEAST_KEPT = 4096

#: What a class has that is no array, or is not kept.
_APART = {"n_sides", "uses", "codes", "shelf", "tables"}
_ARRAYS: list[str] = [field.name for field in fields(PatternClass) if field.name not in _APART]

#: The mapped classes of this process, with what was made of them, by the files that they are in.
_MAPPED: WeakValueDictionary[tuple[ArrayShelf, int], PatternClass] = WeakValueDictionary()


def read_class(connection: sqlite3.Connection, path: Path, n_sides: int) -> PatternClass:
    """The class, as :func:`patterndb.store.reading.load_class` loads it.

    One that is mapped already, else mapped from the cache folder where its arrays are kept and of
    this content, else loaded, and kept if it is large.
    """
    what = f"{n_sides}-{FORMAT}"
    shelf = _find_shelf(connection, path, n_sides)
    mapped = None if shelf is None else _MAPPED.get((shelf, n_sides))
    if mapped is not None and np.array_equal(
        mapped.uses, _read_uses(connection, n_sides, mapped.ids)
    ):
        return mapped
    arrays = None if shelf is None else shelf.find(what)
    if arrays is None:
        loaded = load_class(connection, n_sides)
        if shelf is None or len(loaded) < LEAST_KEPT:
            return loaded
        # What another program wrote in between would be kept under what was there before.
        if _find_shelf(connection, path, n_sides) != shelf or not shelf.keep(
            what, _to_arrays(loaded)
        ):
            return loaded
        # A large class has its arrays in memory once, not beside those that are mapped.
        del loaded
        return_freed_memory()
        arrays = shelf.find(what)
        if arrays is None:  # another process has replaced it
            return load_class(connection, n_sides)
    assert shelf is not None
    uses = _read_uses(connection, n_sides, arrays["ids"])
    made = _from_arrays(n_sides, arrays, uses, shelf)
    _MAPPED[shelf, n_sides] = made
    return made


def _find_shelf(connection: sqlite3.Connection, path: Path, n_sides: int) -> ArrayShelf | None:
    """Where arrays of a class are kept; None where its content cannot be told: the file has no
    sums, or a change is under way, which may never be committed."""
    key = None if connection.in_transaction else read_content_key(connection, n_sides)
    return None if key is None else ArrayShelf(str(path.resolve()), key)


def _to_arrays(patterns: PatternClass) -> dict[str, NDArray[Any]]:
    assert isinstance(patterns.codes, PackedRows)
    codes = patterns.codes
    return {name: getattr(patterns, name) for name in _ARRAYS} | {
        "code_bytes": codes.raw,
        "code_ends": codes.ends,
    }


def _from_arrays(
    n_sides: int, arrays: dict[str, Any], uses: NDArray[np.int64], shelf: ArrayShelf
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
