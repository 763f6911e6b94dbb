"""Alarms: called in order, not when called off, and none that holds what nobody wants any more."""

from __future__ import annotations

import gc
import math
import multiprocessing
import sys
import threading
import weakref
from time import perf_counter

import pytest

import patterndb
from patterndb.errors import TimeLimitError
from patterndb.store import Database
from patterndb.system.deadline import (
    Alarm,
    end_by,
    extend_deadline,
    get_deadline,
    is_late,
    limit_time,
    run_until_late,
)
from query import Fills, fills

#: Seconds that a test waits for what should come at once.
PATIENCE = 30.0


def count_alarm_threads() -> int:
    return sum(thread.name == "patterndb-alarm" for thread in threading.enumerate())


def test_alarms_ring_in_the_order_of_their_moments() -> None:
    rung: list[int] = []
    last = threading.Event()
    now = perf_counter()
    Alarm(now + 0.2, lambda: rung.append(3))
    Alarm(now + 0.25, last.set)
    Alarm(now + 0.1, lambda: rung.append(2))
    off = Alarm(now + 0.15, lambda: rung.append(0))
    Alarm(now - 1, lambda: rung.append(1))
    off.call_off()
    assert last.wait(PATIENCE)
    assert rung == [1, 2, 3]
    assert count_alarm_threads() == 1


def test_an_alarm_that_never_rings_holds_up_none() -> None:
    Alarm(math.inf, lambda: None)
    rung = threading.Event()
    Alarm(perf_counter(), rung.set)
    assert rung.wait(PATIENCE)


def begin_list(db: Database) -> weakref.ref[Fills]:
    """Begin a list that nobody goes on with."""
    found = fills(db, (3, 4, 3, 4), limit=5, time_limit=3600)
    next(found)
    return weakref.ref(found)


def test_lists_that_are_dropped_go_at_once() -> None:
    with patterndb.open() as db:
        dropped = [begin_list(db) for _ in range(20)]
    gc.collect()
    assert [ref() for ref in dropped] == [None] * 20
    assert count_alarm_threads() == 1


def ring_in_child() -> None:
    rung = threading.Event()
    Alarm(perf_counter(), rung.set)
    sys.exit(0 if rung.wait(PATIENCE) else 1)


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="has no fork")
def test_a_forked_process_has_alarms_of_its_own() -> None:
    Alarm(perf_counter(), lambda: None)
    process = multiprocessing.get_context("fork").Process(target=ring_in_child)
    process.start()
    process.join(2 * PATIENCE)
    assert process.exitcode == 0


def test_the_earlier_of_two_deadlines_holds() -> None:
    now = perf_counter()
    with end_by(now - 1), end_by(now + 3600):
        assert get_deadline() == now - 1
        assert is_late()
    assert get_deadline() == math.inf
    assert not is_late()


def test_a_task_is_left_when_time_is_up() -> None:
    never = threading.Event()
    with limit_time(0.05), pytest.raises(TimeLimitError, match="before it was drawn"):
        run_until_late(never.wait, "it was drawn")
    never.set()
    with limit_time(3600):
        moment = get_deadline()
        assert run_until_late(get_deadline, "it was asked") == moment
        with extend_deadline(5):
            assert get_deadline() == moment + 5
    with limit_time(None):
        assert get_deadline() == math.inf
    with pytest.raises(ZeroDivisionError):
        run_until_late(lambda: 1 // 0, "it was divided")
