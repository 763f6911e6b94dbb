"""States of the viewer of shape models, for its tests."""

from __future__ import annotations

import pytest

from tests.support.viewer.shapes import opened
from viewer.shapes import ShapesState


@pytest.fixture
def state() -> ShapesState:
    return opened()
