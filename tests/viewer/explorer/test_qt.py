"""The fill explorer's window on the shell: pointer, docks, undo, saving and closing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QApplication, QMessageBox

from query import Fill
from query.contour import make_flat_boundary
from tests.support.viewer.domed import DOME, opened
from tests.support.viewer.events import Events, answer, check_actions, check_looking
from viewer import style
from viewer.camera import View
from viewer.explore import ExplorerSaver
from viewer.explorer_state import ExplorerState
from viewer.explorer_window import ExplorerWindow

CORNERS = ((-110.0, -90.0), (100.0, -90.0), (110.0, 100.0), (-100.0, 90.0))


def settle(state: ExplorerState) -> None:
    if state.finder.boundary is not None:
        state.finder._search.wait()  # type: ignore[union-attr]
        future = state.finder._placing()
        if future is not None:
            future.exception()


def show(state: ExplorerState, folder: Path, accepted: list[Fill] | None = None) -> Events:
    def accept(fill: Fill) -> str:
        assert accepted is not None
        accepted.append(fill)
        return "recorded"

    def write(path: Path, fill: Fill, points: object) -> None:
        path.write_text(fill.pattern.name)

    saver = ExplorerSaver(state, folder, write, (480, 300), None if accepted is None else accept)
    return Events(saver, folder, ExplorerWindow, lambda: settle(state))


@pytest.fixture
def flat(tmp_path: Path) -> Iterator[Events]:
    state = opened(make_flat_boundary((4, 3, 4, 3)))
    events = show(state, tmp_path)
    yield events
    events.close()
    state.close()


def test_a_boundary_is_drawn_filled_and_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    accepted: list[Fill] = []
    state = opened(surface=DOME)
    state.camera.aim(View(np.eye(3), np.zeros(3), 100.0))
    events = show(state, tmp_path, accepted)
    try:
        first = events.window.first_label
        assert first.isVisible() and "Press B" in first.text()
        events.keys("b")
        assert not first.isVisible(), "something has been begun"
        assert events.window.table.bound["draw-boundary"].action.isChecked()
        for place in CORNERS:
            events.drag(place)
        assert len(state.pen.clicked) == 4
        events.keys("Enter")
        assert state.finder.boundary is not None and state.finder.fills
        assert events.window.thumbnails.count() == len(state.finder.fills)
        events.window.thumbnails.setCurrentRow(1)
        assert state.finder.rank == 1
        events.keys("Left")
        assert state.finder.rank == 0
        check_looking(events, state.camera)
        monkeypatch.setattr(
            "viewer.shell.window.QFileDialog.getSaveFileName",
            lambda *_: (str(tmp_path / "mine"), ""),
        )
        asked = answer(monkeypatch, QMessageBox.StandardButton.Cancel)
        assert not events.window.close() and len(asked) == 1
        events.do("save-fill")
        fill = state.finder.fill
        assert fill is not None and (tmp_path / "mine.obj").read_text() == fill.pattern.name
        assert accepted == [fill] and "recorded" in events.window.message_label.text()
        assert events.window.close() and len(asked) == 1, "all is saved: nothing is asked"
    finally:
        events.close()
        state.close()


def test_an_odd_perimeter_keeps_the_fill_in_grey_and_offers_even_ones(flat: Events) -> None:
    state: ExplorerState = flat.window.state
    assert state.finder.placed is not None
    flat.move((0.0, -200.0))
    assert state.side_under() is not None
    flat.keys("+")
    assert state.finder.boundary is None and "odd" in flat.window.message_label.text()
    assert state.exploration.former is not None
    layers = [layer.name for layer in flat.window.saver.draw_live(600.0, 500.0).layers]
    assert "quads" in layers, "the fill of before is still seen"
    assert len(state.exploration.list_even_lengths()) == 8
    even = flat.window.even
    assert even.isVisible() and not flat.window.thumbnails.isVisible(), "where fills would be"
    (button,) = [
        one for one, side in even._sides.items() if (side, one.text()) == (1, "4")
    ]  # fmt: skip

    def list_selected() -> list[str]:
        layers = flat.window.saver.draw_live(600.0, 500.0).layers
        return [one.name for one in layers if getattr(one, "look", ("",))[0] == style.SELECTED]

    plain = list_selected()
    QApplication.sendEvent(button, QEvent(QEvent.Type.FocusIn))
    assert state.meant_side == 1 and list_selected() == ["side 1"] != plain, "its side is seen"
    button.click()
    flat.work()
    assert state.meant_side is None and flat.window.thumbnails.isVisible()
    assert sum(state.contour.lengths) % 2 == 0 and state.finder.fills
    flat.keys("Ctrl+Z", "Ctrl+Z")
    assert state.contour.lengths == (4, 3, 4, 3) and state.exploration.steps.undoable == 0
    flat.keys("Ctrl+Shift+Z")
    assert sum(state.contour.lengths) % 2 == 1


def test_wishes_are_heeded_and_taken_back(flat: Events) -> None:
    state: ExplorerState = flat.window.state
    every = len(state.finder.fills)
    flat.window.irregular.setValue(0)
    flat.work()
    assert all(fill.n_irregular == 0 for fill in state.finder.fills)
    assert len(state.finder.fills) < every
    flat.do("undo")
    assert len(state.finder.fills) == every and flat.window.irregular.value() == -1
    flat.window.valence.setValue(4)
    flat.work()
    for fill in state.finder.fills:
        assert max(fill.disk().valence()[fill.perimeter :], default=4) <= 4
    assert not flat.window.table.bound["draw-boundary"].action.isChecked()


def test_every_command_is_in_a_menu(flat: Events) -> None:
    check_actions(flat)
    bound = flat.window.table.bound
    assert not bound["previous-fill"].action.isEnabled() and bound["next-fill"].action.isEnabled()
    assert not bound["undo"].action.isEnabled() and not bound["drop-stroke"].action.isEnabled()
