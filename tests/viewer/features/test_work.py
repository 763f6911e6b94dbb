"""What the viewer of feature curves does in the background, and its sessions."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.features import editing
from patterndb_sketch.features.edits import DrawnCurve, FeatureEdits, snap_curve
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from patterndb_sketch.features.snap import Snap, SnapSettings
from tests.support.viewer.tents import (
    at,
    curve_of,
    drag,
    drawn,
    held,
    keys,
    line_of,
    opened,
    picked,
)
from viewer.features import FeatureState
from viewer.features.keys import KEYS


def test_the_window_goes_on_while_a_curve_is_made(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    going_on = threading.Event()

    def slow(*arguments: object) -> Snap:
        going_on.wait()
        return snap_curve(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(editing, "snap_curve", slow)
    try:
        line = line_of(curved)
        KEYS.press(curved, "-")
        assert curved.editing.making and line_of(curved) is line and not curved.poll()
        picked_key = curved.editing.selected
        curved.wheel(1.0)
        assert "working …" in drawn(curved)
        KEYS.press(curved, "-")
        wanted = curve_of(curved).settings
    finally:
        going_on.set()
    curved.settle()
    assert curved.editing.selected == picked_key and not curved.editing.making
    assert held(curved).settings == wanted
    assert "working …" not in drawn(curved)


def test_what_goes_wrong_in_the_background_is_not_lost(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> Snap:
        raise ZeroDivisionError("a mistake")

    monkeypatch.setattr(editing, "snap_curve", broken)
    with pytest.raises(ZeroDivisionError):
        KEYS.press(curved, "-")
        curved.settle()


def test_a_session_is_saved_and_opened_again(curved: FeatureState, tmp_path: Path) -> None:
    begun = at(curved, *line_of(curved)[60])
    drag(curved, begun, (begun[0], begun[1] - 25.0))
    keys(curved, "- - x")
    picked(curved, ((-0.6, 0.4), (0.6, 0.45)))
    keys(curved, ". . ]")
    written = curved.editing.session()
    FEATURE_SESSION.write(tmp_path / "a", replace(written, mesh="roof.obj"))
    again = opened(session=FEATURE_SESSION.read(tmp_path / "a"))
    try:
        for one, other in zip(curved.editing.edits.curves, again.editing.edits.curves, strict=True):
            assert (one.name, one.settings) == (other.name, other.settings)
            assert (one.clicked == other.clicked).all()
            assert [n for n, _ in one.constraints] == [n for n, _ in other.constraints]
            assert (line_of(curved, one) == line_of(again, other)).all()
        assert again.editing.settings == curved.editing.settings and not again.editing.unsaved
        assert again.editing.session().settings == written.settings
        assert again.editing.session().mesh == "roof.obj"
        # What was opened is shown as it was until it is changed, and can be changed.
        again.editing.select(again.editing.edits.curves[0].key)
        again.settle()
        assert (line_of(again) == line_of(curved, curved.editing.edits.curves[0])).all()
        keys(again, "+ a")
        assert again.editing.unsaved and not again.editing.trouble(curve_of(again))
    finally:
        again.close()


def test_given_settings_come_before_the_session_s() -> None:
    session = FeatureSession(settings=SnapSettings(alpha=0.25, stiffness=7.0))
    state = opened(session=session, settings=SnapSettings(alpha=0.5))
    try:
        assert (state.editing.settings.alpha, state.editing.settings.stiffness) == (0.5, 7.0)
        assert state.editing.session().settings == state.editing.settings
    finally:
        state.close()


def test_curves_keep_their_place_when_they_are_edited() -> None:
    settings = SnapSettings()
    a, b, c = (DrawnCurve(i, f"curve {i + 1}", np.zeros((2, 3)), settings) for i in range(3))
    edits = FeatureEdits((a, b))
    after = edits.with_curve(replace(a, name="x")).with_curve(c)
    assert [one.name for one in after.curves] == ["x", "curve 2", "curve 3"]
    assert after.free_name() == "curve 4" and after.without(1).find(1) is None
    assert FeatureEdits((replace(a, name="curve 2"),)).free_name() == "curve 3"
    pinned = a.pinned(4, np.ones(3)).pinned(2, np.zeros(3)).pinned(4, np.zeros(3))
    assert [number for number, _ in pinned.constraints] == [2, 4]
    assert pinned.unpinned(2).unpinned(4).constraints == ()
