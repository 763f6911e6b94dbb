"""The viewer of shape models: its state under keys and pointer."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree
from shape_cases import car_shapes, car_template

from sketch.features.errors import InvalidFeatureError
from sketch.features.model import Model
from sketch.features.registration import box_template
from sketch.features.shapemodel import edit, moved
from viewer.keymap import Effect
from viewer.shapes import ShapesState, shaping
from viewer.shapes.choice import HOLD, KEEP, SIGMAS, STIFF
from viewer.shapes.keys import ACTIONS, EFFECTS, KEY_HELP, KEYS, NUDGE
from viewer.shapes.layout import MODES
from viewer.shapes.picture import compose
from viewer.shapes.pull import displaced
from viewer.shapes.sight import finer
from viewer.shapes.skin import nearest_on
from viewer.view import View

MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture
def state() -> ShapesState:
    return opened()


def opened(count: int = 6) -> ShapesState:
    state = ShapesState(car_shapes(count), car_template())
    compose(state, 1.6)
    return state


def keys(state: ShapesState, text: str) -> None:
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW


def number(state: ShapesState, name: str, *, mirrored: bool = False) -> int:
    lines = enumerate(state.skin.lines)
    return next(i for i, one in lines if one.name == name and one.mirrored == mirrored)


def seen(state: ShapesState, name: str, *, mirrored: bool = False) -> tuple[float, float]:
    """Where the middle vertex of a curve is seen."""
    line = state.sight.lines[number(state, name, mirrored=mirrored)]
    x, y = line[len(line) // 2, :2].tolist()
    return x, y


def drag(
    state: ShapesState, start: tuple[float, float], by: tuple[float, float], *, drop: bool = True
) -> None:
    """Press, move in three steps, and release."""
    state.move(*start)
    state.press(*start)
    for share in (0.6, 0.8):
        state.move(start[0] + share * by[0], start[1] + share * by[1])
    assert state.move(start[0] + by[0], start[1] + by[1])
    if drop:
        assert state.release(start[0] + by[0], start[1] + by[1])


def knob_at(state: ShapesState, name: int | str, value: float) -> tuple[float, float]:
    """Where a slider's knob is at a value, in points from the middle of the view."""
    rail = state.rails[name]
    return rail.knob(value) - state.room[0] / 2.0, rail.y - state.room[1] / 2.0


# Pulls


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.floats(-300, 300), st.floats(-300, 300))
def test_a_pull_goes_where_the_pointer_goes(seed: int, dx: float, dy: float) -> None:
    """On the screen exactly; along an axis to the place of the seen axis nearest to the pointer,
    and never beside the axis."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    view = View(axes, rng.normal(size=3), float(rng.uniform(10.0, 300.0)))
    flat = displaced(view, dx, dy, None)
    assert flat is not None
    assert (flat @ axes.T) * view.scale == pytest.approx([dx, dy, 0.0], abs=1e-8)
    for axis in range(3):
        along = displaced(view, dx, dy, axis)
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
    state.set_mode(1, 0.7)
    if mirrored:
        # Its own half hides the other.
        state.aim(View(state.view.axes @ np.diag(MIRROR), state.view.focus, state.view.scale))
    if bending:
        keys(state, "m")
    start = state.choice.coefficients
    where = seen(state, "roof_rail", mirrored=mirrored)
    drag(state, where, (13.0, 21.0))
    offset = displaced(state.view, 13.0, 21.0, None)
    assert offset is not None
    shapes = state.shapes
    place = len(shapes.feature("roof_rail").vertices) // 2 if bending else None
    pull = offset * MIRROR if mirrored else offset
    targets = moved(shapes, "roof_rail", pull, start=start, vertex=place)
    wanted = edit(shapes, targets, start=start, stiffness=KEEP)
    assert state.choice.coefficients == pytest.approx(wanted.coefficients, abs=1e-12)
    assert state.points == pytest.approx(wanted.points)
    assert state.choice.origin == "edited"
    keys(state, "u")
    assert np.array_equal(state.choice.coefficients, start)


def test_a_pull_shows_where_the_curve_should_be_and_how_far_it_is_short(
    state: ShapesState,
) -> None:
    """Of a pull that no shape of the box fulfils: the note's number is the greatest distance of
    the curve from its target, and coefficients at their limits are marked."""
    where = seen(state, "roof_rail")
    keys(state, "z")
    drag(state, where, (0.0, 240.0), drop=False)
    pulled = state.pulled
    assert pulled is not None
    line = state.skin.lines[number(state, "roof_rail")]
    away = np.linalg.norm(state.points[line.vertices] - pulled.wanted, axis=1).max()
    assert away == pytest.approx(pulled.miss) and away > 0.05
    found = re.search(r"short of the pull by up to (\S+) units; (\d+) mode", state.message)
    assert found is not None and float(found[1]) == pytest.approx(away, rel=0.01)
    low, high = state.box
    at = (state.sigmas <= low + 1e-9) | (state.sigmas >= high - 1e-9)
    assert at.any() and int(found[2]) == at.sum()
    assert np.array_equal(state.limits != 0, at)
    assert (state.sigmas >= low - 1e-9).all() and (state.sigmas <= high + 1e-9).all()
    state.release(*state.pointer or (0.0, 0.0))
    assert state.pulled is None and not state.dragging


def test_a_small_pull_is_followed(state: ShapesState) -> None:
    """A shape that lies between the known ones is reached: pulled towards it, the curve is
    where the pointer is, and nothing is said."""
    keys(state, "x")
    where = seen(state, "front_corner")
    line = state.skin.lines[number(state, "front_corner")]
    before = state.points[line.vertices].copy()
    drag(state, where, (10.0, 0.0), drop=False)
    assert state.pulled is not None
    wanted = state.pulled.wanted - before
    assert wanted[:, 1:] == pytest.approx(0.0) and np.ptp(wanted[:, 0]) == pytest.approx(0.0)
    assert state.pulled.miss < 0.2 * np.abs(wanted[0, 0])


def test_the_axis_and_the_way_of_pulling_change_while_a_curve_is_pulled(
    state: ShapesState,
) -> None:
    """The pull that goes on is done again: as if it had been so from the beginning."""
    where = seen(state, "roof_rail")
    other = opened()
    keys(other, "z m")
    drag(other, where, (5.0, 25.0), drop=False)
    drag(state, where, (5.0, 25.0), drop=False)
    assert not np.allclose(state.choice.coefficients, other.choice.coefficients)
    keys(state, "z m")
    assert state.choice.coefficients == pytest.approx(other.choice.coefficients, abs=1e-12)
    keys(state, "z m")
    assert state.axis is None and not state.bending
    other.axis, other.bending = None, False
    other.move(*(other.pointer or (0.0, 0.0)))
    assert state.choice.coefficients == pytest.approx(other.choice.coefficients, abs=1e-12)


def test_an_axis_that_points_at_the_viewer_pulls_nothing(state: ShapesState) -> None:
    """It says so, and the shape stays."""
    keys(state, "2 y")
    drag(state, seen(state, "shoulder"), (30.0, 30.0))
    assert "y points at you" in state.message
    assert not state.choice.coefficients.any()


def test_an_edit_without_an_answer_is_told(
    state: ShapesState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The shape stays as it was, and the reason is shown."""

    def fail(*_: object, **__: object) -> None:
        raise InvalidFeatureError("the edit found no shape: give nearer targets")

    monkeypatch.setattr(shaping, "edit", fail)
    drag(state, seen(state, "shoulder"), (30.0, 30.0))
    assert "give nearer targets" in state.message and not state.choice.coefficients.any()


# Holding


def test_held_curves_stay_the_more_the_more_they_weigh(state: ShapesState) -> None:
    """A click holds a curve; the shoulder then moves less the greater the weight is."""
    ways: list[float] = []
    vertices = state.shapes.feature("shoulder").vertices
    for weight in (None, 0.3, 3.0, 30.0):
        fresh = opened()
        if weight is not None:
            at = seen(fresh, "shoulder")
            fresh.press(*at)
            fresh.move(at[0] + 1.0, at[1])
            fresh.release(*at)
            assert fresh.choice.held == {"shoulder"}
            fresh.set_hold(weight)
        before = fresh.points[vertices]
        drag(fresh, seen(fresh, "roof_rail"), (0.0, 40.0))
        ways.append(float(np.linalg.norm(fresh.points[vertices] - before)))
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
            assert ("shoulder" in state.choice.held) == held
    keys(state, "c a")
    assert not state.choice.held
    keys(state, "u")
    assert state.choice.held == {"shoulder"}
    keys(state, "u u")
    assert state.choice.held == {"shoulder"}
    keys(state, "U U U")
    assert not state.choice.held
    keys(state, "a")
    assert state.message == "no curve is held"
    state.move(-state.room[0] / 2.0 + 2.0, 300.0)
    keys(state, "c")
    assert "put the pointer on a curve" in state.message


def test_a_held_curve_that_is_pulled_itself_follows(state: ShapesState) -> None:
    state.toggle_held("roof_rail")
    drag(state, seen(state, "roof_rail"), (0.0, 15.0))
    assert state.choice.coefficients.any() and state.choice.held == {"roof_rail"}


def test_the_stiffer_the_nearer_to_the_shape_before(state: ShapesState) -> None:
    ways: list[float] = []
    for stiffness in (STIFF[0], 0.01, 0.1, STIFF[1]):
        fresh = opened()
        fresh.set_stiffness(stiffness)
        drag(fresh, seen(fresh, "hood_edge"), (0.0, 15.0))
        ways.append(float(np.linalg.norm(fresh.sigmas)))
    assert ways == sorted(ways, reverse=True) and ways[-1] < 0.9 * ways[0]


@pytest.mark.parametrize("name", ["roof_rail", "hood_edge", "sill", "shoulder", "c_pillar"])
def test_the_first_stiffness_costs_a_pull_little(name: str) -> None:
    """Short pulls of a training shape miss by no more than a tenth of their length more than
    with the stiffness that edits have by default, and modes change no more."""
    shapes = car_shapes()
    start = shapes.coefficients[2]
    for pull in 0.05 * np.r_[np.eye(3), -np.eye(3)]:
        targets = moved(shapes, name, pull, start=start)
        first, plain = (
            edit(shapes, targets, start=start, stiffness=KEEP),
            edit(shapes, targets, start=start),
        )
        assert first.misses[name] <= plain.misses[name] + 0.005
        swings = [
            np.linalg.norm((e.coefficients - start) / shapes.deviations) for e in (first, plain)
        ]
        assert swings[0] <= swings[1] + 1e-9


# What the pointer is on


def test_curves_in_sight_are_what_rays_meet_first(state: ShapesState) -> None:
    """Against rays through the triangles: a curve's vertex is in sight if nothing is in front
    of it, and not if something is, there and around. Beside the rim of what hides it, it may be
    either."""
    model = Model.from_arrays(state.points, state.skin.vertices)
    around = 7.0 * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1]])
    for turn in ((0.0, 0.0), (250.0, 40.0), (-120.0, 180.0)):
        state.aim(state.view.turned(*turn))
        places = np.concatenate(state.sight.lines)
        points = np.concatenate([state.points[one.vertices] for one in state.skin.lines])
        axes, far = state.view.axes, 2.0 * state.size
        ahead = []
        for shift in around:
            starts = points + far * axes[2] + shift @ axes[:2] / state.view.scale
            hits = model.first_hits(starts, np.tile(-axes[2], (len(points), 1)))
            # A ray beside the shape meets nothing: then nothing is in front.
            ahead.append(np.where(hits.found, far - hits.lengths, 0.0) * state.view.scale)
        shown = state.sight.visible(places)
        clear, hidden = ahead[0] < 0.5, np.min(ahead, axis=0) > 25.0
        assert clear.sum() > 20 and hidden.sum() > 20
        # Between two of the rays there may be a seam that one sees through.
        assert shown[clear].all() and shown[hidden].mean() < 0.04


def test_the_nearest_curve_in_sight_is_grabbed(state: ShapesState) -> None:
    assert state.line_under() is None
    where = seen(state, "roof_rail")
    state.move(*where)
    line = state.under()
    assert line is not None and (line.title, line.mirrored) == ("roof rail", False)
    keys(state, "w")
    assert state.under() is None
    keys(state, "w 2")
    # From the side the image lies behind.
    state.move(*seen(state, "shoulder", mirrored=True))
    line = state.under()
    assert line is not None and not line.mirrored
    state.move(state.room[0] / 2.0 + 40.0, 0.0)
    assert state.under() is None


def test_a_ghost_is_drawn_where_it_is_in_sight(state: ShapesState) -> None:
    """The lines of its drawing are in sight all along, whatever hides the shape itself; what is
    left out of a curve is not, or is a glimpse."""
    keys(state, "n n g")
    sight = state.ghost_sight
    assert sight is not None and state.ghost_sight is sight
    drawn = np.concatenate([finer(line, 2.0)[0] for line in sight.drawing])
    assert sight.visible(drawn).mean() > 0.97
    near = KDTree(drawn[:, :2])
    for line in sight.lines:
        fine, own = finer(line, 2.0)
        assert np.array_equal(fine[own], line)
        assert np.linalg.norm(np.diff(fine[:, :2], axis=0), axis=1).max() < 2.0 + 1e-9
        shown = sight.visible(fine)
        if shown.all() and np.linalg.norm(fine[0, :2] - fine[-1, :2]) > 20.0:
            assert near.query(fine[:, :2])[0].max() < 1e-6
    keys(state, "2")
    assert state.ghost_sight is not sight


@settings(max_examples=40)
@given(st.integers(0, 10**6))
def test_the_nearest_point_of_a_polyline(seed: int) -> None:
    """Against many points along it."""
    rng = np.random.default_rng(seed)
    lines = [rng.normal(size=(int(rng.integers(1, 6)), 3)) for _ in range(3)]
    place = rng.normal(size=2)
    away, piece, share = nearest_on(lines, place)
    for i, line in enumerate(lines):
        ends = line if len(line) > 1 else line[[0, 0]]
        t = np.linspace(0.0, 1.0, 400)[:, None]
        dense = np.concatenate([a + t * (b - a) for a, b in pairwise(ends)])
        least = np.linalg.norm(dense[:, :2] - place, axis=1).min()
        assert away[i] <= least + 1e-12 and away[i] > least - 0.02
        a, b = ends[piece[i]], ends[piece[i] + 1]
        at = a + share[i] * (b - a)
        assert np.linalg.norm(at[:2] - place) == pytest.approx(away[i])


# Sliders


@pytest.mark.parametrize("sigmas", [-3.0, -1.25, 0.4, 3.0])
def test_dragging_a_knob_sets_its_mode_alone(state: ShapesState, sigmas: float) -> None:
    """The shape is the mean and so many deviations of the mode; the drag is one step."""
    start = knob_at(state, 2, 0.0)
    end = knob_at(state, 2, sigmas)
    drag(state, start, (end[0] - start[0], 4.0))
    wanted = np.zeros(state.shapes.n_modes)
    wanted[2] = sigmas * state.shapes.deviations[2]
    assert state.choice.coefficients == pytest.approx(wanted)
    assert state.points == pytest.approx(state.shapes.shape(wanted))
    assert state.chosen == 2
    low, high = state.box
    beyond = sigmas > high[2] or sigmas < low[2]
    assert abs(state.limits[2]) == (2 if beyond else 0)
    assert ("beyond the training shapes" in state.message) == beyond
    keys(state, "u")
    assert not state.choice.coefficients.any()
    keys(state, "U")
    assert state.sigmas[2] == pytest.approx(sigmas)


def test_a_pull_from_beyond_the_known_shapes_draws_them_back(state: ShapesState) -> None:
    state.set_mode(0, SIGMAS)
    drag(state, seen(state, "shoulder"), (0.0, 8.0))
    assert "drawn back" in state.message
    assert (state.sigmas <= state.box[1] + 1e-9).all()


def test_the_numbers_of_pulls_have_sliders(state: ShapesState) -> None:
    for name, ends in (("hold", HOLD), ("stiffness", STIFF)):
        start = knob_at(state, name, state.value[name])
        for value in ends:
            end = knob_at(state, name, value)
            drag(state, start, (end[0] - start[0], 0.0))
            assert state.value[name] == pytest.approx(value)
            keys(state, "u")
    assert (state.choice.hold, state.choice.stiffness) == (1.0, KEEP)


def test_pages_of_modes() -> None:
    """Every mode has its slider on one page; keys turn pages and choose modes on them."""
    state = opened(16)
    n = state.shapes.n_modes
    assert n == 15
    shown = []
    for _ in range(2):
        shown += [name for name in state.rails if isinstance(name, int)]
        keys(state, ".")
    assert shown == list(range(n)) and state.page == 0
    keys(state, ",")
    assert state.page == 1 and state.chosen == MODES
    keys(state, "Up")
    assert (state.chosen, state.page) == (MODES - 1, 0)
    keys(state, "Up " * MODES)
    assert (state.chosen, state.page) == (n - 1, 1)
    few = opened()
    keys(few, ".")
    assert few.page == 0 and "all modes" in few.message


# Keys


def test_the_help_lists_the_keys_there_are() -> None:
    signs = {"↑": "Up", "↓": "Down", "←": "Left", "→": "Right", "Esc": "Escape"}
    listed = {signs.get(k, k) for names, _ in KEY_HELP for k in names.split()}
    listed -= {"drag", "click"}
    known = set(ACTIONS) | set(EFFECTS) | {"Escape", "?"}
    assert listed == known
    assert KEYS.check("Home KP_0 Prior Next BackSpace space comma N") is not None
    with pytest.raises(ValueError, match="no key"):
        KEYS.check("ö")


def test_training_shapes_are_stepped_through(state: ShapesState) -> None:
    """n goes through all of them and round, b back; each as it was registered."""
    shapes = state.shapes
    for turn in range(len(shapes.names) + 1):
        keys(state, "n")
        k = turn % len(shapes.names)
        assert state.choice.origin == shapes.names[k]
        assert state.points == pytest.approx(shapes.shape(shapes.coefficients[k]), abs=1e-12)
        assert state.nearest == (shapes.names[k], pytest.approx(0.0, abs=1e-12))
    keys(state, "b b")
    assert state.choice.origin == shapes.names[-2]
    fresh = opened()
    keys(fresh, "b")
    assert fresh.choice.origin == shapes.names[-1]


def test_random_shapes_and_the_mean(state: ShapesState) -> None:
    keys(state, "r")
    first = state.choice.coefficients
    keys(state, "r")
    assert not np.allclose(first, state.choice.coefficients)
    low, high = state.shapes.box
    assert (state.choice.coefficients >= low).all() and (state.choice.coefficients <= high).all()
    again = opened()
    keys(again, "r")
    assert np.array_equal(again.choice.coefficients, first)
    keys(state, "0")
    assert state.points == pytest.approx(state.shapes.mean) and state.choice.origin == "mean"


def test_arrow_keys_change_the_chosen_mode(state: ShapesState) -> None:
    keys(state, "Down Right Right Right Left")
    assert state.chosen == 1
    assert state.sigmas[1] == pytest.approx(2 * NUDGE)
    keys(state, "u")
    assert state.sigmas[1] == pytest.approx(3 * NUDGE)


def test_ghosts(state: ShapesState) -> None:
    assert state.ghost_coefficients() is None
    keys(state, "n n g")
    assert state.ghost_name == "mean" and not np.any(state.ghost_coefficients())
    keys(state, "g")
    assert state.ghost_name == state.shapes.names[1]
    assert state.ghost_coefficients() == pytest.approx(state.shapes.coefficients[1])
    keys(state, "g")
    assert state.ghost_coefficients() is None
    fresh = opened()
    keys(fresh, "g g")
    assert fresh.ghost_name == fresh.nearest[0]


def test_views_and_switches(state: ShapesState) -> None:
    first, scale = state.view.axes.copy(), state.view.scale
    for key, axis, sign in (("1", 0, -1.0), ("2", 1, -1.0), ("3", 2, 1.0)):
        keys(state, key)
        assert state.view.axes[2] == pytest.approx(sign * np.eye(3)[axis], abs=1e-12)
        assert state.view.scale <= scale
        # All of it is in the picture.
        assert (np.abs(state.sight.seen[:, :2]).max(axis=0) < np.array(state.room) / 2.0).all()
    keys(state, "v")
    assert np.array_equal(state.view.axes, first)
    for key, name in (("e", "edges_shown"), ("w", "curves_shown"), ("h", "helping")):
        before = getattr(state, name)
        keys(state, key)
        assert getattr(state, name) is not before
    assert KEYS.press(state, "Escape") is Effect.REDRAW and not state.helping
    assert KEYS.press(state, "Escape") is Effect.QUIT


def test_the_view_turns_shifts_and_zooms(state: ShapesState) -> None:
    nowhere = (0.0, state.room[1] / 2.0 - 8.0)
    first = state.view
    assert not state.press(*nowhere)
    assert state.move(40.0, nowhere[1] - 30.0)
    assert not state.release(40.0, nowhere[1] - 30.0)
    assert state.view.axes == pytest.approx(first.turned(40.0, -30.0).axes)
    assert not state.choice.coefficients.any()
    # The other button turns even on a curve.
    at = seen(state, "shoulder")
    state.press(*at, turn=True)
    state.move(at[0] + 20.0, at[1])
    state.release(at[0] + 20.0, at[1])
    assert not state.choice.coefficients.any() and not state.choice.held
    assert state.wheel(2.0) and state.view.scale > first.scale
    focus = state.view.focus
    assert state.drag_view(10.0, 5.0) and not np.allclose(state.view.focus, focus)
    assert not state.poll()


def test_escape_drops_what_is_dragged(state: ShapesState) -> None:
    keys(state, "n")
    before = state.choice
    drag(state, seen(state, "roof_rail"), (0.0, 30.0), drop=False)
    for key in ["n", "r", "0", "u", "U", "c", "a", "1", "v", ",", "Right", "Up"]:
        keys(state, key)
        assert "let go first" in state.message
    assert not state.wheel(1.0) and not state.drag_view(1.0, 1.0)
    keys(state, "Escape")
    assert state.choice is before and not state.dragging and state.pulled is None
    assert state.points == pytest.approx(state.shapes.shape(before.coefficients))
    assert not state.release(0.0, 0.0)
    keys(state, "u")
    assert state.choice.origin == "mean"


STEPS = ["n", "b", "r", "Right", "Left", "0", "Down", "pull", "slide", "hold", "weigh"]


@settings(max_examples=25)
@given(st.lists(st.sampled_from(STEPS), min_size=1, max_size=12))
def test_everything_can_be_taken_back_and_done_again(steps: list[str]) -> None:
    """After any steps: taking back all gives the beginning, doing again all gives the end."""
    state = opened()
    first = state.choice
    for step in steps:
        if step == "pull":
            drag(state, seen(state, "shoulder"), (7.0, 12.0))
        elif step == "slide":
            drag(state, knob_at(state, 1, state.value[1]), (17.0, 0.0))
        elif step == "hold":
            state.toggle_held("roof_rail")
        elif step == "weigh":
            drag(state, knob_at(state, "hold", state.value["hold"]), (-9.0, 0.0))
        else:
            keys(state, step)
    last, points = state.choice, state.points.copy()
    count = 0
    while state.choice is not first:
        keys(state, "u")
        count += 1
        assert count <= len(steps)
    assert state.points == pytest.approx(state.shapes.mean)
    for _ in range(count):
        keys(state, "U")
    assert state.choice.is_like(last) and state.points == pytest.approx(points)
    keys(state, "U")
    assert state.message == "nothing was taken back"


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(InvalidFeatureError, match="give the one that its shapes were laid with"):
        ShapesState(car_shapes(), box_template(6))
    with pytest.raises(InvalidFeatureError, match="must be 5 finite numbers"):
        ShapesState(car_shapes(), car_template(), [1.0, 2.0])
    state = ShapesState(car_shapes(), car_template(), car_shapes().coefficients[3])
    assert state.choice.origin == "car 3"
