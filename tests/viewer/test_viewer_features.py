"""The viewer of feature curves: its state under keys and pointer."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tents import BESIDE, at, click, drag, drawn, grid, keys, opened, picked, tent

from sketch.features.errors import InvalidFeatureError
from sketch.features.model import Model
from sketch.features.sessionfile import Session, read_session, write_session
from sketch.features.snap import Snap, SnapSettings
from viewer.features import FeatureState, work
from viewer.features.edits import Curve, Edits, remade
from viewer.features.keys import ACTIONS, EFFECTS, KEY_HELP, KEYS, MOUSE_HELP
from viewer.features.layout import (
    AXES,
    AXIS_OF,
    CHOICES,
    DEGREE,
    FIRST_ROW,
    RAILS,
    ROW,
    ROWS,
    rails,
    rows_shown,
    value_of,
)
from viewer.features.panel import CURSOR
from viewer.features.picture import Painter
from viewer.features.pointing import PIN, camera, place_in, surface_at
from viewer.features.shading import (
    AMBIENT,
    EDGE,
    FILL,
    KEY,
    MATTE,
    OF_FILL,
    OF_KEY,
    shaded,
)
from viewer.features.skin import CREASED, SMOOTH, Skin, smooth_normals
from viewer.keymap import Effect
from viewer.panel import MARGIN
from viewer.style import rgb
from viewer.view import View

#: How far a curve may be off the ridge: ribs are sampled so densely.
ON_RIDGE = 0.01


@pytest.fixture
def state() -> Iterator[FeatureState]:
    state = opened()
    yield state
    state.close()


@pytest.fixture
def curved() -> Iterator[FeatureState]:
    """With one curve on the ridge."""
    state = opened()
    picked(state)
    yield state
    state.close()


def curve_of(state: FeatureState) -> Curve:
    curve = state.curve
    assert curve is not None
    return curve


def line_of(state: FeatureState, curve: Curve | None = None) -> np.ndarray:
    look = state.look(curve_of(state) if curve is None else curve)
    assert look is not None
    return look.line


def held(state: FeatureState) -> Snap:
    snap = state.snap_of(curve_of(state))
    assert snap is not None
    return snap


def panel_at(state: FeatureState, x: float, y: float) -> tuple[float, float]:
    """A place of the panel, x from its left and y from below, from the picture's middle."""
    return x + state.room[0] / 2.0, y - state.room[1] / 2.0


# Picking


def test_clicks_make_a_curve_that_snaps_to_the_ridge(state: FeatureState) -> None:
    keys(state, "c")
    assert "click along a feature of the model    Esc: leave" in drawn(state)
    for count, (x, y) in enumerate(BESIDE, 1):
        click(state, *at(state, x, y, -abs(y)))
        assert state.clicks is not None and len(state.clicks) == count
        assert state.clicks[-1] == pytest.approx((x, y, -abs(y)), abs=1e-6)
        assert (state.preview is not None) == (count > 1)
    preview = state.preview
    assert preview is not None
    assert np.abs(line_of(state, preview)[:, 1:]).max() < ON_RIDGE
    clicked = np.stack(state.clicks or ())
    alone = Snap.begin(tent(), clicked, SnapSettings()).curve
    look = state.look(preview)
    assert look is not None and (look.samples == alone.samples).all()
    assert "drawing" in drawn(state)
    keys(state, "Enter")
    assert state.edits.curves == (preview,) and state.selected == preview.key
    assert state.clicks is None and state.preview is None


def test_clicks_are_taken_back_one_by_one_and_dropped_by_escape(state: FeatureState) -> None:
    keys(state, "c")
    for x, y in BESIDE:
        click(state, *at(state, x, y, -abs(y)))
    for key, left in (("BackSpace", 2), ("u", 1), ("BackSpace", 0)):
        keys(state, key)
        assert state.clicks is not None and len(state.clicks) == left
        assert (state.preview is None) == (left < 2)
        drawn(state)
    keys(state, "u")
    assert state.message == "there is no click to take back; Escape leaves"
    keys(state, "Enter")
    assert state.message == "click two points of the model at least"
    click(state, *at(state, -0.5, 0.02, -0.02))
    keys(state, "Escape")
    assert state.clicks is None and not state.edits.curves
    keys(state, "Enter")
    assert state.message.startswith("press c")


def test_clicks_into_a_narrow_gap_count_for_what_is_beside_it() -> None:
    points, faces = grid()
    # The roof's front half, and its mirror image, end short of the ridge over a floor.
    half = faces[(points[faces][..., 1] < 1e-9).all(axis=1)]
    front = points - (0.0, 0.004, 0.0)
    n = len(points)
    floor = np.array([[-1.0, -0.6, -2.0], [1.0, -0.6, -2.0], [1.0, 0.6, -2.0], [-1.0, 0.6, -2.0]])
    model = Model.from_arrays(
        np.concatenate([front, front * (1.0, -1.0, 1.0), floor]),
        np.concatenate([half, half + n, 2 * n + np.array([[0, 1, 2], [0, 2, 3]])]),
    )
    view, room = replace(opened_view(), focus=np.zeros(3)), (800.0, 800.0)

    def seen_at(view: View, *point: float) -> np.ndarray | None:
        x, y, _ = view.seen(np.array(point)).tolist()
        return surface_at(view, model, room, x, y)

    place = place_in(room, *view.seen(np.array([0.2, 0.0, 0.0]))[:2].tolist())
    through = model.first_hits(*camera(view, model, room).rays(place[None]))
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
    return state.view


def test_wrong_clicks_are_told(state: FeatureState) -> None:
    keys(state, "c")
    click(state, -state.room[0] / 2.0 + 3.0, state.room[1] / 2.0 - 3.0)
    assert state.message == "there is no model under the pointer" and state.clicks == ()
    place = at(state, 0.1, 0.1, -0.1)
    click(state, *place)
    click(state, *place)
    assert state.message == "that point has been clicked already"
    assert state.clicks is not None and len(state.clicks) == 1


def test_a_drag_while_drawing_turns_the_view_and_clicks_nothing(state: FeatureState) -> None:
    keys(state, "c")
    axes = state.view.axes
    x, y = at(state, 0.1, 0.1, -0.1)
    drag(state, (x, y), (x + 30.0, y + 10.0))
    assert state.clicks == () and not np.allclose(state.view.axes, axes)


def test_what_cannot_snap_is_told_and_makes_no_curve(
    state: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> Snap:
        raise InvalidFeatureError("none of the ribs meets the model")

    monkeypatch.setattr(work, "remade", fail)
    keys(state, "c")
    for x, y in BESIDE:
        click(state, *at(state, x, y, -abs(y)))
    assert "none of the ribs meets the model" in drawn(state)
    keys(state, "Enter")
    assert state.message == "none of the ribs meets the model"
    assert not state.edits.curves and state.clicks is not None


def test_a_failed_edit_leaves_the_curve_as_it_was(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = line_of(curved)
    before = curve_of(curved)

    def fail(*_: object) -> Snap:
        raise InvalidFeatureError("no such curve")

    monkeypatch.setattr(work, "remade", fail)
    keys(curved, "+ -")
    assert curve_of(curved) is not before and line_of(curved) is line
    assert "failed" in drawn(curved) and "no such curve" in drawn(curved)
    assert curved.session().curves == ()
    keys(curved, "u")
    assert curve_of(curved) is before and "failed" not in drawn(curved)


# Pulling


def test_a_pulled_sample_is_pinned_where_the_pointer_is(curved: FeatureState) -> None:
    base, snap = curve_of(curved), held(curved)
    begun = at(curved, *line_of(curved)[len(line_of(curved)) // 2])
    target = at(curved, 0.05, 0.06, -0.06)
    drag(curved, begun, (begun[0], begun[1] - 8.0), target)
    curve = curve_of(curved)
    assert curve.key == base.key and len(curve.constraints) == 1
    sample, point = curve.constraints[0]
    # The sample moved in the picture as the pointer did, and lies on the model.
    seen = camera(curved.view, curved.model, curved.room)
    moved = seen.seen_at(point[None])[0] - seen.seen_at(snap.curve.samples[sample][None])[0]
    assert moved == pytest.approx(np.array(target) - begun, abs=1e-6)
    assert curved.model.nearest(point[None]).lengths[0] < 1e-9
    alone = snap.with_constraints(((sample, point),)).curve
    assert (held(curved).curve.samples == alone.samples).all()
    found = held(curved).curve
    on = found.spline.evaluate(found.parameters[[sample]])[0]
    assert np.linalg.norm(on - point) < 1e-9
    # However often the pointer moved, it was one step.
    keys(curved, "u")
    assert curve_of(curved) is base
    keys(curved, "U")
    assert curve_of(curved) is curve


def test_a_pin_is_pulled_again_and_taken_away(curved: FeatureState) -> None:
    begun = at(curved, *line_of(curved)[60])
    drag(curved, begun, (begun[0] + 4.0, begun[1] - 30.0))
    sample, point = curve_of(curved).constraints[0]
    head = np.array(at(curved, *point)) + PIN
    curved.move(*head.tolist())
    under = curved.under()
    assert under is not None and under.pin == sample
    drawn(curved)
    drag(curved, tuple(head.tolist()), (head[0] - 9.0, head[1] + 12.0))
    again = curve_of(curved)
    assert [number for number, _ in again.constraints] == [sample]
    assert not np.allclose(again.constraints[0][1], point)
    # Where the pin was before leaves no trace.
    alone = Snap.begin(tent(), again.clicked).with_constraints(again.constraints).curve
    assert (held(curved).curve.samples == alone.samples).all()
    curved.move(*at(curved, *again.constraints[0][1]))
    keys(curved, "d")
    assert curve_of(curved).constraints == ()
    assert np.abs(line_of(curved)[:, 1:]).max() < ON_RIDGE
    keys(curved, "d")
    assert curved.message == "put the pointer on a pin"


def test_a_pull_beside_the_model_keeps_the_last_place(curved: FeatureState) -> None:
    begun = at(curved, *line_of(curved)[60])
    far = (-curved.room[0] / 2.0 + 2.0, curved.room[1] / 2.0 - 2.0)
    drag(curved, begun, (begun[0], begun[1] - 20.0), far)
    assert "the pointer left the model" in curved.message
    point = curve_of(curved).constraints[0][1]
    assert np.linalg.norm(np.array(at(curved, *point)) - begun) < 40.0


def test_the_curve_in_hand_is_shown_as_it_was_until_it_is_made(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = at(curved, *line_of(curved)[60])
    drag(curved, begun, (begun[0], begun[1] - 30.0))
    line, point = line_of(curved), curve_of(curved).constraints[0][1]
    going_on = threading.Event()

    def slow(*arguments: object) -> Snap:
        going_on.wait()
        return remade(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(work, "remade", slow)
    x, y = at(curved, *point)
    try:
        curved.press(x, y)
        curved.move(x + 8.0, y)
        assert line_of(curved) is line and not np.allclose(
            curve_of(curved).constraints[0][1], point
        )
        drawn(curved)
    finally:
        going_on.set()
    curved.settle()
    assert line_of(curved) is not line
    curved.release(x + 8.0, y)
    keys(curved, "u")
    assert line_of(curved) is line


def test_keys_wait_until_the_button_is_up(curved: FeatureState) -> None:
    begun = at(curved, *line_of(curved)[60])
    curved.move(*begun)
    curved.press(*begun)
    assert curved.holding
    curved.release(*begun)
    assert not curved.holding and curve_of(curved).constraints == ()


# Selecting


def test_curves_are_selected_by_a_click_a_row_and_tab(curved: FeatureState) -> None:
    picked(curved, ((-0.6, 0.4), (0.6, 0.45)))
    first, second = curved.edits.curves
    assert curved.selected == second.key
    click(curved, *at(curved, *line_of(curved, first)[60]))
    assert curved.selected == first.key
    click(curved, *panel_at(curved, 100.0, FIRST_ROW - ROW))
    assert curved.selected == second.key
    keys(curved, "Tab")
    assert curved.selected == first.key
    keys(curved, "ISO_Left_Tab")
    assert curved.selected == second.key
    click(curved, -curved.room[0] / 2.0 + 4.0, 0.0)
    assert curved.selected is None
    assert "the sliders are those of the next curve" in drawn(curved)
    keys(curved, "Delete")
    assert curved.message.startswith("select a curve")
    keys(curved, "Tab Delete")
    assert curved.edits.curves == (second,)
    keys(curved, "u")
    assert curved.edits.curves == (first, second) and curved.selected == first.key


@given(st.integers(0, 60), st.integers(0, 60))
def test_the_list_always_has_the_selected_curve(count: int, selected: int) -> None:
    chosen = selected if selected < count else None
    shown = rows_shown(count, chosen)
    assert len(shown) == min(count, ROWS) and set(shown) <= set(range(count))
    assert chosen is None or chosen in shown


def test_hidden_curves_are_not_under_the_pointer(curved: FeatureState) -> None:
    line = line_of(curved)
    keys(curved, "2")
    place = at(curved, *line[60])
    curved.move(*place)
    assert curved.under() is not None
    # From below, the roof itself hides its ridge, unless one can see through.
    below = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    curved.view = replace(curved.view, axes=below)
    shifted = curved.model.points.copy()
    shifted[:, 2] -= 2.0
    faces = curved.model.triangles
    both = np.concatenate([curved.model.points, shifted])
    curved.model = Model.from_arrays(both, np.concatenate([faces, faces + len(shifted)]))
    curved.move(*at(curved, *line[60]))
    assert curved.under() is None
    keys(curved, "m")
    assert curved.model_look == "through" and curved.under() is not None


# Sliders and choices


@pytest.mark.parametrize("name", RAILS)
def test_a_slider_changes_the_selected_curve_in_one_step(curved: FeatureState, name: str) -> None:
    base, snap = curve_of(curved), held(curved)
    rail = rails(curved.room[0])[name]
    places = [(x - curved.room[0] / 2.0, rail.y - curved.room[1] / 2.0)
              for x in (rail.left + 9.0, rail.left + 80.0, rail.left + 130.0)]  # fmt: skip
    drag(curved, *places)
    curve = curve_of(curved)
    value = rail.value_at(rail.left + 130.0)
    assert value_of(curve.settings, name) == pytest.approx(value)
    assert rail.slider.text(value) in drawn(curved)
    alone = snap.with_settings(curve.settings).curve
    assert (held(curved).curve.samples == alone.samples).all()
    assert curved.settings == curve.settings
    keys(curved, "u")
    assert curve_of(curved) is base and curved.shown_settings == base.settings


@pytest.mark.parametrize(
    ("keys_down", "keys_up", "name"),
    [("-", "+", "alpha"), (",", ".", "stiffness"), ("[", "]", "angle")],
)
def test_keys_move_sliders_to_their_ends(
    state: FeatureState, keys_down: str, keys_up: str, name: str
) -> None:
    slider = RAILS[name].slider
    for key, end in ((keys_up, slider.high), (keys_down, slider.low)):
        for _ in range(60):
            KEYS.press(state, key)
        assert value_of(state.settings, name) == pytest.approx(end)


def test_axes_and_degrees_are_chosen_by_keys_and_by_clicks(curved: FeatureState) -> None:
    keys(curved, "- x")
    assert curve_of(curved).settings.axis == AXIS_OF["x"]
    click(curved, *panel_at(curved, AXES["y"], CHOICES))
    assert curve_of(curved).settings.axis == AXIS_OF["y"]
    keys(curved, "z")
    assert curve_of(curved).settings.axis == AXIS_OF["z"]
    keys(curved, "Up")
    look = curved.look(curve_of(curved))
    assert curve_of(curved).settings.degree == 4 and look is not None and look.spline.degree == 4
    click(curved, *panel_at(curved, DEGREE[-1], CHOICES))
    assert curve_of(curved).settings.degree == 3
    keys(curved, "Down Down Down")
    assert curve_of(curved).settings.degree == 1 and "the degree is from 1" in curved.message


def test_settings_hold_for_the_curve_that_is_drawn(state: FeatureState) -> None:
    keys(state, "c")
    for x, y in BESIDE[:2]:
        click(state, *at(state, x, y, -abs(y)))
    keys(state, "- - . x")
    assert state.preview is not None and state.preview.settings == state.settings
    assert state.settings.axis == AXIS_OF["x"] and state.settings.alpha < 1.0
    keys(state, "Enter")
    assert curve_of(state).settings == state.settings
    keys(state, "u")
    assert not state.edits.curves


def test_snapping_again_goes_on_from_the_curve(curved: FeatureState) -> None:
    snap = held(curved)
    keys(curved, "a")
    assert (held(curved).curve.samples == snap.again().curve.samples).all()
    alone = remade(tent(), curve_of(curved), None, None).curve
    assert (held(curved).curve.samples == alone.samples).all()


# Names


def test_a_curve_is_named(curved: FeatureState) -> None:
    keys(curved, "e")
    assert curved.typed == "curve 1" and f"curve 1{CURSOR}" in drawn(curved)
    curved.typed = "roof ridge "
    curved.end_name()
    assert curve_of(curved).name == "roof ridge" and "roof ridge" in drawn(curved)
    assert line_of(curved) is not None and curved.snap_of(curve_of(curved)) is not None
    picked(curved, ((-0.6, 0.4), (0.6, 0.45)))
    for wrong, told in (("roof ridge", "another curve"), ("  ", "needs a name")):
        curved.begin_name()
        curved.typed = wrong
        curved.end_name()
        assert told in curved.message
    keys(curved, "e Escape")
    assert curved.typed is None and curve_of(curved).name == "curve 2"


# The way back


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
            elif act == "pull" and state.curve is not None:
                begun = at(state, *line_of(state)[30])
                drag(state, begun, (begun[0], begun[1] + 9.0))
            elif act == "e" and state.curve is not None:
                state.rename(f"name {number}")
            elif act != "pull" and act != "e":
                keys(state, act)
        end = state.edits
        passed = [end]
        while state.message != "there is nothing to take back":
            keys(state, "u")
            passed.append(state.edits)
            drawn(state)
        assert state.edits.curves == ()
        for edits in reversed(passed[:-1]):
            assert state.edits is edits
            keys(state, "U")
        # What was taken back before is done again, too.
        assert state.edits is end or act_taken_back(acts)
    finally:
        state.close()


def act_taken_back(acts: list[str]) -> bool:
    return "u" in acts


# Looking


def test_the_view_turns_shifts_and_zooms(state: FeatureState) -> None:
    keys(state, "v")
    axes, focus, scale = state.view.axes, state.view.focus, state.view.scale
    x, y = -state.room[0] / 2.0 + 20.0, 40.0
    drag(state, (x, y), (x + 30.0, y))
    assert not np.allclose(state.view.axes, axes)
    state.press(*at(state, 0.0, 0.0, 0.0), turn=True)
    before = state.view.axes
    state.move(30.0, 60.0)
    state.release(30.0, 60.0)
    assert not np.allclose(state.view.axes, before)
    assert state.wheel(1.0) and state.view.scale > scale
    assert state.drag_view(10.0, 5.0) and not np.allclose(state.view.focus, focus)
    keys(state, "v")
    assert np.allclose(state.view.axes, axes) and state.view.scale == pytest.approx(scale)


@pytest.mark.parametrize("presses", range(3))
def test_views_along_the_axes_have_the_upright_one_up(state: FeatureState, presses: int) -> None:
    keys(state, " ".join("g" * presses))
    up = np.array(AXIS_OF[state.upright])
    for key in "12":
        toward: list[np.ndarray] = []
        for _ in range(3):
            keys(state, key)
            toward.append(state.view.axes[2])
            assert state.view.axes[1] == pytest.approx(up)
            assert np.abs(toward[-1]).max() == pytest.approx(1.0)
        assert toward[0] == pytest.approx(-toward[1])
        assert toward[0] == pytest.approx(toward[2])
    keys(state, "3")
    assert state.view.axes[2] == pytest.approx(up)
    keys(state, "f")
    assert state.view.axes[2] == pytest.approx(up)
    assert np.linalg.det(state.view.axes) == pytest.approx(1.0)


def test_the_camera_sees_what_the_picture_shows(state: FeatureState) -> None:
    keys(state, "1")
    state.wheel(3.0)
    points = state.model.points
    seen = camera(state.view, state.model, state.room).seen_at(points)
    flat = state.view.seen(points)[:, :2]
    places = np.stack([place_in(state.room, *place) for place in flat.tolist()])
    assert seen == pytest.approx(places, abs=1e-6)


def test_the_model_is_solid_transparent_or_hidden(curved: FeatureState) -> None:
    painter = Painter()
    count = len(curved.model.triangles)
    drawings = {}
    for look in ("solid", "through", "hidden"):
        assert curved.model_look == look
        drawings[look] = painter.compose(curved, 1.6).solid
        keys(curved, "m")
    lines = len(drawings["hidden"].corners)
    assert lines and all(
        len(drawings[look].corners) == lines + count for look in ("solid", "through")
    )
    solid, through = drawings["solid"], drawings["through"]
    assert (through.colours[:count] > solid.colours[:count]).all()
    assert through.corners[:count, :, 2].max() < through.corners[count:, :, 2].min()


def test_ribs_are_shown_on_demand(curved: FeatureState) -> None:
    painter = Painter()
    before = len(painter.compose(curved, 1.6).solid.corners)
    keys(curved, "r")
    snap = held(curved)
    there = sum(rib is not None for rib in snap.ribs)
    after = len(painter.compose(curved, 1.6).solid.corners)
    assert after - before > 100 * there > 0
    assert f"{len(snap.ribs)}" in drawn(curved)
    keys(curved, "r")
    assert len(painter.compose(curved, 1.6).solid.corners) == before


# In the background


def test_the_window_goes_on_while_a_curve_is_made(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    going_on = threading.Event()

    def slow(*arguments: object) -> Snap:
        going_on.wait()
        return remade(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(work, "remade", slow)
    try:
        line = line_of(curved)
        KEYS.press(curved, "-")
        assert curved.making and line_of(curved) is line and not curved.poll()
        picked_key = curved.selected
        curved.wheel(1.0)
        assert "working …" in drawn(curved)
        KEYS.press(curved, "-")
        wanted = curve_of(curved).settings
    finally:
        going_on.set()
    curved.settle()
    assert curved.selected == picked_key and not curved.making
    assert held(curved).settings == wanted
    assert "working …" not in drawn(curved)


def test_what_goes_wrong_in_the_background_is_not_lost(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> Snap:
        raise ZeroDivisionError("a mistake")

    monkeypatch.setattr(work, "remade", broken)
    with pytest.raises(ZeroDivisionError):
        KEYS.press(curved, "-")
        curved.settle()


# Sessions


def test_a_session_is_saved_and_opened_again(curved: FeatureState, tmp_path: Path) -> None:
    begun = at(curved, *line_of(curved)[60])
    drag(curved, begun, (begun[0], begun[1] - 25.0))
    keys(curved, "- - x")
    picked(curved, ((-0.6, 0.4), (0.6, 0.45)))
    keys(curved, ". . ]")
    written = curved.session()
    write_session(tmp_path / "a", replace(written, mesh="roof.obj"))
    again = opened(session=read_session(tmp_path / "a"))
    try:
        for one, other in zip(curved.edits.curves, again.edits.curves, strict=True):
            assert (one.name, one.settings) == (other.name, other.settings)
            assert (one.clicked == other.clicked).all()
            assert [n for n, _ in one.constraints] == [n for n, _ in other.constraints]
            assert (line_of(curved, one) == line_of(again, other)).all()
        assert again.settings == curved.settings and not again.unsaved
        assert again.session().settings == written.settings
        assert again.session().mesh == "roof.obj"
        # What was opened is shown as it was until it is changed, and can be changed.
        again.select(again.edits.curves[0].key)
        again.settle()
        assert (line_of(again) == line_of(curved, curved.edits.curves[0])).all()
        keys(again, "+ a")
        assert again.unsaved and not again.trouble(curve_of(again))
    finally:
        again.close()


def test_given_settings_come_before_the_session_s() -> None:
    session = Session(settings={"alpha": 0.25, "stiffness": 7.0, "else": 3.0})
    state = opened(session=session, settings=SnapSettings(alpha=0.5))
    try:
        assert (state.settings.alpha, state.settings.stiffness) == (0.5, 7.0)
        assert state.session().settings["else"] == 3.0
    finally:
        state.close()
    with pytest.raises(InvalidFeatureError, match="alpha"):
        FeatureState(tent(), session=Session(settings={"alpha": 7.0}))


# Keys


def test_the_help_lists_every_key() -> None:
    listed = {key for names, _ in KEY_HELP for key in names.split()}
    written = {"BackSpace": "⌫", "Delete": "Del", "Up": "↑", "Down": "↓", "BackTab": "Tab"}
    for key in [*ACTIONS, *EFFECTS]:
        assert written.get(key, key) in listed, f"the help lists {key}"
    others = {"drag", "click", "?", "Esc"}
    known = {written.get(key, key) for key in [*ACTIONS, *EFFECTS]}
    assert listed == known | others, "the help lists nothing else"
    assert KEYS.check("c Return space minus question Escape") is not None
    state = opened()
    try:
        assert [KEYS.press(state, key) for key in EFFECTS] == list(EFFECTS.values())
        assert KEYS.press(state, "F13") is Effect.NOTHING
        keys(state, "h")
        texts = drawn(state)
        assert state.helping and MOUSE_HELP in texts and all(what in texts for _, what in KEY_HELP)
        keys(state, "Escape")
        assert not state.helping and KEYS.press(state, "Escape") is Effect.QUIT
    finally:
        state.close()


def test_keys_without_anything_to_do_say_so(state: FeatureState) -> None:
    for key in ("Enter", "d", "Tab", "Delete", "e", "a", "u", "U", "s", "o", "n"):
        keys(state, key)
        assert state.message, f"{key} says why nothing happens"


# The model


def test_normals_are_smooth_but_at_creases_whatever_the_sense(curved: FeatureState) -> None:
    model = curved.model
    normals = smooth_normals(model.corners, model.triangles)
    assert np.linalg.norm(normals, axis=2) == pytest.approx(1.0)
    own = np.cross(
        model.corners[:, 1] - model.corners[:, 0], model.corners[:, 2] - model.corners[:, 0]
    )
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    # Two slopes at a right angle: each keeps its own normal up to the ridge.
    assert np.einsum("tkc,tc->tk", normals, own) == pytest.approx(1.0)


@given(st.integers(0, 2**31))
def test_normals_equal_a_slow_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, faces = grid()
    points, faces = points[:40] + rng.normal(0.0, 0.03, (40, 3)), faces[(faces < 40).all(axis=1)]
    corners = points[faces]
    normals = smooth_normals(corners, faces.astype(np.int32))
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(own, axis=1)
    unit = own / area[:, None]
    for t in rng.choice(len(faces), 5).tolist():
        for c in range(3):
            total = np.zeros(3)
            for u in np.flatnonzero((faces == faces[t, c]).any(axis=1)):
                cosine = unit[t] @ unit[u]
                share = np.clip((abs(cosine) - CREASED) / (SMOOTH - CREASED), 0.0, 1.0)
                total += np.sign(cosine) * share * area[u] * unit[u]
            assert normals[t, c] == pytest.approx(total / np.linalg.norm(total), abs=1e-9)


def test_a_model_is_shaded_alike_in_either_sense(state: FeatureState) -> None:
    skin = Skin.of(state.model)
    seen, colours = shaded(skin, state.view, (0.0, 0.0), through=False)
    turned = Skin(skin.corners[:, ::-1], -skin.normals[:, ::-1])
    again, others = shaded(turned, state.view, (0.0, 0.0), through=False)
    assert (again[:, ::-1] == seen).all() and others[:, ::-1] == pytest.approx(colours, abs=1e-6)
    assert colours.min() > 0.3 and colours.max() <= 1.0


def test_shading_equals_a_slow_reference(state: FeatureState) -> None:
    keys(state, "v")
    skin, view = state.skin, state.view
    seen, colours = shaded(skin, view, (30.0, -20.0), through=False)
    assert seen == pytest.approx(view.seen(skin.corners) + np.array([30.0, -20.0, 0.0]))
    one, other = seen[:, 1, :2] - seen[:, 0, :2], seen[:, 2, :2] - seen[:, 0, :2]
    away = one[:, 0] * other[:, 1] < one[:, 1] * other[:, 0]
    normals = np.where(away[:, None, None], -1.0, 1.0) * (skin.normals @ view.axes.T)
    bright = AMBIENT + OF_KEY * np.clip(normals @ KEY, 0.0, 1.0)
    bright += OF_FILL * np.clip(normals @ FILL, 0.0, 1.0)
    bright *= 1.0 - EDGE * (1.0 - np.abs(normals[..., 2])) ** 3
    assert colours == pytest.approx(np.minimum(bright[..., None] * rgb(MATTE), 1.0), abs=1e-5)


def test_curves_keep_their_place_when_they_are_edited() -> None:
    settings = SnapSettings()
    a, b, c = (Curve(i, f"curve {i + 1}", np.zeros((2, 3)), settings) for i in range(3))
    edits = Edits((a, b))
    after = edits.with_curve(replace(a, name="x")).with_curve(c)
    assert [one.name for one in after.curves] == ["x", "curve 2", "curve 3"]
    assert after.free_name() == "curve 4" and after.without(1).find(1) is None
    assert Edits((replace(a, name="curve 2"),)).free_name() == "curve 3"
    pinned = a.pinned(4, np.ones(3)).pinned(2, np.zeros(3)).pinned(4, np.zeros(3))
    assert [number for number, _ in pinned.constraints] == [2, 4]
    assert pinned.unpinned(2).unpinned(4).constraints == ()


def test_margins_leave_room_for_the_panel() -> None:
    assert all(MARGIN <= rail.left < rail.right for rail in RAILS.values())
