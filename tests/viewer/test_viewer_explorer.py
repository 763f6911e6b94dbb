"""The fill explorer: its state under keys and pointer, its picture, and its window."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from viewer_disks import ALL, pattern

from patterndb.errors import NotFoundError
from patterndb.pattern import Pattern
from patterndb.patternclass import PatternClass
from query import Boundary, Stroke, fills
from query.placing import Surface, strand
from query.polyline import arc_length
from viewer import DisplayError, PictureFormatError, opengl
from viewer.contour import Contour, flat
from viewer.explore import Saver, explore
from viewer.explorer_keys import ACTIONS, EFFECTS, KEYS
from viewer.explorer_panel import PANEL
from viewer.explorer_picture import save_drawn
from viewer.explorer_scene import compose
from viewer.explorer_state import ExplorerState
from viewer.ground import Ground
from viewer.keymap import Effect
from viewer.pen import Mode
from viewer.raster import farthest_nearby, paint
from viewer.scene import HEIGHT
from viewer.solid import Hiding, Solid
from viewer.view import View
from viewer.window import Window

Points = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


class Source:
    """A few patterns in memory."""

    def __init__(self) -> None:
        self.classes: dict[int, list[Pattern]] = {}
        for i, quads in enumerate(q for name, q in ALL.items() if name != "ring"):
            p = pattern(quads, frequency=200 - i)
            self.classes.setdefault(p.n_sides, []).append(p)

    def pattern_class(self, n_sides: int) -> PatternClass:
        return PatternClass.from_patterns(n_sides, self.classes.get(n_sides, []))


SOURCE = Source()


def dome(n: int = 24, bulge: float = 0.8) -> Surface:
    """A shallow dome over the square from -2 to 2, seen from above counter-clockwise."""
    line = np.linspace(-2.0, 2.0, n + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x, y, bulge - 0.25 * bulge * (x**2 + y**2)], axis=2).reshape(-1, 3)
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    return Surface.from_arrays(points, triangles.reshape(-1, 3))


DOME = dome()


def opened(*arguments: object, **options: object) -> ExplorerState:
    return ExplorerState(SOURCE, *arguments, **options)  # type: ignore[arg-type]


@pytest.fixture
def state() -> Iterator[ExplorerState]:
    state = opened(flat((4, 3, 4, 3)))
    yield state
    state.close()


@pytest.fixture
def empty() -> Iterator[ExplorerState]:
    """A dome to draw on, seen from above, 100 points to a unit."""
    state = opened(surface=DOME)
    state.view = View(np.eye(3), np.zeros(3), 100.0)
    yield state
    state.close()


def keys(state: ExplorerState, text: str) -> None:
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW


def click(state: ExplorerState, *places: tuple[float, float]) -> None:
    for x, y in places:
        state.move(x, y)
        state.press(x, y)
        state.release(x, y)


def drag(state: ExplorerState, *places: tuple[float, float]) -> None:
    state.press(*places[0])
    for place in places[1:]:
        state.move(*place)
    state.release(*places[-1])


# The kernel and the camera


def paint_reference(corners: Points, shape: tuple[int, int]) -> np.ndarray:
    """(h, w) which triangle is seen at a pixel, -1 for none; see viewer.raster.paint."""
    seen = np.full(shape, -1)
    best = np.full(shape, -np.inf)
    for t, (a, b, c) in enumerate(corners):
        m = np.array([[a[0], b[0], c[0]], [a[1], b[1], c[1]], [1.0, 1.0, 1.0]])
        if abs(np.linalg.det(m)) < 1e-9:
            continue
        for i in range(shape[0]):
            for j in range(shape[1]):
                weights = np.linalg.solve(m, [j + 0.5, i + 0.5, 1.0])
                z = weights @ [a[2], b[2], c[2]]
                if weights.min() >= 0.0 and z > best[i, j]:
                    best[i, j], seen[i, j] = z, t
    return seen


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_the_nearest_triangle_is_seen_at_every_pixel(seed: int) -> None:
    chance = np.random.default_rng(seed)
    corners = chance.uniform(-3.0, 13.0, (6, 3, 3))
    colours = np.repeat(np.arange(1.0, 7.0), 9).reshape(6, 3, 3).astype(np.float32)
    depth = np.full((9, 11), -np.inf, np.float32)
    image = np.zeros((9, 11, 3), np.float32)
    paint(corners, colours, depth, image)
    wanted = paint_reference(corners, (9, 11))
    assert (np.round(image[..., 0]).astype(int) - 1 == wanted).all()
    assert (np.isneginf(depth) == (wanted < 0)).all()
    nearby = farthest_nearby(depth)
    for i, j in ((0, 0), (4, 5), (8, 10)):
        around = depth[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]
        assert nearby[i, j] == around.min()


@given(st.lists(st.tuples(st.floats(-300, 300), st.floats(-300, 300)), max_size=8))
def test_a_view_stays_a_view(drags: list[tuple[float, float]]) -> None:
    view = View.facing(DOME.vertices, np.array([0.3, 0.1, 1.0]), 250.0)
    for k, (x, y) in enumerate(drags):
        at = view.under(x, y)
        view = (view.turned(x, y), view.moved(x, y), view.zoomed(1.3, x, y), view.rolled())[k % 4]
        if k % 4 == 2:
            assert np.allclose(view.seen(at)[:2], (x, y))
    assert np.allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(view.axes) > 0.0
    assert np.allclose(view.seen(view.under(12.0, -7.0)), (12.0, -7.0, 0.0), atol=1e-6)


def test_what_is_clicked_is_what_is_seen_there() -> None:
    view = View.facing(DOME.vertices, np.array([0.5, -0.3, 1.0]), 250.0)
    for ground in (Ground(DOME), Ground(None)):
        for x, y in ((0.0, 0.0), (60.0, -40.0), (-80.0, 30.0)):
            at = ground.hit(view, x, y)
            assert at is not None
            assert np.allclose(view.seen(at)[:2], (x, y), atol=1e-6)
            assert np.allclose(ground.on(at[None])[0][0], at, atol=1e-9)
    assert Ground(DOME).hit(view, 5000.0, 0.0) is None


def test_paths_are_short_and_on_the_surface() -> None:
    ground = Ground(DOME)
    view = View(np.eye(3), np.zeros(3), 100.0)
    a, b = ground.hit(view, -130.0, -90.0), ground.hit(view, 120.0, 100.0)
    assert a is not None and b is not None
    path = ground.path(a, b)
    assert (path[0] == a).all() and (path[-1] == b).all()
    assert np.abs(ground.on(path)[0] - path).max() < 1e-9
    t = np.linspace(0.0, 1.0, 400)[:, None]
    straight = ground.on(a * (1 - t) + b * t)[0]
    assert arc_length(path)[-1] <= 1.005 * arc_length(straight)[-1]


# Boundaries


@pytest.mark.parametrize(
    ("lengths", "corners"),
    [((4, 3, 4, 3), None), ((5, 5), None), ((8,), ("convex",)), ((12,), ()), ((3, 4, 5), None)],
)
def test_flat_boundaries(lengths: tuple[int, ...], corners: tuple[str, ...] | None) -> None:
    boundary = flat(lengths, corners)  # type: ignore[arg-type]
    assert boundary == Boundary(lengths, corners)  # type: ignore[arg-type]
    assert boundary.points is not None
    after = np.roll(boundary.points, -1, axis=0)
    assert np.cross(boundary.points, after)[:, 2].sum() > 0.0
    contour = Contour.of(boundary)
    again = contour.boundary()
    assert again == boundary and again.points is not None
    assert (again.points == boundary.points).all()
    back = contour.reversed().reversed()
    assert back.lengths == contour.lengths and back.corners == contour.corners
    for one, other in zip(back.sides, contour.sides, strict=True):
        assert (one == other).all()


def test_reflex_corners_are_drawn_in() -> None:
    boundary = flat((2, 2, 2, 2, 2, 2), ("convex", "reflex") * 3)
    contour = Contour.of(boundary)
    normals = np.tile([0.0, 0.0, 1.0], (6, 1))
    assert Contour.drawn(contour.sides, normals).corners == boundary.corners
    assert contour.toggled(1).corners.count("reflex") == 2
    assert set(contour.reversed().corners[::2]) == {"reflex"}


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_boundary_is_drawn_by_clicks(empty: ExplorerState, clockwise: bool) -> None:
    corners = [(-120.0, -90.0), (110.0, -100.0), (120.0, 90.0), (-100.0, 100.0)]
    keys(empty, "b")
    assert empty.mode is Mode.CORNERS
    click(empty, *(corners[::-1] if clockwise else corners), (0.0, 0.0))
    keys(empty, "BackSpace")
    assert len(empty.pen.clicked) == 4 and len(empty.pen.paths) == 3
    last = corners[0] if clockwise else corners[-1]
    click(empty, last)
    assert empty.mode is Mode.LOOK and empty.boundary is not None
    boundary = empty.boundary
    assert boundary.n_sides == 4 and boundary.convex and boundary.points is not None
    found = empty.view.seen(boundary.points[list(boundary.side_starts[:-1])])[:, :2]
    wanted = {(round(x, 6), round(y, 6)) for x, y in corners}
    assert {(round(x, 6), round(y, 6)) for x, y in found.tolist()} == wanted
    after = np.roll(boundary.points, -1, axis=0)
    assert np.cross(boundary.points, after)[:, 2].sum() > 0.0
    assert np.abs(DOME.nearest(boundary.points).points - boundary.points).max() < 0.01
    empty.settle()
    placed = empty.placed
    assert placed is not None and len(placed.placement.flipped) == 0
    assert placed.placement.off_surface < 1e-9
    inside = placed.placement.region_share
    assert inside is not None and inside < 0.5


def test_a_boundary_needs_three_corners_on_the_surface(empty: ExplorerState) -> None:
    keys(empty, "s")
    assert empty.mode is Mode.LOOK and "no boundary" in empty.message
    keys(empty, "b Enter")
    assert "three corners" in empty.message
    click(empty, (900.0, 0.0))
    assert "on the surface" in empty.message and empty.pen.clicked == []
    click(empty, (0.0, 0.0), (50.0, 0.0), (50.0, 0.0))
    assert "three corners" in empty.message and len(empty.pen.clicked) == 2
    keys(empty, "Escape")
    assert empty.mode is Mode.LOOK and empty.pen.clicked == [] and empty.contour is None
    with pytest.raises(NotFoundError, match="no boundary"):
        empty.settle(0)


def test_edges_and_corners_under_the_pointer(state: ExplorerState) -> None:
    keys(state, "+")
    assert "pointer" in state.message
    assert state.contour is not None
    for side in range(4):
        start, end = state.view.seen(state.contour.sides[side][[0, -1]])[:, :2]
        state.move(*((start + end) / 2.0))
        assert state.side_under() == side
    before = state.contour.lengths
    keys(state, "+")
    assert sum(state.contour.lengths) == sum(before) + 1 and state.contour.lengths[3] == 4
    assert state.boundary is None and "odd" in state.message and state.fills == []
    keys(state, "+")
    assert state.boundary is not None and state.boundary.lengths == (4, 3, 4, 5)
    state.settle()
    assert state.fills and all(fill.lengths == (4, 3, 4, 5) for fill in state.fills)
    corner = state.view.seen(state.contour.sides[2][0])[:2]
    state.move(*corner)
    assert state.corner_under() == 2
    keys(state, "c")
    assert state.boundary.corners == ("convex", "convex", "reflex", "convex")
    keys(state, "c k")
    assert state.boundary.lengths == (5, 4, 3, 4)
    assert state.boundary.corners == ("reflex",) * 4
    keys(state, "k ] [")
    assert state.boundary.perimeter == 16


# Fills


def test_the_fills_are_the_library_s(state: ExplorerState) -> None:
    state.settle(0)
    state.settle()
    assert state.boundary is not None
    wanted = list(fills(SOURCE, state.boundary, limit=state.limit))
    assert [f.quads.tolist() for f in state.fills] == [f.quads.tolist() for f in wanted]
    assert not state.searching and len(wanted) > 3
    keys(state, "End Right")
    assert state.rank == len(wanted) - 1
    keys(state, "Left Left Next Prior Home Left")
    assert state.rank == 0
    keys(state, "r")
    state.settle()
    assert state.strict and state.fills and all(f.strict for f in state.fills)
    names = []
    for _ in range(7):
        names.append(state.order)
        keys(state, "o")
    assert names == [None, "artist", "regular", "quality", "small", "symmetric", None]
    with pytest.raises(NotFoundError, match="there is no fill 9999, only "):
        state.settle(9998)


def test_more_fills_keep_the_place() -> None:
    state = opened(flat((4, 3, 4, 3)), limit=4)
    try:
        state.settle(3)
        state.settle()
        assert state.truncated and len(state.fills) == 4
        first = [f.quads.tolist() for f in state.fills]
        keys(state, "m")
        state.settle()
        assert len(state.fills) == 8 and state.rank == 3
        assert [f.quads.tolist() for f in state.fills[:4]] == first
    finally:
        state.close()


def test_what_is_new_is_told_once(state: ExplorerState) -> None:
    state.settle(0)
    state.settle()
    state.poll()
    assert not state.poll()
    keys(state, "Right")
    state.settle()
    assert state.poll() and not state.poll()


class Slow(Source):
    """Patterns that are read only when the test lets them."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[int] = []
        self.gate = threading.Event()

    def pattern_class(self, n_sides: int) -> PatternClass:
        self.asked.append(n_sides)
        assert self.gate.wait(60.0)
        return super().pattern_class(n_sides)


def test_a_change_does_not_wait_for_the_query_that_runs() -> None:
    source = Slow()
    state = ExplorerState(source, flat((2, 2, 2, 2)))
    try:
        first = state._search
        assert first is not None and state.searching
        drawn = compose(state, 1.6)
        assert "searching …" in [t.text for t in drawn.scene.texts]
        keys(state, "] ]")
        assert state.boundary is not None and state.boundary.perimeter > 8
        assert state.searching and state._search is not first
        source.gate.set()
        state.settle(0)
        assert first.wait(timeout=60.0) and first.fills == []
        assert all(sum(f.lengths) == state.boundary.perimeter for f in state.fills)
    finally:
        source.gate.set()
        state.close()


def test_a_query_that_fails_says_why() -> None:
    class Broken(Source):
        def pattern_class(self, n_sides: int) -> PatternClass:
            raise NotFoundError("the disk is gone")

    state = ExplorerState(Broken(), flat((2, 2, 2, 2)))
    try:
        with pytest.raises(NotFoundError, match="the disk is gone"):
            state.settle(0)
        texts = " ".join(t.text for t in compose(state, 1.6).scene.texts)
        assert "the disk is gone" in texts and "No fill" in texts
    finally:
        state.close()


# Strokes


def test_strokes_snap_to_boundary_edges_and_are_had(state: ExplorerState) -> None:
    assert state.contour is not None and state.boundary is not None
    left = state.view.seen(state.contour.sides[3]).mean(axis=0)[:2]
    right = state.view.seen(state.contour.sides[1]).mean(axis=0)[:2]
    keys(state, "s")
    middle = (left + right) / 2.0 + (0.0, 25.0)
    drag(state, tuple(left + np.array([12.0, 3.0])), tuple(middle), tuple(right - (9.0, 5.0)))
    assert state.mode is Mode.LOOK and len(state.strokes) == 1
    stroke = state.strokes[0]
    assert stroke.start is not None and stroke.end is not None and stroke.points is not None
    assert (stroke.start[0], stroke.end[0]) == (3, 1)
    points = state.boundary.points
    assert points is not None
    at = state.boundary.side_starts[3] + stroke.start[1]
    assert np.allclose(stroke.points[0], (points[at] + points[(at + 1) % len(points)]) / 2.0)
    keys(state, ", ,")
    assert state.tolerance == 0
    state.settle()
    assert state.fills
    for fill in state.fills:
        ends = strand(fill, stroke.start).ends
        assert ends is not None and stroke.end in ends
    placed = state.placed
    assert placed is not None and len(placed.net.carried)
    before, after = placed.placement.strokes_before, placed.placement.strokes_after
    assert after[0, 0] <= before[0, 0]
    keys(state, "f")
    state.settle()
    assert state.placed is not None and state.placed.placement.pull == 0.0
    keys(state, "o o o")
    assert state.order == "flow"
    keys(state, "x")
    assert state.strokes == [] and state.default_order == "artist"
    state.settle()
    assert state.fills and state.fills[0].flow_distance is None


def test_loops_and_strokes_that_are_none(state: ExplorerState) -> None:
    keys(state, "l")
    turn = np.linspace(0.0, 5.5, 12)
    drag(state, *((60.0 * np.cos(t), 60.0 * np.sin(t)) for t in turn))
    assert [s.is_loop for s in state.strokes] == [True]
    keys(state, "s")
    click(state, (0.0, 0.0))
    assert "two points" in state.message and len(state.strokes) == 1
    assert state.mode is Mode.STROKE
    keys(state, "Escape ]")
    assert len(state.strokes) == 1


def test_a_stroke_is_drawn_anew_on_a_changed_boundary() -> None:
    boundary = flat((4, 3, 4, 3))
    assert boundary.points is not None
    stroke = Stroke.drawn(boundary, boundary.points[[5, 12]])
    state = opened(boundary, strokes=[stroke])
    try:
        keys(state, "] ]")
        assert state.boundary is not None and state.boundary.perimeter > 14
        (again,) = state.strokes
        again.refuse_unless_on(state.boundary)
        assert again == Stroke.drawn(state.boundary, boundary.points[[5, 12]])
    finally:
        state.close()


# Anything goes

PLACES = st.tuples(st.integers(-320, 320), st.integers(-320, 320))
EVENTS = st.one_of(
    st.sampled_from([*sorted(set(ACTIONS) - {"m"}), "Escape"]),
    st.tuples(st.sampled_from(["move", "press", "release", "turn"]), PLACES),
)


@settings(max_examples=12)
@given(st.lists(EVENTS, max_size=14))
def test_any_events_leave_a_state_that_can_be_shown(events: list[object]) -> None:
    state = opened(flat((2, 2, 2, 2)), limit=5)
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
            assert 0 <= state.rank <= max(len(state.fills) - 1, 0)
        drawn = compose(state, 1.5)
        for patch in drawn.scene.patches:
            assert np.isfinite(patch.corners).all() and len(patch.corners) == len(patch.colours)
    finally:
        state.close()


def test_keys_are_known() -> None:
    assert KEYS.check("o Right h bracketleft") == ["o", "Right", "h", "bracketleft"]
    with pytest.raises(ValueError, match="no key 'zz'"):
        KEYS.check("o zz")
    state = opened()
    try:
        assert [KEYS.press(state, k) for k in EFFECTS] == list(EFFECTS.values())
        assert KEYS.press(state, "F13") is Effect.NOTHING
        assert KEYS.press(state, "Escape") is Effect.QUIT
        keys(state, "h Escape")
        assert not state.helping
    finally:
        state.close()


# Pictures


def test_what_lies_behind_is_hidden() -> None:
    view = View(np.eye(3), np.zeros(3), 100.0)
    solid = Solid.of(view, (300.0, 300.0), DOME, None)
    hiding = Hiding(solid, 600.0, 600.0)
    top = np.array([[0.0, 0.0, 0.8], [1.0, 0.3, 0.8 - 0.2 * 1.09]])
    shift = np.array([300.0, 300.0, 0.0])
    assert hiding.visible(view.seen(top) + shift).all()
    assert not hiding.visible(view.seen(top - (0.0, 0.0, 1.0)) + shift).any()
    beside = np.array([[2.8, 0.0, -5.0]])
    assert hiding.visible(view.seen(beside) + shift).all()


def test_the_panel_says_what_is_known(state: ExplorerState) -> None:
    state.settle(1)
    state.settle()
    texts = [t.text for t in compose(state, 1.6).scene.texts]
    fill = state.fill
    assert fill is not None and fill.pattern.name in texts
    assert f"fill 2 of {len(state.fills)}" in texts and "4 3 4 3" in texts
    for length in ("4", "3"):
        assert texts.count(length) >= 2, "every side has its number"
    keys(state, "h")
    drawn = compose(state, 1.6)
    assert "roll it" in " ".join(t.text for t in drawn.scene.texts)
    right = drawn.scene.width - PANEL
    assert all(t.x < right or t.x > right + 20.0 for t in drawn.scene.texts)


def test_a_picture_is_the_same_everywhere(tmp_path: Path) -> None:
    boundary = flat((2, 2, 2, 2))
    pictures = [tmp_path / f"{k}.png" for k in range(2)]
    for picture in pictures:
        state = explore(
            SOURCE, boundary, off_screen=picture, keys="r Right", window_size=(480, 300)
        )
        assert state.strict
    assert pictures[0].read_bytes() == pictures[1].read_bytes()
    from matplotlib.image import imread

    image = np.asarray(imread(pictures[0]))
    assert image.shape[:2] == (300, 480)
    assert len(np.unique((image.reshape(-1, image.shape[2]) * 255).astype(int), axis=0)) > 50


def test_wrong_wishes_are_refused(tmp_path: Path) -> None:
    boundary = flat((2, 2, 2, 2))
    with pytest.raises(ValueError, match="no key 'zz'"):
        explore(SOURCE, boundary, off_screen=tmp_path / "a.png", keys="zz")
    with pytest.raises(PictureFormatError):
        explore(SOURCE, boundary, off_screen=tmp_path / "a.jpg")
    with pytest.raises(NotFoundError):
        explore(SOURCE, off_screen=tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_saving(state: ExplorerState, tmp_path: Path) -> None:
    written: list[tuple[Path, int]] = []
    saver = Saver(state, tmp_path, lambda p, f, v: written.append((p, len(v))), (480, 300))
    assert saver.play(["p", "w"]) is Effect.NOTHING
    fill = state.fill
    assert fill is not None and f"saved {tmp_path}" in state.message
    assert [p.name for p in tmp_path.iterdir()] == [f"fill-{fill.pattern.name}-1.png"]
    assert written == [(tmp_path / f"fill-{fill.pattern.name}-1.obj", fill.n_vertices)]
    Saver(state, tmp_path / "no", None, (480, 300)).obey("p")
    assert "not saved" in state.message
    Saver(state, tmp_path, None, (480, 300)).obey("w")
    assert "cannot be saved" in state.message
    assert saver.play(["q", "h"]) is Effect.QUIT and not state.helping


def test_the_window_obeys_events_and_shows_the_picture(tmp_path: Path) -> None:
    try:
        opengl.prepare_opengl(off_screen=True)
    except DisplayError as error:
        assert "libegl1" in str(error)
        return
    from matplotlib.image import imread
    from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

    state = opened(surface=DOME)
    state.view = View(np.eye(3), np.zeros(3), 100.0)
    size = (960, 600)
    window = Window(state, Saver(state, tmp_path, None, size), KEYS, size, "Fills", off_screen=True)
    interactor = vtkGenericRenderWindowInteractor()
    window.listen(interactor)
    room = HEIGHT * size[0] / size[1] - PANEL

    def send(event: str, at: tuple[float, float] | None = None, key: str = "") -> None:
        if at is not None:
            unit = size[1] / HEIGHT
            x, y = (at[0] + room / 2.0) * unit, (at[1] + HEIGHT / 2.0) * unit
            interactor.SetEventInformation(round(x), round(y), 0, 0, "\0", 0, "")
        elif key:
            code = key if len(key) == 1 else "\0"
            interactor.SetEventInformation(0, 0, 0, 0, code, 0, key)
        interactor.InvokeEvent(event)

    try:
        send("KeyPressEvent", key="b")
        for at in ((-110.0, -90.0), (100.0, -90.0), (110.0, 100.0), (-100.0, 90.0)):
            send("MouseMoveEvent", at)
            send("LeftButtonPressEvent", at)
            send("LeftButtonReleaseEvent", at)
        assert len(state.pen.clicked) == 4
        send("KeyPressEvent", key="Return")
        assert state.boundary is not None
        state.settle(0)
        state.settle()
        send("TimerEvent")
        axes = state.view.axes.copy()
        send("RightButtonPressEvent", (0.0, 0.0))
        send("MouseMoveEvent", (40.0, 0.0))
        send("RightButtonReleaseEvent", (40.0, 0.0))
        assert not np.allclose(state.view.axes, axes)
        scale = state.view.scale
        send("MouseWheelForwardEvent")
        assert state.view.scale > scale
        focus = state.view.focus.copy()
        send("MiddleButtonPressEvent", (0.0, 0.0))
        send("MouseMoveEvent", (20.0, 10.0))
        send("MiddleButtonReleaseEvent", (20.0, 10.0))
        send("MouseMoveEvent", (300.0, 300.0))
        moved = state.view.focus - focus
        assert np.isclose(np.linalg.norm(moved) * state.view.scale, np.hypot(20, 10), atol=2.0)
        send("KeyPressEvent", key="Right")
        assert state.rank == 1
        state.settle()
        send("TimerEvent")
        window.save(tmp_path / "window.png")
        save_drawn(tmp_path / "drawn.png", compose(state, size[0] / size[1]), size[1])
    finally:
        window.close()
        state.close()
    shown, drawn = (
        np.asarray(imread(tmp_path / f"{name}.png"))[..., :3] for name in ("window", "drawn")
    )
    # Text and edges are smoothed differently; everything else is the same picture.
    assert shown.shape == drawn.shape
    assert np.abs(shown - drawn).mean() < 0.02
