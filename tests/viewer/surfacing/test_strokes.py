"""Strokes drawn in the viewer of surfaces, and what any events leave."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.edits import cut_cycle
from query.placing import Surface
from tests.support.viewer.domes import Finder, at, click, dome, drag, growing_dome, keys, opened
from tests.support.viewer.layers import are_finite, count_marks
from viewer.keymap import Effect
from viewer.pointer import STROKE_END_REACH
from viewer.surfacing.commands import KEYS
from viewer.surfacing.picture import SNAP, compose_surface
from viewer.surfacing.state import SurfacingState


def test_a_stroke_lies_on_the_mesh(state: SurfacingState) -> None:
    keys(state, "d")
    drag(state, at(state, 0.1, 0.1, 0.9), at(state, 0.5, 0.4, 0.7), at(state, -0.4, 0.6, 0.7))
    (ink,) = state.surfaces.edits.inks
    assert len(ink.parts) == 1 and ink.missed == 0 and len(ink.parts[0]) > 20
    made = state.surfaces.made
    assert made is not None and made.surfacing is not None
    mesh = Surface.from_arrays(made.surfacing.points, made.surfacing.triangles)
    feet = mesh.nearest(ink.parts[0]).points
    assert np.abs(feet - ink.parts[0]).max() < 1e-6
    assert {int(patch) for patch in ink.owners[0]} == {0, 1}
    seen = state.camera.view.seen(ink.parts[0])[:, :2]
    assert np.hypot(*np.diff(seen, axis=0).T).max() <= 3.0 + 1e-6


def test_a_stroke_that_leaves_the_surface_is_split_and_says_so(state: SurfacingState) -> None:
    click(state, 0.4, 0.4, 0.8)
    keys(state, "d")
    assert state.drawing_mode
    drag(state, at(state, 0.5, -0.3, 0.0), at(state, 0.5, 0.5, 0.0), at(state, -0.4, 0.5, 0.0))
    (ink,) = state.surfaces.edits.inks
    assert len(ink.parts) == 2 and ink.missed > 0
    assert sum(map(len, ink.parts)) + ink.missed == ink.rays
    assert f"{ink.missed} of {ink.rays}" in state.message and "2 parts" in state.message
    drag(state, (-400.0, -400.0), (-390.0, -400.0))
    assert "beside" in state.message and len(state.surfaces.edits.inks) == 1
    keys(state, "u")
    assert state.surfaces.edits.inks == () and len(state.surfaces.patches) == 3
    keys(state, "Escape")
    assert not state.drawing_mode


def _across(state: SurfacingState) -> None:
    """A stroke across quarters 0 and 1, from the rim to the rim."""
    keys(state, "d")
    a, b = np.radians(45.0), np.radians(135.0)
    start = at(state, 0.995 * np.cos(a), 0.995 * np.sin(a), 0.0)
    end = at(state, 0.995 * np.cos(b), 0.995 * np.sin(b), 0.0)
    drag(state, start, at(state, 0.0, 0.5, 0.0), end)


def test_a_stroke_becomes_curves_and_cuts_the_cycles_that_came_along(
    state: SurfacingState,
) -> None:
    _across(state)
    keys(state, "Enter")
    assert state.message == "" and state.surfaces.edits.inks == ()
    network = state.surfaces.network
    # The rim's quarters and the meridian between are cut in two, the stroke is two curves.
    assert len(network.curves) == 8 + 3 + 2
    assert [curve.stroke for curve in network.curves].count("drawn 1") == 2
    assert {curve.id for curve in network.curves} >= {curve.id for curve in dome().curves}
    assert len(state.surfaces.patches) == 6
    for cycle in state.surfaces.edits.given or ():
        network.walk(cycle)
    uses = np.zeros(len(network.curves), int)
    for cycle in state.surfaces.edits.given or ():
        uses[list(cycle.curves)] += 1
    rim = [i for i, c in enumerate(network.curves) if c.id in ("0-1", "1-2", "2-3", "3-0")]
    assert all(uses[i] == (1 if i in rim else 2) for i in range(len(uses)))
    keys(state, "u")
    assert len(state.surfaces.network.curves) == 8 and len(state.surfaces.patches) == 4
    assert len(state.surfaces.edits.inks) == 1


def test_where_ends_will_be_moved_to_is_shown(state: SurfacingState) -> None:
    """While a stroke is drawn, and until it is a curve, which ends there."""
    keys(state, "d")
    assert state.find_snaps() == []
    start, end = at(state, 0.7, 0.7, 0.0), at(state, -0.7, 0.7, 0.0)
    state.press(*start)
    state.move(0.0, 0.5 * start[1])
    begun = state.find_snaps()[0]
    assert at(state, *begun) == pytest.approx(start, abs=STROKE_END_REACH), "where it began"
    state.move(*end)
    state.release(*end)
    shown = state.find_snaps()
    assert len(shown) == 2 and (shown[0] == begun).all()
    assert count_marks(compose_surface(state, 1040.0, 860.0), SNAP) == 2
    keys(state, "Enter")
    network, ends = state.surfaces.network, []
    for curve in network.curves:
        if curve.stroke == "drawn 1":
            ends += [network.nodes[node] for node in curve.nodes]
    for place in shown:
        assert min(np.linalg.norm(node - place) for node in ends) < 1e-9
    assert state.find_snaps() == []


def test_a_stroke_that_ends_on_no_curve_stays_a_stroke(state: SurfacingState) -> None:
    keys(state, "Enter")
    assert "draw a stroke" in state.message
    keys(state, "d")
    drag(state, at(state, 0.3, 0.3, 0.0), at(state, 0.5, 0.4, 0.0))
    keys(state, "Enter")
    assert "begin and end it on curves" in state.message
    assert len(state.surfaces.edits.inks) == 1 and len(state.surfaces.network.curves) == 8
    keys(state, "+ + + + + + + + + + + + Enter")
    assert "has changed" in state.message


def test_a_new_curve_is_a_stage_of_its_own(growing: SurfacingState) -> None:
    _across(growing)
    keys(growing, "Enter")
    assert growing.surfaces.n_stages == 4 and growing.surfaces.edits.stage == 4
    assert len(growing.surfaces.network.curves) == 13
    keys(growing, "Left")
    assert len(growing.surfaces.network.curves) == 11, "the new curves have cut those of before"


def test_parts_of_a_cycle() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    network = CurveNetwork.from_edges(square, [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]])
    around = Cycle(((0, False), (1, False), (2, False), (3, False)))
    for cycle in (around, around.turned):
        one, other = cut_cycle(network, cycle, [4])
        assert {one.key, other.key} == {
            Cycle(((0, False), (1, False), (4, True))).key,
            Cycle(((4, False), (2, False), (3, False))).key,
        }
    assert cut_cycle(network, around, [0]) != []


PLACES = st.tuples(st.integers(-600, 800), st.integers(-430, 430))


EVENTS = st.one_of(
    st.sampled_from([*sorted(KEYS.actions), "Escape"]),
    st.tuples(st.sampled_from(["move", "press", "release", "turn"]), PLACES),
)


@settings(max_examples=15, deadline=None)
@given(st.lists(EVENTS, max_size=14))
def test_any_events_leave_a_state_that_can_be_shown(events: list[object]) -> None:
    state = opened(growing_dome(), find=Finder())
    try:
        for event in events:
            if isinstance(event, str):
                KEYS.press(state, event)
            else:
                what, place = event  # type: ignore[misc]
                if what == "turn":
                    state.press(*place, turn=True)
                else:
                    getattr(state, what)(*place)
            state.poll()
        state.settle()
        assert are_finite(compose_surface(state, 1040.0, 860.0))
    finally:
        state.close()


def test_keys_are_known() -> None:
    assert KEYS.check("m Right minus") == ["m", "Right", "minus"]
    with pytest.raises(ValueError, match="no key 'zz'"):
        KEYS.check("m zz")
    state = opened()
    try:
        effects = KEYS.effects
        assert [KEYS.press(state, k) for k in effects] == list(effects.values())
        assert KEYS.press(state, "F13") is Effect.NOTHING
        keys(state, "d Escape")
        assert not state.drawing_mode
    finally:
        state.close()
