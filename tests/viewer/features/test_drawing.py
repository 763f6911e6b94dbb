"""Curves drawn in the viewer of feature curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features import editing
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.snap import Snap, SnapSettings
from tests.support.viewer.tents import (
    BESIDE,
    ON_RIDGE,
    at,
    click,
    curve_of,
    drag,
    drawn,
    grid,
    keys,
    line_of,
    opened,
    tent,
)
from viewer.camera import View
from viewer.features import FeatureState
from viewer.features.pointing import find_surface_point, make_matrix_camera, to_picture_place
from viewer.features.sliders import AXIS_OF


def test_clicks_make_a_curve_that_snaps_to_the_ridge(state: FeatureState) -> None:
    keys(state, "c")
    assert "click along a feature of the model    Esc: leave" in drawn(state)
    for count, (x, y) in enumerate(BESIDE, 1):
        click(state, *at(state, x, y, -abs(y)))
        assert state.editing.clicks is not None and len(state.editing.clicks) == count
        assert state.editing.clicks[-1] == pytest.approx((x, y, -abs(y)), abs=1e-6)
        assert (state.editing.preview is not None) == (count > 1)
    preview = state.editing.preview
    assert preview is not None
    assert np.abs(line_of(state, preview)[:, 1:]).max() < ON_RIDGE
    clicked = np.stack(state.editing.clicks or ())
    alone = Snap.begin(tent(), clicked, SnapSettings()).curve
    look = state.editing.look(preview)
    assert look is not None and (look.samples == alone.samples).all()
    keys(state, "Enter")
    assert state.editing.edits.curves == (preview,) and state.editing.selected == preview.key
    assert state.editing.clicks is None and state.editing.preview is None


def test_clicks_are_taken_back_one_by_one_and_dropped_by_escape(state: FeatureState) -> None:
    keys(state, "c")
    for x, y in BESIDE:
        click(state, *at(state, x, y, -abs(y)))
    for key, left in (("BackSpace", 2), ("u", 1), ("BackSpace", 0)):
        keys(state, key)
        assert state.editing.clicks is not None and len(state.editing.clicks) == left
        assert (state.editing.preview is None) == (left < 2)
        drawn(state)
    keys(state, "u")
    assert state.message == "there is no click to take back; Escape leaves"
    keys(state, "Enter")
    assert state.message == "click two points of the model at least"
    click(state, *at(state, -0.5, 0.02, -0.02))
    keys(state, "Escape")
    assert state.editing.clicks is None and not state.editing.edits.curves
    keys(state, "Enter")
    assert state.message.startswith("press c")


def test_clicks_into_a_narrow_gap_count_for_what_is_beside_it() -> None:
    points, faces = grid()
    # The roof's front half, and its mirror image, end short of the ridge over a floor.
    half = faces[(points[faces][..., 1] < 1e-9).all(axis=1)]
    front = points - (0.0, 0.004, 0.0)
    n = len(points)
    floor = np.array([[-1.0, -0.6, -2.0], [1.0, -0.6, -2.0], [1.0, 0.6, -2.0], [-1.0, 0.6, -2.0]])
    model = Surface.from_soup(
        PolygonMesh.from_faces(
            np.concatenate([front, front * (1.0, -1.0, 1.0), floor]),
            np.concatenate([half, half + n, 2 * n + np.array([[0, 1, 2], [0, 2, 3]])]),
        )
    )
    view, room = replace(opened_view(), focus=np.zeros(3)), (800.0, 800.0)

    def seen_at(view: View, *point: float) -> np.ndarray | None:
        x, y, _ = view.seen(np.array(point)).tolist()
        return find_surface_point(view, model, room, x, y)

    place = to_picture_place(room, *view.seen(np.array([0.2, 0.0, 0.0]))[:2].tolist())
    through = model.cast_rays(*make_matrix_camera(view, model, room).rays(place[None]))
    assert through.points[0, 2] == pytest.approx(-2.0)
    beside = seen_at(view, 0.2, 0.0, 0.0)
    assert beside == pytest.approx(np.array([0.2, 0.0, 0.0]), abs=0.02)
    # A wide opening is no gap, and neither is the model's edge.
    wide = replace(view, scale=40.0 * view.scale)
    assert seen_at(wide, 0.0, 0.0, 0.0) == pytest.approx(np.array([0.0, 0.0, -2.0]))
    assert seen_at(view, 1.02, 0.3, 0.0) is None


def opened_view() -> View:
    state = opened()
    state.close()
    return state.camera.view


def test_wrong_clicks_are_told(state: FeatureState) -> None:
    keys(state, "c")
    click(state, -state.camera.room[0] / 2.0 + 3.0, state.camera.room[1] / 2.0 - 3.0)
    assert state.message == "there is no model under the pointer" and state.editing.clicks == ()
    place = at(state, 0.1, 0.1, -0.1)
    click(state, *place)
    click(state, *place)
    assert state.message == "that point has been clicked already"
    assert state.editing.clicks is not None and len(state.editing.clicks) == 1


def test_a_drag_while_drawing_turns_the_view_and_clicks_nothing(state: FeatureState) -> None:
    keys(state, "c")
    axes = state.camera.view.axes
    x, y = at(state, 0.1, 0.1, -0.1)
    drag(state, (x, y), (x + 30.0, y + 10.0))
    assert state.editing.clicks == () and not np.allclose(state.camera.view.axes, axes)


def test_what_cannot_snap_is_told_and_makes_no_curve(
    state: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> Snap:
        raise InvalidFeatureError("none of the ribs meets the model")

    monkeypatch.setattr(editing, "snap_curve", fail)
    keys(state, "c")
    for x, y in BESIDE:
        click(state, *at(state, x, y, -abs(y)))
    assert "none of the ribs meets the model" in drawn(state)
    keys(state, "Enter")
    assert state.message == "none of the ribs meets the model"
    assert not state.editing.edits.curves and state.editing.clicks is not None


def test_a_failed_edit_leaves_the_curve_as_it_was(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = line_of(curved)
    before = curve_of(curved)

    def fail(*_: object) -> Snap:
        raise InvalidFeatureError("no such curve")

    monkeypatch.setattr(editing, "snap_curve", fail)
    keys(curved, "+ -")
    assert curve_of(curved) is not before and line_of(curved) is line
    assert "no such curve" in drawn(curved)
    assert curved.editing.session().curves == ()
    keys(curved, "u")
    assert curve_of(curved) is before and "no such curve" not in drawn(curved)


def test_settings_hold_for_the_curve_that_is_drawn(state: FeatureState) -> None:
    keys(state, "c")
    for x, y in BESIDE[:2]:
        click(state, *at(state, x, y, -abs(y)))
    keys(state, "- - . x")
    assert (
        state.editing.preview is not None
        and state.editing.preview.settings == state.editing.settings
    )
    assert state.editing.settings.axis == AXIS_OF["x"] and state.editing.settings.alpha < 1.0
    keys(state, "Enter")
    assert curve_of(state).settings == state.editing.settings
    keys(state, "u")
    assert not state.editing.edits.curves
