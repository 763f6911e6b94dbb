"""The fills that the fill explorer finds, and its strokes."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.patternclass import PatternClass
from patterndb.errors import NotFoundError
from patterndb_sketch.fillfinder import VARIANTS
from query import Stroke, fills
from query.contour import make_flat_boundary
from query.listing.orders import ORDERS
from query.placing import find_strand
from query.recognition import hash_fill
from tests.support.viewer.domed import SOURCE, Source, click, drag, keys, opened, said
from tests.support.viewer.layers import are_finite
from viewer.explorer_commands import KEYS
from viewer.explorer_picture import compose_explorer
from viewer.explorer_state import ExplorerState
from viewer.pointerstroke import PointerMode


def test_the_fills_are_the_library_s(state: ExplorerState) -> None:
    state.settle(0)
    state.settle()
    assert state.finder.boundary is not None
    limit = state.finder.limit
    wanted = list(fills(SOURCE, state.finder.boundary, limit=limit, per_pattern=1))
    assert [f.quads.tolist() for f in state.finder.fills] == [f.quads.tolist() for f in wanted]
    assert not state.finder.searching and len(wanted) > 3
    keys(state, "End Right")
    assert state.finder.rank == len(wanted) - 1
    keys(state, "Left Left Next Prior Ctrl+Home Left")
    assert state.finder.rank == 0
    keys(state, "r")
    state.settle()
    assert state.finder.strict and state.finder.fills and all(f.strict for f in state.finder.fills)
    usable = [name for name, order in ORDERS.items() if order.is_usable(points=True, strokes=False)]
    names = []
    for _ in range(len(usable) + 2):
        names.append(state.finder.order)
        keys(state, "o")
    assert names == [None, *usable, None]
    with pytest.raises(NotFoundError, match="there is no fill 9999, only "):
        state.settle(9998)


def test_variants_are_opened_under_a_fill(state: ExplorerState) -> None:
    """Down and up go through them; the flat list has the same fills, each in its place."""
    # An order that measures fills looks at some of each pattern only.
    state.finder.order = "artist"
    state.finder.restart()
    state.settle(0)
    state.settle()
    assert state.finder.boundary is not None
    flat = list(fills(SOURCE, state.finder.boundary, limit=None, order="artist"))
    # One of these patterns is not reduced, and has one fill several times.
    of_pattern: dict[int, list[bytes]] = {}
    for fill in flat:
        found = of_pattern.setdefault(fill.pattern.id, [])
        found += [key for key in (hash_fill(fill, False),) if key not in found]
    assert [fill.pattern.id for fill in state.finder.fills] == list(of_pattern)
    assert len(of_pattern) < len(flat)
    for rank, wanted in enumerate(of_pattern.values()):
        seen: list[bytes] = []
        state.settle(rank)
        count = len(state.finder.variants)
        texts = said(state)
        more = " or more" if len(wanted) - 1 > VARIANTS else ""
        assert any(f"+{count}{more} variant" in text for text in texts) == (count > 0)
        for variant in range(count + 1):
            assert state.finder.variant == variant
            fill = state.finder.fill
            assert fill is not None and fill.pattern == state.finder.fills[rank].pattern
            seen.append(hash_fill(fill, False))
            keys(state, "Down")
        assert state.finder.variant == count
        assert seen == wanted[: VARIANTS + 1]
        if count:
            state.settle()
            assert state.finder.placed is not None
            assert state.finder.placed.fill is state.finder.variants[-1]
            texts = said(state)
            assert any(f"variant {count} of {count}{more}" in text for text in texts)
            keys(state, "Up " * count)
            assert state.finder.fill is state.finder.fills[rank]
        else:
            assert "no other fill" in state.message
    keys(state, "a")
    state.settle()
    assert [f.quads.tolist() for f in state.finder.fills] == [
        f.quads.tolist() for f in flat[: state.finder.limit]
    ]
    assert state.finder.variants == []
    keys(state, "Down")
    assert state.finder.variant == 0 and "one of each pattern" in state.message


def test_more_fills_keep_the_place() -> None:
    state = opened(make_flat_boundary((4, 3, 4, 3)), limit=4)
    try:
        state.settle(3)
        state.settle()
        assert state.finder.truncated and len(state.finder.fills) == 4
        first = [f.quads.tolist() for f in state.finder.fills]
        keys(state, "m")
        state.settle()
        assert len(state.finder.fills) == 8 and state.finder.rank == 3
        assert [f.quads.tolist() for f in state.finder.fills[:4]] == first
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
    state = ExplorerState(source, make_flat_boundary((2, 2, 2, 2)))
    try:
        first = state.finder._search
        assert first is not None and state.finder.searching
        assert "searching …" in said(state)
        keys(state, "] ]")
        assert state.finder.boundary is not None and state.finder.boundary.perimeter > 8
        assert state.finder.searching and state.finder._search is not first
        source.gate.set()
        state.settle(0)
        assert first.wait(timeout=60.0) and first.fills == []
        assert all(sum(f.lengths) == state.finder.boundary.perimeter for f in state.finder.fills)
    finally:
        source.gate.set()
        state.close()


def test_a_query_that_fails_says_why() -> None:
    class Broken(Source):
        def pattern_class(self, n_sides: int) -> PatternClass:
            raise NotFoundError("the disk is gone")

    state = ExplorerState(Broken(), make_flat_boundary((2, 2, 2, 2)))
    try:
        with pytest.raises(NotFoundError, match="the disk is gone"):
            state.settle(0)
        texts = " ".join(said(state))
        assert "the disk is gone" in texts and "No fill" in texts
    finally:
        state.close()


def test_strokes_snap_to_boundary_edges_and_are_had(state: ExplorerState) -> None:
    assert state.contour is not None and state.finder.boundary is not None
    left = state.camera.view.seen(state.contour.sides[3]).mean(axis=0)[:2]
    right = state.camera.view.seen(state.contour.sides[1]).mean(axis=0)[:2]
    keys(state, "s")
    middle = (left + right) / 2.0 + (0.0, 25.0)
    drag(state, tuple(left + np.array([12.0, 3.0])), tuple(middle), tuple(right - (9.0, 5.0)))
    assert state.mode is PointerMode.LOOK and len(state.finder.strokes) == 1
    stroke = state.finder.strokes[0]
    assert stroke.start is not None and stroke.end is not None and stroke.points is not None
    assert (stroke.start[0], stroke.end[0]) == (3, 1)
    points = state.finder.boundary.points
    assert points is not None
    at = state.finder.boundary.side_starts[3] + stroke.start[1]
    assert np.allclose(stroke.points[0], (points[at] + points[(at + 1) % len(points)]) / 2.0)
    keys(state, ", ,")
    assert state.finder.tolerance == 0
    state.settle()
    assert state.finder.fills
    for fill in state.finder.fills:
        ends = find_strand(fill, stroke.start).ends
        assert ends is not None and stroke.end in ends
    placed = state.finder.placed
    assert placed is not None and len(placed.net.carried)
    before, after = placed.placement.strokes_before, placed.placement.strokes_after
    assert after[0, 0] <= before[0, 0]
    keys(state, "f")
    state.settle()
    assert state.finder.placed is not None and state.finder.placed.placement.pull == 0.0
    keys(state, "o o o")
    assert state.finder.order == "flow"
    keys(state, "x")
    assert state.finder.strokes == [] and state.finder.default_order == "fit"
    state.settle()
    assert state.finder.fills and state.finder.fills[0].flow_distance is None


def test_loops_and_strokes_that_are_none(state: ExplorerState) -> None:
    keys(state, "l")
    turn = np.linspace(0.0, 5.5, 12)
    drag(state, *((60.0 * np.cos(t), 60.0 * np.sin(t)) for t in turn))
    assert [s.is_loop for s in state.finder.strokes] == [True]
    keys(state, "s")
    click(state, (0.0, 0.0))
    assert "two points" in state.message and len(state.finder.strokes) == 1
    assert state.mode is PointerMode.STROKE
    keys(state, "Escape ]")
    assert len(state.finder.strokes) == 1


def test_a_stroke_is_drawn_anew_on_a_changed_boundary() -> None:
    boundary = make_flat_boundary((4, 3, 4, 3))
    assert boundary.points is not None
    stroke = Stroke.drawn(boundary, boundary.points[[5, 12]])
    state = opened(boundary, strokes=[stroke])
    try:
        keys(state, "] ]")
        assert state.finder.boundary is not None and state.finder.boundary.perimeter > 14
        (again,) = state.finder.strokes
        again.refuse_unless_on(state.finder.boundary)
        assert again == Stroke.drawn(state.finder.boundary, boundary.points[[5, 12]])
    finally:
        state.close()


PLACES = st.tuples(st.integers(-320, 320), st.integers(-320, 320))


EVENTS = st.one_of(
    st.sampled_from(sorted(set(KEYS.actions) - {"m"})),
    st.tuples(st.sampled_from(["move", "press", "release", "turn"]), PLACES),
)


@settings(max_examples=12)
@given(st.lists(EVENTS, max_size=14))
def test_any_events_leave_a_state_that_can_be_shown(events: list[object]) -> None:
    state = opened(make_flat_boundary((2, 2, 2, 2)), limit=5)
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
            assert 0 <= state.finder.rank <= max(len(state.finder.fills) - 1, 0)
        assert are_finite(compose_explorer(state, 1040.0, 860.0))
    finally:
        state.close()


def test_strands_cross_under_the_pointer(state: ExplorerState) -> None:
    """In the middle of any quad that is seen: they are those through it; not beside the fill, nor
    while something is drawn."""
    state.settle(0)
    placed, fill = state.finder.placed, state.finder.fill
    assert placed is not None and fill is not None
    corners = placed.placement.vertices[fill.quads]
    middles = state.camera.view.seen(corners.mean(axis=1))
    for quad, (x, y, _) in enumerate(middles.tolist()):
        state.move(x, y)
        assert state.quad_under() == quad
        lines = state.strips_under()
        assert 1 <= len(lines) <= 2
        around = {
            tuple(p) for p in (0.5 * (corners[quad] + np.roll(corners[quad], -1, 0))).round(9)
        }
        passed = {tuple(p) for line in lines for p in line.round(9)}
        assert around <= passed
        for line in lines:
            steps = len(line) - 1
            assert steps >= 1
    x, y, _ = middles[0].tolist()
    assert state.move(*middles[1, :2].tolist()), "another quad is another picture"
    keys(state, "t")
    assert state.strips_under() == []
    keys(state, "t")
    state.move(x, y)
    assert state.strips_under()
    keys(state, "s")
    assert state.strips_under() == []
    keys(state, "Escape")
    state.move(9999.0, 0.0)
    assert state.strips_under() == []
