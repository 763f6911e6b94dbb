"""The window of retopology on the shell: tools, undo, fills in a dock, closing, recovery."""

from __future__ import annotations

from pathlib import Path

import pytest
from events import Events, answer, check_actions, check_looking
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox
from sheets import SQUARE, at

from patterndb_sketch.retopo.network import are_equal
from patterndb_sketch.retopo.script import Script
from patterndb_sketch.retopo.sessionfile import read_session
from viewer.retopo import RetopoState
from viewer.retopo.docks import RetopoWindow
from viewer.retopo.modes import list_modes
from viewer.retopo.window import RetopoSaver, RetopoWriter


def test_the_window_does_what_it_is_told(
    tmp_path: Path, state: RetopoState, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = tmp_path / "sheet.retopo"
    files = RetopoWriter(tmp_path, session, None, Script("sheet.obj", ()), None)
    state.editing.files = files
    saver = RetopoSaver(state, files, (720, 450))
    events = Events(saver, tmp_path, RetopoWindow, state.settle)
    keys = Qt.KeyboardModifier

    def press(*points: tuple[float, float], held: Qt.KeyboardModifier = keys.NoModifier) -> None:
        events.drag(*(at(state, point) for point in points), held=held)

    try:
        check_actions(events)
        for mode in list_modes():
            if mode.gesture != "act":
                events.do(f"tool-{mode.tool}")
                assert state.tool.mode.tool == mode.tool
                assert events.window.table.bound[f"tool-{mode.tool}"].action.isChecked()
        events.keys("d")
        for k in range(4):
            press(SQUARE[k - 1], SQUARE[k])
        (patch,) = state.network.patches.values()
        assert len(patch.corners) == 4
        asked = answer(monkeypatch, QMessageBox.StandardButton.Cancel)
        assert not events.window.close() and "not saved" in asked[0]
        events.keys("Ctrl+Z")
        assert not state.network.patches
        events.keys("Ctrl+Shift+Z")
        assert len(state.network.patches) == 1
        # The fills of the patch that was pointed at last can be taken with a click.
        events.do("tool-choose")
        events.move(at(state, (0.0, 0.0)))
        events.work()
        assert events.window.fills.count() > 1
        before = state.shown.filled
        events.window.fills.setCurrentRow(1)
        events.work()
        assert state.shown.filled is not before
        place = state.editing.place_in_list(patch.id)
        assert place is not None and place.number == 1
        # With Ctrl, curves nearby are moved, and the tool stays.
        moved = state.network
        press(SQUARE[0], (SQUARE[0][0] + 0.1, SQUARE[0][1] + 0.1), held=keys.ControlModifier)
        assert state.tool.mode.tool == "choose" and not are_equal(state.network, moved)
        count = sum(chain.count for chain in state.network.chains.values())
        events.wheel(at(state, (0.0, -1.5)), held=keys.ControlModifier)
        assert sum(chain.count for chain in state.network.chains.values()) != count
        check_looking(events, state.camera)
        # While a line is drawn commands wait, and closing asks.
        events.do("tool-stroke")
        events.press(at(state, (0.0, 1.0)))
        events.window.table.bound["undo"].action.trigger()
        assert "let go" in state.message
        assert not events.window.close() and "being drawn" in asked[-1]
        events.keys("Escape")
        events.keys("Ctrl+S")
        assert are_equal(read_session(session).state.network, state.network)
        events.work()
        count = len(asked)
        assert events.window.close() and len(asked) == count
    finally:
        events.close()


def test_options_of_the_tool_are_fields(tmp_path: Path, state: RetopoState) -> None:
    files = RetopoWriter(tmp_path, None, None, Script("sheet.obj", ()), None)
    saver = RetopoSaver(state, files, (720, 450))
    events = Events(saver, tmp_path, RetopoWindow, state.settle)
    try:
        mode = next(mode for mode in list_modes() if mode.options)
        events.do(f"tool-{mode.tool}")
        combo = events.window._combos[0]
        events.window._choose_option(0, 1)
        events.work()
        assert state.tool.option(mode, mode.options[0]) == mode.options[0].values[1]
        assert combo.currentIndex() == 1
        events.do("view-above")
        events.do("model-look", "model-look")
        assert state.camera.model_look == "hidden" and "hidden" in state.message
    finally:
        events.close()
