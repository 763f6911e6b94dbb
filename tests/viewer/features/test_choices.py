"""What keys and clicks choose in the viewer of feature curves, and the way back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.edits import snap_curve
from tests.support.viewer.tents import (
    at,
    click,
    curve_of,
    drag,
    drawn,
    held,
    keys,
    line_of,
    opened,
    picked,
    tent,
)
from viewer.features import FeatureState
from viewer.features.keys import KEYS
from viewer.features.sliders import AXIS_OF, SLIDERS, get_slider_value
from viewer.keymap import Effect


def test_curves_are_selected_by_a_click_and_tab(curved: FeatureState) -> None:
    picked(curved, ((-0.6, 0.4), (0.6, 0.45)))
    first, second = curved.editing.edits.curves
    assert curved.editing.selected == second.key
    click(curved, *at(curved, *line_of(curved, first)[60]))
    assert curved.editing.selected == first.key
    keys(curved, "ISO_Left_Tab")
    assert curved.editing.selected == second.key
    click(curved, -curved.camera.room[0] / 2.0 + 4.0, 0.0)
    assert curved.editing.selected is None
    assert "the sliders are those of the next curve" in drawn(curved)
    keys(curved, "Delete")
    assert curved.message.startswith("select a curve")
    keys(curved, "Tab Delete")
    assert curved.editing.edits.curves == (second,)
    keys(curved, "u")
    assert curved.editing.edits.curves == (first, second) and curved.editing.selected == first.key


def test_hidden_curves_are_not_under_the_pointer(curved: FeatureState) -> None:
    line = line_of(curved)
    keys(curved, "2")
    place = at(curved, *line[60])
    curved.move(*place)
    assert curved.under() is not None
    # From below, the roof itself hides its ridge, unless one can see through.
    below = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    curved.camera.view = replace(curved.camera.view, axes=below)
    shifted = curved.editing.model.vertices.copy()
    shifted[:, 2] -= 2.0
    faces = curved.editing.model.triangles
    both = np.concatenate([curved.editing.model.vertices, shifted])
    curved.editing.model = Surface.from_soup(
        PolygonMesh.from_faces(both, np.concatenate([faces, faces + len(shifted)]))
    )
    curved.move(*at(curved, *line[60]))
    assert curved.under() is None
    keys(curved, "m")
    assert curved.camera.model_look == "through" and curved.under() is not None


@pytest.mark.parametrize("name", SLIDERS)
def test_a_slider_changes_the_selected_curve_in_one_step(curved: FeatureState, name: str) -> None:
    base, snap = curve_of(curved), held(curved)
    slider = SLIDERS[name]
    curved.begin_sliding()
    for share in (0.1, 0.3, 0.5):
        curved.slide_to(name, slider.value(share))
        curved.settle()
    curved.end_sliding()
    curve = curve_of(curved)
    assert get_slider_value(curve.settings, name) == pytest.approx(slider.value(0.5))
    alone = snap.with_settings(curve.settings).curve
    assert (held(curved).curve.samples == alone.samples).all()
    assert curved.editing.settings == curve.settings
    keys(curved, "u")
    assert curve_of(curved) is base and curved.editing.shown_settings == base.settings


@pytest.mark.parametrize(
    ("keys_down", "keys_up", "name"),
    [("-", "+", "alpha"), (",", ".", "stiffness"), ("[", "]", "angle")],
)
def test_keys_move_sliders_to_their_ends(
    state: FeatureState, keys_down: str, keys_up: str, name: str
) -> None:
    slider = SLIDERS[name]
    for key, end in ((keys_up, slider.high), (keys_down, slider.low)):
        for _ in range(60):
            KEYS.press(state, key)
        assert get_slider_value(state.editing.settings, name) == pytest.approx(end)


def test_axes_and_degrees_are_chosen_by_keys(curved: FeatureState) -> None:
    keys(curved, "- x")
    assert curve_of(curved).settings.axis == AXIS_OF["x"]
    keys(curved, "y")
    assert curve_of(curved).settings.axis == AXIS_OF["y"]
    keys(curved, "z")
    assert curve_of(curved).settings.axis == AXIS_OF["z"]
    keys(curved, "Up")
    look = curved.editing.look(curve_of(curved))
    assert curve_of(curved).settings.degree == 4 and look is not None and look.spline.degree == 4
    keys(curved, "Down Down Down Down")
    assert curve_of(curved).settings.degree == 1 and "the degree is from 1" in curved.message


def test_snapping_again_goes_on_from_the_curve(curved: FeatureState) -> None:
    snap = held(curved)
    keys(curved, "a")
    assert (held(curved).curve.samples == snap.again().curve.samples).all()
    alone = snap_curve(tent(), curve_of(curved), None, None).curve
    assert (held(curved).curve.samples == alone.samples).all()


def test_a_curve_is_named(curved: FeatureState) -> None:
    curved.editing.rename("roof ridge")
    assert curve_of(curved).name == "roof ridge" and "roof ridge" in drawn(curved)
    assert line_of(curved) is not None and curved.editing.snap_of(curve_of(curved)) is not None
    picked(curved, ((-0.6, 0.4), (0.6, 0.45)))
    curved.editing.rename("roof ridge")
    assert "another curve" in curved.message
    curved.editing.rename("")
    assert "needs a name" in curved.message
    assert curve_of(curved).name == "curve 2"


ACTS = ("- x", "+", ".", "]", "a", "Up", "Tab", "Delete", "e", "u", "U", "pick", "pull")


@settings(max_examples=8)
@given(st.lists(st.sampled_from(ACTS), min_size=4, max_size=9))
def test_every_step_is_taken_back_and_done_again(acts: list[str]) -> None:
    state = opened()
    try:
        picked(state)
        for number, act in enumerate(acts):
            if act == "pick":
                picked(state, ((-0.6, 0.3 + 0.01 * number), (0.6, 0.4)))
            elif act == "pull" and state.editing.curve is not None:
                begun = at(state, *line_of(state)[30])
                drag(state, begun, (begun[0], begun[1] + 9.0))
            elif act == "e" and state.editing.curve is not None:
                state.editing.rename(f"name {number}")
            elif act != "pull" and act != "e":
                keys(state, act)
        end = state.editing.edits
        passed = [end]
        while state.message != "there is nothing to take back":
            keys(state, "u")
            passed.append(state.editing.edits)
            drawn(state)
        assert state.editing.edits.curves == ()
        for edits in reversed(passed[:-1]):
            assert state.editing.edits is edits
            keys(state, "U")
        # What was taken back before is done again, too.
        assert state.editing.edits is end or act_taken_back(acts)
    finally:
        state.close()


def act_taken_back(acts: list[str]) -> bool:
    return "u" in acts


def test_keys_are_known() -> None:
    assert KEYS.check("c Return minus C ISO_Left_Tab") is not None
    with pytest.raises(ValueError, match="no key 'zz'"):
        KEYS.check("c zz")
    state = opened()
    try:
        effects = KEYS.effects
        assert [KEYS.press(state, key) for key in effects] == list(effects.values())
        assert KEYS.press(state, "F13") is Effect.NOTHING
    finally:
        state.close()


def test_keys_without_anything_to_do_say_so(state: FeatureState) -> None:
    for key in ("Enter", "d", "Tab", "Delete", "a", "u", "U", "s", "o", "n"):
        keys(state, key)
        assert state.message, f"{key} says why nothing happens"
