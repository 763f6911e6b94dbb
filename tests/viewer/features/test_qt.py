"""The window of the viewer of feature curves on the shell: drawing, naming, sliders, saving."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QMessageBox

from patterndb_sketch.features.files.curvefiles import FeatureFiles
from patterndb_sketch.features.session import FEATURE_SESSION
from tests.support.viewer.events import Events, answer, check_actions, check_looking
from tests.support.viewer.tents import BESIDE, at, tent
from viewer.features import FeatureState
from viewer.features.docks import FeatureWindow
from viewer.features.sliders import name_axis
from viewer.features.window import FeatureSaver


def test_the_window_does_what_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = FeatureFiles(tmp_path, tmp_path / "roof.session")
    state = FeatureState(tent(), files=files)
    saver = FeatureSaver(state, files, (720, 450))
    events = Events(saver, tmp_path, FeatureWindow, state.settle)
    try:
        check_actions(events)
        events.keys("3", "c")
        assert "click along a feature" in events.window.hint_label.text()
        for x, y in BESIDE:
            events.drag(at(state, x, y, -abs(y)))
        assert state.editing.clicks is not None and len(state.editing.clicks) == 3
        asked = answer(monkeypatch, QMessageBox.StandardButton.Cancel)
        assert not events.window.close() and "being drawn" in asked[0]
        events.keys("Enter")
        curve = state.editing.curve
        assert curve is not None
        look = state.editing.look(curve)
        assert look is not None and np.abs(look.line[:, 1:]).max() < 0.01
        begun = at(state, *look.line[60])
        events.drag(begun, (begun[0], begun[1] + 14.0), (begun[0], begun[1] + 30.0))
        curve = state.editing.curve
        assert curve is not None and len(curve.constraints) == 1
        place = at(state, *curve.constraints[0][1])
        assert np.abs(np.array(place) - begun - (0.0, 30.0)).max() < 2.0, "where it was dropped"
        for row, _, _, field in events.window.sliders.rows:
            value = {"alpha": 0.5, "stiffness": 10.0, "isophote angle": 45.0}[row.slider.label]
            field.setValue(value)
            events.work()
            assert row.get() == pytest.approx(value)
        events.window.axis.textActivated.emit("x")
        events.window.degree.setValue(2)
        events.work()
        settings = state.editing.shown_settings
        assert (name_axis(settings), settings.degree) == ("x", 2)
        events.do("undo", "undo", "axis-y")
        assert events.window.axis.currentText() == "y" and events.window.degree.value() == 3
        events.do("name-curve")
        events.window.curves.item(0).setText("ridge")
        assert [one.name for one in state.editing.edits.curves] == ["ridge"]
        events.keys("r")
        assert state.editing.ribs_shown
        check_looking(events, state.camera)
        events.keys("Ctrl+S")
        (kept,) = FEATURE_SESSION.read(tmp_path / "roof.session").curves
        assert kept.name == "ridge"
        events.work()
        assert events.window.close() and len(asked) == 1
    finally:
        events.close()
        state.close()
