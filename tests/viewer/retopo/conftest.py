"""States of the window of retopology, for its tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import Event

import pytest

from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.filling import FilledNetwork
from patterndb_sketch.retopo.network import check_network
from query.engine import PatternSource
from tests.support.viewer.sheets import opened
from viewer.retopo import RetopoState


@pytest.fixture
def state(source: PatternSource) -> Iterator[RetopoState]:
    made = opened(source)
    yield made
    check_network(made.network)
    made.close()


@pytest.fixture
def held_fill(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], tuple[Event, Event]]]:
    """Has every fill from now on wait: of the two events the first is set when one has begun, and
    it goes on once the second is."""
    going = Event()

    def hold() -> tuple[Event, Event]:
        begun, fill = Event(), Retopology.fill

        def waiting(self: Retopology) -> FilledNetwork:
            begun.set()
            assert going.wait(60.0)
            return fill(self)

        monkeypatch.setattr(Retopology, "fill", waiting)
        return begun, going

    yield hold
    going.set()
