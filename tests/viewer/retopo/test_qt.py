"""The window of retopology on the shell: tools, undo, fills in a dock, closing, recovery."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

from patterndb_sketch.retopo.files import RetopoFiles
from patterndb_sketch.retopo.network import are_equal
from patterndb_sketch.retopo.script import Script
from patterndb_sketch.retopo.session import RETOPO_SESSION
from tests.support.viewer.events import Events, answer, check_actions, check_looking
from tests.support.viewer.sheets import SQUARE, at
from viewer.retopo import RetopoState
from viewer.retopo.docks import RetopoWindow
from viewer.retopo.modes import list_modes
from viewer.retopo.window import RetopoSaver


def test_the_window_does_what_it_is_told(
    tmp_path: Path, state: RetopoState, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = tmp_path / "sheet.retopo"
    files = RetopoFiles(tmp_path, session, None, Script("sheet.obj", ()), None)
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
        assert are_equal(RETOPO_SESSION.read(session).state.network, state.network)
        events.work()
        count = len(asked)
        assert events.window.close() and len(asked) == count
    finally:
        events.close()


def test_options_of_the_tool_are_fields(tmp_path: Path, state: RetopoState) -> None:
    files = RetopoFiles(tmp_path, None, None, Script("sheet.obj", ()), None)
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


def test_letters_are_commands_whatever_field_was_used(tmp_path: Path, state: RetopoState) -> None:
    files = RetopoFiles(tmp_path, None, None, Script("sheet.obj", ()), None)
    events = Events(RetopoSaver(state, files, (720, 450)), tmp_path, RetopoWindow, state.settle)
    try:
        events.do("tool-cylinder")
        window = events.window
        for key, tool in (("l", "loop"), ("c", "cylinder")):
            for at in range(3):
                # Options change with the tool.
                events.do("tool-align")
                field = [window._combos[0], window._combos[-1], window.fills][at]
                field.setFocus(Qt.FocusReason.MouseFocusReason)
                QTest.keyClick(field, key)
                events.work()
                assert state.tool.mode.tool == tool
        # A combo box that was used with the mouse gives the focus back.
        combo = window._combos[0]
        combo.setFocus(Qt.FocusReason.MouseFocusReason)
        QTest.mousePress(combo, Qt.MouseButton.LeftButton)
        combo.hidePopup()
        QApplication.sendEvent(
            combo, QFocusEvent(QEvent.Type.FocusIn, Qt.FocusReason.PopupFocusReason)
        )
        events.work()
        assert not combo.hasFocus()
    finally:
        events.close()


def test_what_is_typed_is_an_argument_of_mirror_and_draft(
    tmp_path: Path, state: RetopoState
) -> None:
    files = RetopoFiles(tmp_path, None, None, Script("sheet.obj", ()), None)
    events = Events(RetopoSaver(state, files, (720, 450)), tmp_path, RetopoWindow, state.settle)
    try:
        rows = {(mode.tool, option.name): row for mode, option, row in events.window._rows}
        assert ("draft", "edge") in rows and ("symmetry", "tolerance") in rows
        rows["symmetry", "normal"].setText("0, 1, 0")
        rows["symmetry", "normal"].editingFinished.emit()
        rows["symmetry", "point"].setText("0 1 0")
        rows["symmetry", "point"].editingFinished.emit()
        events.do("tool-symmetry")
        events.work()
        plane = state.shown.state.plane
        assert plane is not None
        places = np.array([[3.0, 1.0, 0.0], [0.0, 2.5, 0.0]])
        assert plane.heights(places).tolist() == [0.0, 1.5]
        events.do("tool-symmetry")
        events.work()
        assert state.shown.state.plane is None
        rows["symmetry", "normal"].setText("up")
        rows["symmetry", "normal"].editingFinished.emit()
        assert "give [x, y, z]" in state.message
    finally:
        events.close()


@pytest.mark.parametrize("way", ["&Reload", "Save &as…", "&Overwrite", "Cancel"])
def test_a_session_that_another_window_saved_is_asked_about(
    tmp_path: Path, state: RetopoState, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    path, other = tmp_path / "a.retopo", tmp_path / "b.retopo"
    files = RetopoFiles(tmp_path, path, None, Script("sheet.obj", ()), None)
    state.editing.files = files
    files.save_session(state.surface, state.shown.state)
    events = Events(RetopoSaver(state, files, (720, 450)), tmp_path, RetopoWindow, state.settle)
    try:
        empty = path.read_bytes()
        state.editing.do("stroke", points=[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
        events.work()
        theirs = empty
        # As if it had been something else when it was saved here.
        files.known.mistrust(path)
        asked: list[str] = []

        def choose(box: QMessageBox) -> int:
            asked.append(box.text())
            named = {button.text(): button for button in box.buttons()}
            chosen = named.get(way) or box.button(QMessageBox.StandardButton.Cancel)
            monkeypatch.setattr(box, "clickedButton", lambda: chosen, raising=False)
            return 0

        monkeypatch.setattr(QMessageBox, "exec", choose)
        monkeypatch.setattr(
            "viewer.shell.window.QFileDialog.getSaveFileName", lambda *_: (str(other), "")
        )
        drawn = state.network
        events.do("save")
        events.work()
        assert asked == ["a.retopo has changed since it was opened or saved here."]
        if way == "&Overwrite":
            assert are_equal(RETOPO_SESSION.read(path).state.network, drawn)
        else:
            assert path.read_bytes() == theirs
        if way == "Save &as…":
            assert are_equal(RETOPO_SESSION.read(other).state.network, drawn)
            assert files.session_path == other
        assert state.editing.unsaved == (way == "Cancel")
        assert are_equal(state.network, drawn) == (way != "&Reload")
    finally:
        events.close()
