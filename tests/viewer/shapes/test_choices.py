"""Sliders, keys and the way back in the viewer of shape models."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import box_template
from tests.support.viewer.shapes import car_shapes, car_template, drag, keys, opened, seen, slide
from viewer.shapes import ShapesState
from viewer.shapes.commands import KEYS, NUDGE


@pytest.mark.parametrize("sigmas", [-3.0, -1.25, 0.4, 3.0])
def test_a_slider_sets_its_mode_alone(state: ShapesState, sigmas: float) -> None:
    """The shape is the mean and so many deviations of the mode; the drag is one step."""
    slide(state, 2, sigmas / 3.0, sigmas)
    wanted = np.zeros(state.shaping.shapes.n_modes)
    wanted[2] = sigmas * state.shaping.shapes.deviations[2]
    assert state.shaping.choice.coefficients == pytest.approx(wanted)
    assert state.shaping.points == pytest.approx(state.shaping.shapes.shape(wanted))
    low, high = state.shaping.box
    beyond = sigmas > high[2] or sigmas < low[2]
    assert abs(state.shaping.limits[2]) == (2 if beyond else 0)
    assert ("beyond the training shapes" in state.message) == beyond
    keys(state, "u")
    assert not state.shaping.choice.coefficients.any()
    keys(state, "U")
    assert state.shaping.sigmas[2] == pytest.approx(sigmas)


def test_modes_are_gone_through_by_keys(state: ShapesState) -> None:
    n = state.shaping.shapes.n_modes
    keys(state, "Up")
    assert state.chosen == n - 1
    keys(state, "Down Down")
    assert state.chosen == 1


def test_keys_are_known(state: ShapesState) -> None:
    assert KEYS.check("0 N Up") is not None
    with pytest.raises(ValueError, match="no key"):
        KEYS.check("ö")
    effects = KEYS.effects
    assert [KEYS.press(state, key) for key in effects] == list(effects.values())


def test_training_shapes_are_stepped_through(state: ShapesState) -> None:
    """n goes through all of them and round, b back; each as it was registered."""
    shapes = state.shaping.shapes
    for turn in range(len(shapes.names) + 1):
        keys(state, "n")
        k = turn % len(shapes.names)
        assert state.shaping.choice.origin == shapes.names[k]
        assert state.shaping.points == pytest.approx(
            shapes.shape(shapes.coefficients[k]), abs=1e-12
        )
        assert state.shaping.nearest == (shapes.names[k], pytest.approx(0.0, abs=1e-12))
    keys(state, "b b")
    assert state.shaping.choice.origin == shapes.names[-2]
    fresh = opened()
    keys(fresh, "b")
    assert fresh.shaping.choice.origin == shapes.names[-1]


def test_random_shapes_and_the_mean(state: ShapesState) -> None:
    keys(state, "r")
    first = state.shaping.choice.coefficients
    keys(state, "r")
    assert not np.allclose(first, state.shaping.choice.coefficients)
    low, high = state.shaping.shapes.box
    assert (state.shaping.choice.coefficients >= low).all() and (
        state.shaping.choice.coefficients <= high
    ).all()
    again = opened()
    keys(again, "r")
    assert np.array_equal(again.shaping.choice.coefficients, first)
    keys(state, "0")
    assert (
        state.shaping.points == pytest.approx(state.shaping.shapes.mean)
        and state.shaping.choice.origin == "mean"
    )


def test_arrow_keys_change_the_chosen_mode(state: ShapesState) -> None:
    keys(state, "Down Right Right Right Left")
    assert state.chosen == 1
    assert state.shaping.sigmas[1] == pytest.approx(2 * NUDGE)
    keys(state, "u")
    assert state.shaping.sigmas[1] == pytest.approx(3 * NUDGE)


def test_ghosts(state: ShapesState) -> None:
    assert state.shaping.ghost_coefficients() is None
    keys(state, "n n g")
    assert state.shaping.ghost_name == "mean" and not np.any(state.shaping.ghost_coefficients())
    keys(state, "g")
    assert state.shaping.ghost_name == state.shaping.shapes.names[1]
    assert state.shaping.ghost_coefficients() == pytest.approx(state.shaping.shapes.coefficients[1])
    keys(state, "g")
    assert state.shaping.ghost_coefficients() is None
    fresh = opened()
    keys(fresh, "g g")
    assert fresh.shaping.ghost_name == fresh.shaping.nearest[0]


def test_escape_drops_what_is_dragged(state: ShapesState) -> None:
    keys(state, "n")
    before = state.shaping.choice
    drag(state, seen(state, "roof_rail"), (0.0, 30.0), drop=False)
    for key in ["n", "r", "0", "u", "U", "c", "a", "1", "v", "Right", "Up"]:
        keys(state, key)
        assert "let go first" in state.message
    assert not state.wheel(1.0) and not state.drag_view(1.0, 1.0)
    keys(state, "Escape")
    assert state.shaping.choice is before and not state.dragging and state.shaping.pulled is None
    assert state.shaping.points == pytest.approx(state.shaping.shapes.shape(before.coefficients))
    assert not state.release(0.0, 0.0)
    keys(state, "u")
    assert state.shaping.choice.origin == "mean"


STEPS = ["n", "b", "r", "Right", "Left", "0", "Down", "pull", "slide", "hold", "weigh"]


@settings(max_examples=25)
@given(st.lists(st.sampled_from(STEPS), min_size=1, max_size=12))
def test_everything_can_be_taken_back_and_done_again(steps: list[str]) -> None:
    """After any steps: taking back all gives the beginning, doing again all gives the end."""
    state = opened()
    first = state.shaping.choice
    for step in steps:
        if step == "pull":
            drag(state, seen(state, "shoulder"), (7.0, 12.0))
        elif step == "slide":
            now = float(state.shaping.sigmas[1])
            slide(state, 1, now + 0.2, now + 0.3)
        elif step == "hold":
            state.shaping.toggle_held("roof_rail")
        elif step == "weigh":
            state.shaping.begin()
            state.shaping.set_hold(0.7 * state.shaping.choice.hold)
            state.shaping.finish()
        else:
            keys(state, step)
    last, points = state.shaping.choice, state.shaping.points.copy()
    count = 0
    while state.shaping.choice is not first:
        keys(state, "u")
        count += 1
        assert count <= len(steps)
    assert state.shaping.points == pytest.approx(state.shaping.shapes.mean)
    for _ in range(count):
        keys(state, "U")
    assert state.shaping.choice.is_like(last) and state.shaping.points == pytest.approx(points)
    keys(state, "U")
    assert state.message == "nothing was taken back"


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(InvalidFeatureError, match="give the one that its shapes were laid with"):
        ShapesState(car_shapes(), box_template(6))
    with pytest.raises(InvalidFeatureError, match="must be 5 finite numbers"):
        ShapesState(car_shapes(), car_template(), [1.0, 2.0])
    state = ShapesState(car_shapes(), car_template(), car_shapes().coefficients[3])
    assert state.shaping.choice.origin == "car 3"
