"""How the viewer of feature curves looks at a model, and what is seen."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.viewer.layers import count_segments, find_layer
from tests.support.viewer.tents import at, drag, drawn, held, keys
from viewer.features import FeatureState
from viewer.features.picture import FeaturePainter
from viewer.features.pointing import make_matrix_camera, to_picture_place
from viewer.features.sliders import AXIS_OF
from viewer.stage import Faces


def test_the_view_turns_shifts_and_zooms(state: FeatureState) -> None:
    keys(state, "v")
    axes, focus, scale = state.camera.view.axes, state.camera.view.focus, state.camera.view.scale
    x, y = -state.camera.room[0] / 2.0 + 20.0, 40.0
    drag(state, (x, y), (x + 30.0, y))
    assert not np.allclose(state.camera.view.axes, axes)
    state.press(*at(state, 0.0, 0.0, 0.0), turn=True)
    before = state.camera.view.axes
    state.move(30.0, 60.0)
    state.release(30.0, 60.0)
    assert not np.allclose(state.camera.view.axes, before)
    assert state.wheel(1.0) and state.camera.view.scale > scale
    assert state.drag_view(10.0, 5.0) and not np.allclose(state.camera.view.focus, focus)
    keys(state, "v")
    assert np.allclose(state.camera.view.axes, axes) and state.camera.view.scale == pytest.approx(
        scale
    )


@pytest.mark.parametrize("presses", range(3))
def test_views_along_the_axes_have_the_upright_one_up(state: FeatureState, presses: int) -> None:
    keys(state, " ".join("g" * presses))
    up = np.array(AXIS_OF[state.camera.upright])
    for key in "12":
        toward: list[np.ndarray] = []
        for _ in range(3):
            keys(state, key)
            toward.append(state.camera.view.axes[2])
            assert state.camera.view.axes[1] == pytest.approx(up)
            assert np.abs(toward[-1]).max() == pytest.approx(1.0)
        assert toward[0] == pytest.approx(-toward[1])
        assert toward[0] == pytest.approx(toward[2])
    keys(state, "3")
    assert state.camera.view.axes[2] == pytest.approx(up)
    keys(state, "f")
    assert state.camera.view.axes[2] == pytest.approx(up)
    assert np.linalg.det(state.camera.view.axes) == pytest.approx(1.0)


def test_the_camera_sees_what_the_picture_shows(state: FeatureState) -> None:
    keys(state, "1")
    state.wheel(3.0)
    points = state.editing.model.vertices
    seen = make_matrix_camera(state.camera.view, state.editing.model, state.camera.room).seen_at(
        points
    )
    flat = state.camera.view.seen(points)[:, :2]
    places = np.stack([to_picture_place(state.camera.room, *place) for place in flat.tolist()])
    assert seen == pytest.approx(places, abs=1e-6)


def test_the_model_is_solid_transparent_or_hidden(curved: FeatureState) -> None:
    painter = FeaturePainter()
    drawings = {}
    for look in ("solid", "through", "hidden"):
        assert curved.camera.model_look == look
        drawings[look] = painter.compose(curved, 1040.0, 860.0)
        keys(curved, "m")
    names = {look: [layer.name for layer in drawings[look].layers] for look in drawings}
    assert "model" not in names["hidden"] and names["hidden"]
    assert names["solid"] == names["through"] == ["model", *names["hidden"]]
    solid, through = (find_layer(drawings[look], "model") for look in ("solid", "through"))
    assert isinstance(solid, Faces) and isinstance(through, Faces)
    assert through.faded and not solid.faded
    assert through.points is solid.points, "nothing is sent to VTK again"


def test_ribs_are_shown_on_demand(curved: FeatureState) -> None:
    painter = FeaturePainter()
    before = count_segments(painter.compose(curved, 1040.0, 860.0))
    keys(curved, "r")
    snap = held(curved)
    there = sum(rib is not None for rib in snap.ribs)
    after = count_segments(painter.compose(curved, 1040.0, 860.0))
    assert after - before == 48 * there > 0
    assert f"{len(snap.ribs)}" in drawn(curved)
    keys(curved, "r")
    assert count_segments(painter.compose(curved, 1040.0, 860.0)) == before
