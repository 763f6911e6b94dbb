"""Errors of queries other than that of an invalid boundary."""

from __future__ import annotations

from patterndb.errors import PatternDBError


class InvalidQueryError(PatternDBError, ValueError):
    """An option of a query, or the widths of an expansion, are not what they must be."""


class QueryCancelledError(PatternDBError, RuntimeError):
    """A query was cancelled while it searched. A list of fills catches it and ends."""


class SolverError(PatternDBError, RuntimeError):
    """CP-SAT gave a model up; its status is in the message."""
