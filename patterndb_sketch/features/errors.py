"""Errors of feature curves, templates and shape models."""

from __future__ import annotations

from patterndb.errors import PatternDBError


class InvalidFeatureError(PatternDBError, ValueError):
    """A stroke, curve, network, template or shape model is not what it must be."""
