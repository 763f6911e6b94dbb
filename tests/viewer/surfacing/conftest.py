"""States of the viewer of surfaces, for its tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.viewer.domes import Finder, growing_dome, opened
from viewer.surfacing.state import SurfacingState


@pytest.fixture
def state() -> Iterator[SurfacingState]:
    state = opened()
    yield state
    state.close()


@pytest.fixture
def growing() -> Iterator[SurfacingState]:
    state = opened(growing_dome(), find=Finder())
    yield state
    state.close()
