"""Curves of a shape pulled and held."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.shapemodel import edit, pull_feature, shaping
from patterndb_sketch.features.shapemodel.edit import STIFFNESS
from patterndb_sketch.features.shapemodel.shaping import SIGMAS, STIFF
from tests.support.viewer.shapes import drag, keys, number, opened, seen
from viewer.camera import View
from viewer.shapes import ShapesState
from viewer.shapes.sight import find_displacement

MIRROR = np.array([1.0, -1.0, 1.0])


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.floats(-300, 300), st.floats(-300, 300))
def test_a_pull_goes_where_the_pointer_goes(seed: int, dx: float, dy: float) -> None:
    """On the screen exactly; along an axis to the place of the seen axis nearest to the pointer,
    and never beside the axis."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    view = View(axes, rng.normal(size=3), float(rng.uniform(10.0, 300.0)))
    flat = find_displacement(view, dx, dy, None)
    assert flat is not None
    assert (flat @ axes.T) * view.scale == pytest.approx([dx, dy, 0.0], abs=1e-8)
    for axis in range(3):
        along = find_displacement(view, dx, dy, axis)
        short = np.linalg.norm(axes[:2, axis])
        assert (along is None) == (short < 0.15)
        if along is not None:
            assert not np.delete(along, axis).any()
            off = (axes[:2] @ along) * view.scale - (dx, dy)
            assert off @ axes[:2, axis] == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("bending", [False, True])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_dragged_curve_gives_the_edit_of_its_pull(
    state: ShapesState, bending: bool, mirrored: bool
) -> None:
    """The coefficients are those of equation 6 for the displacement that the pointer means; of
    a mirror image, for the mirrored displacement."""
    state.shaping.set_mode(1, 0.7)
    if mirrored:
        # Its own half hides the other.
        state.camera.aim(
            View(
                state.camera.view.axes @ np.diag(MIRROR),
                state.camera.view.focus,
                state.camera.view.scale,
            )
        )
    if bending:
        keys(state, "m")
    start = state.shaping.choice.coefficients
    where = seen(state, "roof_rail", mirrored=mirrored)
    drag(state, where, (13.0, 21.0))
    offset = find_displacement(state.camera.view, 13.0, 21.0, None)
    assert offset is not None
    shapes = state.shaping.shapes
    place = len(shapes.feature("roof_rail").vertices) // 2 if bending else None
    pull = offset * MIRROR if mirrored else offset
    targets = pull_feature(shapes, "roof_rail", pull, start=start, vertex=place)
    wanted = edit(shapes, targets, start=start, stiffness=STIFFNESS)
    assert state.shaping.choice.coefficients == pytest.approx(wanted.coefficients, abs=1e-12)
    assert state.shaping.points == pytest.approx(wanted.points)
    assert state.shaping.choice.origin == "edited"
    keys(state, "u")
    assert np.array_equal(state.shaping.choice.coefficients, start)


def test_a_pull_shows_where_the_curve_should_be_and_how_far_it_is_short(
    state: ShapesState,
) -> None:
    """Of a pull that no shape of the box fulfils: the note's number is the greatest distance of
    the curve from its target, and coefficients at their limits are marked."""
    where = seen(state, "roof_rail")
    keys(state, "z")
    drag(state, where, (0.0, 240.0), drop=False)
    pulled = state.shaping.pulled
    assert pulled is not None
    line = state.skin.lines[number(state, "roof_rail")]
    away = np.linalg.norm(state.shaping.points[line.vertices] - pulled.wanted, axis=1).max()
    assert away == pytest.approx(pulled.miss) and away > 0.05
    found = re.search(r"short of the pull by up to (\S+) units; (\d+) mode", state.message)
    assert found is not None and float(found[1]) == pytest.approx(away, rel=0.01)
    low, high = state.shaping.box
    at = (state.shaping.sigmas <= low + 1e-9) | (state.shaping.sigmas >= high - 1e-9)
    assert at.any() and int(found[2]) == at.sum()
    assert np.array_equal(state.shaping.limits != 0, at)
    assert (state.shaping.sigmas >= low - 1e-9).all() and (
        state.shaping.sigmas <= high + 1e-9
    ).all()
    state.release(*state.camera.pointer or (0.0, 0.0))
    assert state.shaping.pulled is None and not state.dragging


def test_a_small_pull_is_followed(state: ShapesState) -> None:
    """A shape that lies between the known ones is reached: pulled towards it, the curve is
    where the pointer is, and nothing is said."""
    keys(state, "x")
    where = seen(state, "front_corner")
    line = state.skin.lines[number(state, "front_corner")]
    before = state.shaping.points[line.vertices].copy()
    drag(state, where, (10.0, 0.0), drop=False)
    assert state.shaping.pulled is not None
    wanted = state.shaping.pulled.wanted - before
    assert wanted[:, 1:] == pytest.approx(0.0) and np.ptp(wanted[:, 0]) == pytest.approx(0.0)
    assert state.shaping.pulled.miss < 0.2 * np.abs(wanted[0, 0])


def test_the_axis_and_the_way_of_pulling_change_while_a_curve_is_pulled(
    state: ShapesState,
) -> None:
    """The pull that goes on is done again: as if it had been so from the beginning."""
    where = seen(state, "roof_rail")
    other = opened()
    keys(other, "z m")
    drag(other, where, (5.0, 25.0), drop=False)
    drag(state, where, (5.0, 25.0), drop=False)
    assert not np.allclose(state.shaping.choice.coefficients, other.shaping.choice.coefficients)
    keys(state, "z m")
    assert state.shaping.choice.coefficients == pytest.approx(
        other.shaping.choice.coefficients, abs=1e-12
    )
    keys(state, "z m")
    assert state.axis is None and not state.bending
    other.axis, other.bending = None, False
    other.move(*(other.camera.pointer or (0.0, 0.0)))
    assert state.shaping.choice.coefficients == pytest.approx(
        other.shaping.choice.coefficients, abs=1e-12
    )


def test_an_axis_that_points_at_the_viewer_pulls_nothing(state: ShapesState) -> None:
    """It says so, and the shape stays."""
    keys(state, "2 y")
    drag(state, seen(state, "shoulder"), (30.0, 30.0))
    assert "y points at you" in state.message
    assert not state.shaping.choice.coefficients.any()


def test_an_edit_without_an_answer_is_told(
    state: ShapesState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The shape stays as it was, and the reason is shown."""

    def fail(*_: object, **__: object) -> None:
        raise InvalidFeatureError("the edit found no shape: give nearer targets")

    monkeypatch.setattr(shaping, "edit", fail)
    drag(state, seen(state, "shoulder"), (30.0, 30.0))
    assert "give nearer targets" in state.message and not state.shaping.choice.coefficients.any()


def test_held_curves_stay_the_more_the_more_they_weigh(state: ShapesState) -> None:
    """A click holds a curve; the shoulder then moves less the greater the weight is."""
    ways: list[float] = []
    vertices = state.shaping.shapes.feature("shoulder").vertices
    for weight in (None, 0.3, 3.0, 30.0):
        fresh = opened()
        if weight is not None:
            at = seen(fresh, "shoulder")
            fresh.press(*at)
            fresh.move(at[0] + 1.0, at[1])
            fresh.release(*at)
            assert fresh.shaping.choice.held == {"shoulder"}
            fresh.shaping.set_hold(weight)
        before = fresh.shaping.points[vertices]
        drag(fresh, seen(fresh, "roof_rail"), (0.0, 40.0))
        ways.append(float(np.linalg.norm(fresh.shaping.points[vertices] - before)))
    assert all(after < 0.999 * first for first, after in pairwise(ways))


def test_curves_are_held_and_let_go(state: ShapesState) -> None:
    """By click, by key, all at once; each a step to take back."""
    for way in ("click", "c"):
        at = seen(state, "shoulder")
        for held in (True, False):
            state.move(*at)
            if way == "click":
                state.press(*at)
                state.release(*at)
            else:
                keys(state, way)
            assert ("shoulder" in state.shaping.choice.held) == held
    keys(state, "c a")
    assert not state.shaping.choice.held
    keys(state, "u")
    assert state.shaping.choice.held == {"shoulder"}
    keys(state, "u u")
    assert state.shaping.choice.held == {"shoulder"}
    keys(state, "U U U")
    assert not state.shaping.choice.held
    keys(state, "a")
    assert state.message == "no curve is held"
    state.move(-state.camera.room[0] / 2.0 + 2.0, 300.0)
    keys(state, "c")
    assert "put the pointer on a curve" in state.message


def test_a_held_curve_that_is_pulled_itself_follows(state: ShapesState) -> None:
    state.shaping.toggle_held("roof_rail")
    drag(state, seen(state, "roof_rail"), (0.0, 15.0))
    assert state.shaping.choice.coefficients.any() and state.shaping.choice.held == {"roof_rail"}


def test_the_stiffer_the_nearer_to_the_shape_before(state: ShapesState) -> None:
    ways: list[float] = []
    for stiffness in (STIFF[0], 0.01, 0.1, STIFF[1]):
        fresh = opened()
        fresh.shaping.set_stiffness(stiffness)
        drag(fresh, seen(fresh, "hood_edge"), (0.0, 15.0))
        ways.append(float(np.linalg.norm(fresh.shaping.sigmas)))
    assert ways == sorted(ways, reverse=True) and ways[-1] < 0.9 * ways[0]


def test_a_pull_from_beyond_the_known_shapes_draws_them_back(state: ShapesState) -> None:
    state.shaping.set_mode(0, SIGMAS)
    drag(state, seen(state, "shoulder"), (0.0, 8.0))
    assert "drawn back" in state.message
    assert (state.shaping.sigmas <= state.shaping.box[1] + 1e-9).all()
