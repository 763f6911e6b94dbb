"""What the window of retopology does in the background, and tells."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import FilledNetwork, weld_patches
from patterndb_sketch.retopo.filling.choice import Choice
from patterndb_sketch.retopo.filling.fills import LISTED, filling_of, rank_fills
from query.engine import PatternSource
from tests.support.viewer.sheets import (
    SQUARE,
    at,
    click,
    drag,
    hover,
    keys,
    opened,
    quads_of,
    sheet,
    square,
    texts,
)
from viewer.keymap import Effect
from viewer.retopo import RetopoState
from viewer.retopo.keys import KEYS


def test_refusals_are_told_and_change_nothing(state: RetopoState) -> None:
    keys(state, "c")
    drag(state, (-1.0, 0.0), (1.0, 0.0))
    assert state.message and not state.shown.undoable and state.editing.calls == ()
    assert state.message in " ".join(texts(state)) or len(state.message) > 60
    keys(state, "u")
    assert state.message == "there is nothing to undo"
    keys(state, "d")
    click(state, (0.0, 0.0))
    assert state.message.startswith("hold the button")
    keys(state, "e ]")
    assert state.message == "erase has no brush"
    keys(state, "t")
    hover(state, (0.0, 0.0))
    keys(state, "+")
    assert state.message == "put the pointer on a curve"
    assert state.editing.calls == ()


def test_the_script_of_a_session_gives_the_same_mesh(
    state: RetopoState, source: PatternSource
) -> None:
    square(state)
    keys(state, "a")
    hover(state, (0.0, 1.4))
    click(state, (0.0, 1.4))
    keys(state, "t")
    hover(state, (0.0, -1.5))
    state.wheel(1.0)
    state.wheel(1.0)
    keys(state, "u U")
    hover(state, (0.0, 0.0))
    keys(state, "n")
    assert state.editing.calls is not None
    again = Retopology(sheet(), source)
    for call in state.editing.calls:
        assert again.do(call).changed
        again.fill()
    one, other = state.shown.body.mesh, weld_patches(again.fill())
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.quads, other.quads) and len(one.quads) > 0


def test_while_quads_are_made_all_else_goes_on(
    state: RetopoState,
    source: PatternSource,
    held_fill: Callable[[], tuple[threading.Event, threading.Event]],
) -> None:
    square(state)
    keys(state, "i")
    drag(state, (-1.0, 3.0), (1.0, 3.0))
    body, old = state.shown.body, sorted(state.network.patches)
    assert len(old) == 2 and quads_of(state) > 0
    begun, slow = held_fill()
    keys_at = [at(state, point) for point in ((0.0, -1.5), (0.0, 1.5))]
    KEYS.press(state, "d")
    state.move(*keys_at[0])
    state.press(*keys_at[0])
    state.move(0.0, 0.0)
    state.release(*keys_at[1])
    assert begun.wait(60.0)
    try:
        # The curve is there at once; the quads of the patch it cuts are not shown, others are.
        state.poll()
        assert len(state.network.patches) == 3 and not state.shown.fresh
        assert state.shown.body is body
        (stale,) = state.shown.stale()
        assert stale in old and "working …" in texts(state)
        hover_at = at(state, (0.0, 3.0))
        state.move(*hover_at)
        assert state.tool.patch_under() in set(old) - {stale}
        # More calls wait, the view turns, and previews are of the network that is seen.
        state.editing.undo()
        state.editing.undo()
        assert state.editing.waiting == 3 and len(state.network.patches) == 3
        assert state.wheel(1.0) and state.drag_view(3.0, 0.0)
        KEYS.press(state, "a")
        state.move(*at(state, (1.6, 0.0)))
        state.editing._previews.wait()
        state.poll()
        assert state.tool.preview is not None and state.tool.preview.network is state.network
        assert state.tool.preview.count > 0
        state.editing.save_mesh()
        assert state.editing.files is None or "still being made" in state.message
    finally:
        slow.set()
    state.settle()
    assert state.shown.fresh and len(state.network.patches) == 1
    assert state.shown.stale() == frozenset() and not state.editing.waiting
    # What was previewed on the network before is gone with it.
    assert state.tool.preview is None or state.tool.preview.network is state.network
    assert state.editing.calls is not None
    assert [call.tool for call in state.editing.calls[-3:]] == ["stroke", "undo", "undo"]


def test_what_goes_wrong_in_a_thread_is_not_lost(
    state: RetopoState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: Retopology) -> object:
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr(Retopology, "fill", broken)
    with pytest.raises(ZeroDivisionError, match="a fault"):
        drag(state, (-1.0, 0.0), (1.0, 0.0))


def test_a_session_that_has_patches_gets_its_quads(source: PatternSource) -> None:
    editor = Retopology(sheet(), source)
    for k in range(4):
        line = [[*SQUARE[k - 1], 0.0], [*SQUARE[k], 0.0]]
        assert editor.do(Call("stroke", {"points": line})).changed
    state = RetopoState(editor)
    try:
        state.settle()
        assert quads_of(state) > 0 and state.shown.fresh
        state.editing.save_script()
        assert state.editing.calls is None, "it did not begin from the bare surface"
    finally:
        state.close()


def test_escape_stops_a_long_fill(state: RetopoState, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if the step had not been; what is asked for then is made."""
    square(state)
    before, undoable = state.shown.state, state.shown.undoable
    begun = threading.Event()

    def fill_for_ever(_editor: Retopology) -> FilledNetwork:
        while True:
            begun.set()
            time.sleep(0.002)

    with monkeypatch.context() as slow:
        slow.setattr(Retopology, "fill", fill_for_ever)
        state.editing.do("subdivide", at=[0.0, -1.5, 0.0], by=1)
        assert begun.wait(60.0)
        state.poll()
        assert state.editing.working == ("subdivide",) and "Esc stops it" in " ".join(texts(state))
        state.move(*at(state, (1.0, 1.0)))
        assert state.tool.foot is not None, "the pointer goes on"
        assert state.leave()
        state.editing.wait()
        state.poll()
    assert state.message == "subdivide was stopped; nothing is changed"
    assert state.shown.state.same(before) and state.shown.undoable == undoable
    assert state.shown.fresh and not state.editing.waiting
    state.editing.do("subdivide", at=[0.0, -1.5, 0.0], by=1)
    state.settle()
    assert not state.shown.state.same(before) and state.shown.undoable == undoable + 1


def test_escape_drops_what_waits(
    state: RetopoState, held_fill: Callable[[], tuple[threading.Event, threading.Event]]
) -> None:
    square(state)
    begun, slow = held_fill()
    KEYS.press(state, "C")
    state.editing.do("subdivide", at=[0.0, -1.5, 0.0], by=1)
    assert begun.wait(60.0)
    state.editing.do("undo")
    state.editing.do("undo")
    try:
        assert state.editing.working == ("subdivide", "undo", "undo")
        said = texts(state)
        assert "count" in said and "undo, undo" in said and "Esc drops these 2" in said
        assert KEYS.press(state, "Escape") is Effect.REDRAW
        assert state.message == "dropped: 2 steps that had not begun"
        assert state.editing.working == ("subdivide",)
    finally:
        slow.set()
    state.settle()
    assert state.editing.calls is not None and [call.tool for call in state.editing.calls[-2:]] == [
        "stroke",
        "subdivide",
    ]
    assert not state.leave(), "nothing is left"


def test_which_fill_of_its_list_a_patch_has_is_told(
    state: RetopoState, source: PatternSource
) -> None:
    square(state, ((0.0, 2.0), (-1.9, 0.6), (-1.2, -1.6), (1.2, -1.6), (1.9, 0.6)))
    keys(state, "y")
    hover(state, (0.0, 0.0))
    (patch,) = state.network.patches.values()
    listed = [Choice.of(fill) for fill in rank_fills(state.network, patch, source)]
    assert len(listed) > 2
    for _ in range(len(listed) + 1):
        (patch,) = state.network.patches.values()
        choice = filling_of(patch).choice
        assert choice is not None
        place = state.editing.place_in_list(patch.id)
        assert place is not None and place.count == len(listed)
        assert place.number == listed.index(replace(choice, by="program"))
        of = f"the first {place.count}" if place.more else f"{place.count}"
        assert place.more == (len(listed) == LISTED)
        assert f"{place.number + 1} of {of}   n b" in texts(state)
        keys(state, "n")
    # With a flow line it is another list.
    keys(state, "w")
    drag(state, (-1.4, 0.0), (1.4, 0.0))
    hover(state, (0.0, 0.1))
    (patch,) = state.network.patches.values()
    following = [Choice.of(fill) for fill in rank_fills(state.network, patch, source)]
    choice, place = filling_of(patch).choice, state.editing.place_in_list(patch.id)
    assert choice is not None and place is not None and following != listed
    assert (place.number, place.count) == (following.index(choice), len(following))


def test_calls_come_after_a_list_that_is_being_found(state: RetopoState) -> None:
    square(state)
    keys(state, "y")
    x, y = at(state, (0.0, 0.0))
    state.move(x, y)
    # The list may be on its way: calls come after it, and none is lost.
    state.editing.do("undo")
    state.settle()
    assert len(state.network.patches) == 0 and not state.message


def test_what_waits_when_the_window_is_closed_is_dropped(
    source: PatternSource, held_fill: Callable[[], tuple[threading.Event, threading.Event]]
) -> None:
    state = opened(source)
    square(state)
    begun, slow = held_fill()
    state.editing.do("subdivide", at=[0.0, -1.5, 0.0], by=1)
    assert begun.wait(60.0)
    state.editing.do("undo")
    over = at(state, (0.0, 0.0))
    KEYS.press(state, "y")
    state.move(*over)
    threading.Timer(0.2, slow.set).start()
    state.close()
    state.editing.take()
    assert not state.editing.waiting and state.editing.calls is not None
    assert [call.tool for call in state.editing.calls[-2:]] == ["stroke", "subdivide"]
