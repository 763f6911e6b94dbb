"""What the tests of all viewers need."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import patterndb
from query.engine import PatternSource


@pytest.fixture(scope="module")
def source() -> Iterator[PatternSource]:
    """The starter database."""
    with patterndb.open() as opened:
        yield opened
