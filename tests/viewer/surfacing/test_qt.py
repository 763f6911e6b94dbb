"""The window of the viewer of surfaces on the shell: patches, strokes, alpha, undo."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.support.viewer.domes import FROM_ABOVE, Finder, growing_dome
from tests.support.viewer.events import Events, check_actions, check_looking
from viewer.surfacing import SurfacingState
from viewer.surfacing.docks import SurfacingWindow
from viewer.surfacing.window import SurfacingSaver


def test_the_window_does_what_it_is_told(tmp_path: Path) -> None:
    state = SurfacingState(growing_dome(), find=Finder(), **FROM_ABOVE)
    written: list[Path] = []
    saver = SurfacingSaver(state, tmp_path, lambda path, _: written.append(path), (960, 600))
    state.settle()
    events = Events(saver, tmp_path, SurfacingWindow, state.settle)
    try:
        check_actions(events)
        patch = tuple(state.camera.view.seen(np.array([0.4, 0.4, 0.8]))[:2].tolist())
        events.drag(patch)
        assert len(state.surfaces.patches) == 3 and saver.would_lose()
        events.do("undo")
        assert len(state.surfaces.patches) == 4
        events.do("redo")
        assert len(state.surfaces.patches) == 3
        before, edits = state.surfaces.edits, state.surfaces.edits
        for number in range(3):
            edits = edits.switched_off(state.surfaces.cycle_of(True, number))
        state.surfaces.steps.settle(edits)
        state.surfaces.ask()
        state.settle()
        assert "All patches are off" in saver.first_hint()
        state.surfaces.steps.settle(before)
        state.surfaces.ask()
        state.settle()
        assert saver.first_hint() == ""
        events.keys("Left")
        assert "no curves close a cycle" in saver.first_hint()
        assert state.surfaces.edits.stage == 2 and len(state.surfaces.patches) == 0
        events.keys("Right", "d")
        assert "drag a stroke" in events.window.hint_label.text()
        events.drag((-60.0, -60.0), (-150.0, -90.0))
        assert len(state.surfaces.edits.inks) == 1
        events.keys("Escape")
        assert not state.drawing_mode
        check_looking(events, state.camera)
        slider, field = events.window.sliders.rows[0][2:]
        field.setValue(0.25)
        assert state.surfaces.settings.alpha == 0.25
        events.work()
        assert abs(slider.value() - 500) <= 1, "places go by the square root"
        slider.setValue(1000)
        assert state.surfaces.settings.alpha == 1.0
        events.window._choose_method(
            "soap" if "soap" in state.surfaces.list_methods() else "chords"
        )
        saver.write(tmp_path / "a.obj")
        assert written == [tmp_path / "a.obj"] and not saver.would_lose()
    finally:
        events.close()
        state.close()
