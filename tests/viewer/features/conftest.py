"""States of the viewer of feature curves, for its tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.viewer.tents import opened, picked
from viewer.features import FeatureState


@pytest.fixture
def state() -> Iterator[FeatureState]:
    state = opened()
    yield state
    state.close()


@pytest.fixture
def curved() -> Iterator[FeatureState]:
    """With one curve on the ridge."""
    state = opened()
    picked(state)
    yield state
    state.close()
