"""Whose turn it is among the threads at work."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from patterndb_app.service import turns
from patterndb_app.service.turns import Turns
from tests.support.service.servedhere import PATIENCE


@pytest.fixture
def endless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Turns that never end by the clock, and threads that wait for theirs."""
    monkeypatch.setattr(turns, "TURN_SECONDS", 0.0)
    monkeypatch.setattr(turns, "PATIENCE_SECONDS", PATIENCE)


def in_thread(function: Callable[[], None]) -> threading.Thread:
    thread = threading.Thread(target=function)
    thread.start()
    return thread


@pytest.mark.usefixtures("endless")
def test_who_has_told_something_waits_for_who_has_not() -> None:
    shared = Turns(1)
    told: list[str] = []
    asked = threading.Event()

    def long() -> None:
        shared.begin()
        asked.wait(PATIENCE)
        shared.pause()
        told.append("long")
        shared.end()

    thread = in_thread(long)
    shared.begin()
    asked.set()
    thread.join(0.1)
    assert thread.is_alive()
    told.append("fresh")
    # Its first line is told, and there is one turn for two: the other has waited longer.
    shared.pause()
    told.append("fresh again")
    thread.join(PATIENCE)
    shared.end()
    assert told == ["fresh", "long", "fresh again"]


def test_nobody_waits_for_long() -> None:
    shared = Turns(1)
    ended = threading.Event()

    def other() -> None:
        shared.begin()
        shared.pause()
        shared.pause()
        shared.end()
        ended.set()

    shared.begin()  # and tells nothing
    thread = in_thread(other)
    assert ended.wait(PATIENCE)
    thread.join()
    shared.end()


@pytest.mark.parametrize("patience", [0.0, 0.001, PATIENCE])
def test_every_turn_is_given_back(monkeypatch: pytest.MonkeyPatch, patience: float) -> None:
    monkeypatch.setattr(turns, "TURN_SECONDS", 0.0)
    monkeypatch.setattr(turns, "PATIENCE_SECONDS", patience)
    shared = Turns(2)

    def work(lines: int) -> None:
        shared.begin()
        for _ in range(lines):
            shared.pause()
        shared.end()

    with ThreadPoolExecutor(12) as pool:
        list(pool.map(work, [number % 7 for number in range(400)]))
    assert (shared._fresh, shared._going, len(shared._queue)) == (0, 0, 0)
