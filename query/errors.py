"""The error of a query that cannot be asked, whatever its boundary."""

from __future__ import annotations

from patterndb.errors import PatternDBError


class InvalidQueryError(PatternDBError, ValueError):
    """An option of a query, or the widths of an expansion, are not what they must be."""
