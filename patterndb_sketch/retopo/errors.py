"""Errors of retopology."""

from __future__ import annotations

from patterndb.errors import PatternDBError


class InvalidRetopoError(PatternDBError, ValueError):
    """A surface, stroke, size, network or session is not what it must be."""


class RefusedError(PatternDBError, RuntimeError):
    """A tool cannot do here what it was asked for; everything stays as it was."""
