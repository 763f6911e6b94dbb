"""Columns of a table as arrays, whatever stands in them: SQLite's types are checked on writing, and
a damaged or a foreign file was not written by us."""

from __future__ import annotations

import sqlite3
from collections.abc import Generator, Iterable, Sequence
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


def read_in_parts(
    connection: sqlite3.Connection, select: str, at_once: int
) -> Generator[list[tuple[Any, ...]]]:
    """Read the rows of patterns in order of their ids, at most ``at_once`` at a time.

    select: the statement up to its condition; its first column is the id. No statement stays open
    between two parts, so that others can write meanwhile. Raises DatabaseError where the ids do not
    ascend: in a damaged tree a search for later ones might never end.
    """
    last = None
    statement = f"{select} WHERE id > ? ORDER BY id LIMIT ?"
    while True:
        after = -1 << 63 if last is None else last
        rows = connection.execute(statement, (after, at_once)).fetchall()
        refuse_disorder([row[0] for row in rows], last)
        if rows:
            yield rows
        if len(rows) < at_once:
            return
        last = rows[-1][0]


def refuse_disorder(ids: Iterable[int], last: int | None = None) -> None:
    """Raise DatabaseError unless the ids ascend, and all come after ``last``."""
    for number in ids:
        if last is not None and number <= last:
            raise DatabaseError(
                f"the table of patterns is damaged: pattern {format_id(number)} stands after "
                f"{format_id(last)}; 'patterndb verify' reports what is wrong with the whole file"
            )
        last = number


def check_blobs(ids: Sequence[int], column: str, blobs: Sequence[Any]) -> None:
    """Raise DatabaseError for a value that is not bytes."""
    if not set(map(type, blobs)) <= {bytes}:
        at = next(i for i, blob in enumerate(blobs) if type(blob) is not bytes)
        raise say_wrong(ids[at], column, f"is {_shorten(blobs[at])}, no bytes")


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:39] + "…"
