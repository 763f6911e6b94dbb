"""Errors of queries beside that of an invalid boundary."""

from __future__ import annotations

from patterndb.errors import PatternDBError
from patterndb.system.numbers import MOST_COUNT


class InvalidQueryError(PatternDBError, ValueError):
    """An option of a query, or the widths of an expansion, are not what they must be."""


class QueryCancelledError(PatternDBError, RuntimeError):
    """A query was cancelled while it searched. A list of fills catches it and ends."""


class SolverError(PatternDBError, RuntimeError):
    """CP-SAT gave a model up; its status is in the message."""


def refuse_large(name: str, value: int, most: int = MOST_COUNT) -> None:
    """Raise InvalidQueryError for an option's number that is too large."""
    if value > most:
        raise InvalidQueryError(f"{name} is more than {most:,}, the most; give less")
