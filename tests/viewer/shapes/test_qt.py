"""The window of the viewer of shape models on the shell: pulls, sliders, undo, closing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QMessageBox

from ingest.formats import read_mesh
from tests.support.viewer.events import Events, answer, check_actions, check_looking
from tests.support.viewer.shapes import car_shapes, car_template
from viewer.shapes import ShapesState
from viewer.shapes.docks import ShapesWindow
from viewer.shapes.window import ShapesSaver


def test_the_window_does_what_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state = ShapesState(car_shapes(), car_template(), held={"roof_rail"})
    saver = ShapesSaver(state, tmp_path / "car.obj", (640, 400))
    events = Events(saver, tmp_path, ShapesWindow)

    def middle(name: str) -> tuple[float, float]:
        line = next(i for i, one in enumerate(state.skin.lines) if one.name == name)
        seen = state.sight.lines[line]
        x, y = seen[len(seen) // 2, :2].tolist()
        return x, y

    try:
        check_actions(events)
        assert state.shaping.choice.held == {"roof_rail"}
        assert "roof rail" in events.window.facts.label.text()
        events.do("let-go")
        events.drag(middle("shoulder"))
        assert state.shaping.choice.held == {"shoulder"}
        at = middle("roof_rail")
        events.drag(at, (at[0] + 4.0, at[1] + 40.0))
        pulled = state.shaping.choice.coefficients
        assert pulled.any() and events.window.isWindowModified()
        events.keys("Ctrl+Z")
        assert not state.shaping.choice.coefficients.any()
        events.keys("Ctrl+Shift+Z")
        assert np.array_equal(state.shaping.choice.coefficients, pulled)
        # A slider that is dragged is one step, however often its value changes.
        row, name, line, field = events.window.modes.rows[1]
        line.setSliderDown(True)
        for at_line in (450, 400, 300):
            line.setValue(at_line)
        line.setSliderDown(False)
        assert state.shaping.sigmas[1] == pytest.approx(row.slider.value(0.3))
        events.do("undo")
        assert np.array_equal(state.shaping.choice.coefficients, pulled)
        field.setValue(1.5)
        assert state.shaping.sigmas[1] == pytest.approx(1.5) and state.chosen == 1
        # What keys change is marked, and what no training shape has is told.
        field.setValue(3.0)
        events.work()
        assert name.text().startswith("▸ mode 2") and name.text().endswith("training shapes)")
        events.keys("Up")
        assert not name.text().startswith("▸")
        events.do("undo")
        check_looking(events, state.camera)
        asked = answer(monkeypatch, QMessageBox.StandardButton.Cancel)
        events.keys("Escape")
        assert not events.window.close() and len(asked) == 1
        events.do("save-shape")
        assert np.array_equal(read_mesh(tmp_path / "car.obj").points, state.shaping.points)
        assert events.window.close() and len(asked) == 1
    finally:
        events.close()
