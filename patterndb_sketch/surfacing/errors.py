"""Errors of curve networks and of their surfaces."""

from __future__ import annotations

from patterndb.errors import PatternDBError


class InvalidNetworkError(PatternDBError, ValueError):
    """A curve network, or a cycle of one, is not what it must be."""
