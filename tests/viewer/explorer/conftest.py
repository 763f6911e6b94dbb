"""States of the fill explorer, for its tests."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from query.contour import make_flat_boundary
from tests.support.viewer.domed import DOME, opened
from viewer.camera import View
from viewer.explorer_state import ExplorerState


@pytest.fixture
def state() -> Iterator[ExplorerState]:
    state = opened(make_flat_boundary((4, 3, 4, 3)))
    yield state
    state.close()


@pytest.fixture
def empty() -> Iterator[ExplorerState]:
    """A dome to draw on, seen from above, 100 points to a unit."""
    state = opened(surface=DOME)
    state.camera.view = View(np.eye(3), np.zeros(3), 100.0)
    yield state
    state.close()
