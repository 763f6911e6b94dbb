"""Columns of a table as arrays, whatever stands in them: SQLite's types are checked on writing, and
a damaged or a foreign file was not written by us."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import format_id
from patterndb.errors import DatabaseError

#: The largest number of a column that becomes 32 bits.
MOST_32 = 2**31 - 1
#: The largest number that SQLite holds.
MOST_64 = 2**63 - 1


def say_wrong(pattern_id: int, column: str, why: str) -> DatabaseError:
    """The error for a wrong value in a pattern's row."""
    return DatabaseError(
        f"pattern {format_id(pattern_id)} is damaged: {column} {why}; "
        "'patterndb verify' tells what is wrong with the whole file"
    )


def read_numbers(
    ids: Sequence[int], column: str, values: Sequence[Any], low: int, high: int
) -> NDArray[np.int64]:
    """(p,) int64 a column of numbers in ``low..high``. Raises DatabaseError for others."""
    if set(map(type, values)) <= {int}:
        try:
            numbers = np.array(values, np.int64)
        except OverflowError:  # only a question that computes could give one
            numbers = np.full(len(values), low - 1, np.int64)
        wrong = np.flatnonzero((numbers < low) | (numbers > high))
        if not len(wrong):
            return numbers
        at = int(wrong[0])
    else:
        at = next(i for i, value in enumerate(values) if type(value) is not int)
    raise say_wrong(ids[at], column, f"is {_shorten(values[at])}, no whole number of {low}..{high}")


def check_blobs(ids: Sequence[int], column: str, blobs: Sequence[Any]) -> None:
    """Raise DatabaseError for a value that is not bytes."""
    if not set(map(type, blobs)) <= {bytes}:
        at = next(i for i, blob in enumerate(blobs) if type(blob) is not bytes)
        raise say_wrong(ids[at], column, f"is {_shorten(blobs[at])}, no bytes")


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:39] + "…"
