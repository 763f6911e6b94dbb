"""The list of fills as a stream: lazy, in every order, ended from outside, and filtered."""

from __future__ import annotations

import threading
import time
from collections import Counter

import pytest
from query_cases import LEARNED, Source, answer, code_of, polygon, small_class, small_patterns

import query
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from query import Boundary, Stroke
from query.errors import InvalidQueryError
from query.listing.lane import list_loop_widths
from query.placing.strands import count_edges_off

HEXAGON = Boundary((4, 3, 4, 3, 4, 4))


def test_the_first_fill_does_not_wait_for_the_last_pattern() -> None:
    stream = query.fills(Source(), (40, 41, 42, 43, 44, 46), limit=None)
    # All of them are more than would ever end.
    assert len([fill for fill, _ in zip(stream, range(5), strict=False)]) == 5


def test_a_cancelled_list_ends_and_is_a_beginning() -> None:
    boundary = (30, 31, 32, 33, 34, 36)
    whole = [
        code_of(f)
        for f, _ in zip(query.fills(Source(), boundary, limit=None), range(30), strict=False)
    ]
    stream = query.fills(Source(), boundary, limit=None)
    found = []
    ended = threading.Event()

    def run() -> None:
        found.extend(stream)
        ended.set()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    time.sleep(0.2)
    stream.cancel()
    assert ended.wait(10)
    assert stream.stopped == "cancelled"
    assert stream.truncated
    some = [code_of(fill) for fill in found[:30]]
    assert some == whole[: len(some)]
    assert next(stream, None) is None


def test_a_list_cancelled_before_it_began_is_empty_and_says_why() -> None:
    stream = query.fills(Source(), (4, 4, 4))
    stream.cancel()
    assert list(stream) == []
    assert stream.reason is not None and "cancelled" in stream.reason


@pytest.mark.parametrize("options", [{}, {"strict": True}, LEARNED], ids=str)
def test_whoever_has_no_time_still_gets_a_fill(options: dict[str, object]) -> None:
    stream = query.fills(Source(), (5, 4, 6, 3, 4), time_limit=1e-9, limit=None, **options)  # pyright: ignore
    time.sleep(0.01)
    found = list(stream)
    assert found
    assert stream.stopped == "time limit"
    assert stream.truncated
    assert len(found) < 1000


def test_what_artists_made_most_comes_first() -> None:
    """The order "artist" by its formula, fill by fill, after the most regular one."""
    source = small_class(5)
    found = list(
        query.fills(source, (3, 4, 4, 3, 4), limit=None, strict=True, origins=("learned",))
    )
    by_evenness = sorted(
        found, key=lambda f: (sum(w * w for w in f.widths), f.widths, f.mirrored, f.rotation)
    )
    meshes = dict(zip(source.ids.tolist(), source.n_meshes.tolist(), strict=True))
    place: dict[int, int] = {}
    worth: dict[bytes, float] = {}
    for fill in by_evenness:
        pattern = fill.pattern
        k = place[pattern.id] = place.get(pattern.id, 0) + 1
        symmetry = pattern.rotations * (1 if pattern.chiral else 2)
        worth[fill.quads.tobytes()] = pattern.frequency * meshes[pattern.id] * symmetry / k
    listed = [worth[fill.quads.tobytes()] for fill in found]
    assert listed[1:] == sorted(listed[1:], reverse=True)
    assert found[0].n_irregular == min(fill.n_irregular for fill in found)
    assert len(place) > 2 and max(place.values()) > 2


def test_the_order_of_flow_is_the_default_where_strokes_are_drawn() -> None:
    boundary = polygon((4, 4, 4, 4))
    assert boundary.points is not None
    stroke = Stroke.drawn(boundary, [boundary.points[1], boundary.points[11]])
    drawn = list(query.fills(Source(), boundary, strokes=[stroke], limit=5))
    asked = list(query.fills(Source(), boundary, strokes=[stroke], limit=5, order="flow"))
    assert [code_of(f) for f in drawn] == [code_of(f) for f in asked]
    with pytest.raises(InvalidQueryError, match="points"):
        query.fills(Source(), (4, 4, 4, 4), order="flow")
    with pytest.raises(InvalidQueryError, match="points"):
        query.fills(Source(), (4, 4, 4, 4), order="quality")


def test_points_make_widths_even_in_length_not_in_edges() -> None:
    """The same fills; of one pattern's, those of even lengths come first."""
    fine = polygon((3, 5, 6))
    by_points = answer(Source(), fine, limit=None)
    by_edges = answer(Source(), Boundary(fine.lengths), limit=None)
    assert {code_of(f) for f in by_points} == {code_of(f) for f in by_edges}


def test_loops_are_as_wide_as_their_strokes_ask() -> None:
    assert list_loop_widths(0, 0) == [()]
    assert list_loop_widths(0, 1) == []
    assert list_loop_widths(1, 3) == [(3,)]
    assert list_loop_widths(2, 1) == [(1, 1)]
    assert list_loop_widths(2, 2) == [(1, 1), (1, 2), (2, 1)]
    looped = [p for p in small_patterns() if p.n_loops and p.n_sides]
    pattern = looped[0]
    source = PatternClass.from_patterns(pattern.n_sides, [pattern])
    boundary = Boundary([len(side) for side in pattern.label], _kinds(pattern))
    for n in (1, 2, 3):
        found = answer(source, boundary, strokes=[Stroke.loop()] * n)
        assert found
        for fill in found:
            assert sum(fill.widths[pattern.n_chords :]) >= n
            assert fill.flow_distance == 0
            assert count_edges_off(fill, [Stroke.loop()] * n, 0) == 0


def _kinds(pattern: Pattern) -> tuple[str, ...]:
    return tuple("convex" if k == 1 else "reflex" for k in pattern.corners)


FILTERS = [
    ({"max_quads": 12}, lambda f: f.n_quads <= 12),
    ({"has_loop": True}, lambda f: f.pattern.n_loops > 0),
    ({"has_loop": False}, lambda f: f.pattern.n_loops == 0),
    ({"min_frequency": 4}, lambda f: f.pattern.frequency >= 4),
    ({"corners": (6, 6)}, lambda f: f.pattern.n_sides == 6),
    ({"max_irregular": 2}, lambda f: f.n_irregular <= 2),
    ({"max_boundary_irregular": 1}, lambda f: f.n_irregular_boundary <= 1),
    ({"valence": (3, 4)}, lambda f: all(3 <= v <= 4 for v in f.pattern.valences)),
]


@pytest.mark.parametrize(("filters", "passes"), FILTERS, ids=[str(f) for f, _ in FILTERS])
def test_filters_take_away_and_add_nothing(filters: dict[str, object], passes: object) -> None:
    asked = {"limit": None, "order": "regular", "origins": ("learned", "family")}
    boundary = Boundary((2, 3, 2, 3, 2, 2))
    whole = list(query.fills(Source(), boundary, **asked))  # pyright: ignore
    kept = list(query.fills(Source(), boundary, **asked, **filters))  # pyright: ignore
    assert [code_of(f) for f in kept] == [code_of(f) for f in whole if passes(f)]  # pyright: ignore
    # This boundary is too short for a loop.
    assert len(kept) < len(whole) or filters == {"has_loop": False}


@pytest.mark.parametrize(
    "options",
    [
        {"time_limit": 0},
        {"time_limit": float("nan")},
        {"tolerance": -1},
        {"pool": 0},
        {"order": "best"},
        {"max_quads": 0},
        {"corners": (5, 3)},
        {"min_frequency": 0},
        {"max_boundary_irregular": -1},
        {"strokes": [Stroke((0, 0), (7, 0))]},
        {"strokes": [Stroke((0, 9), (1, 0))]},
        {"meshes": ["cube.obj"]},
    ],
    ids=str,
)
def test_what_asks_for_nothing_is_refused(options: dict[str, object]) -> None:
    with pytest.raises(InvalidQueryError) as refusal:
        query.fills(Source(), HEXAGON, **options)  # pyright: ignore
    word = next(iter(options)).removesuffix("s")
    assert word in str(refusal.value)


def test_strokes_that_are_none_are_refused() -> None:
    for ends in (((0, 1), (0, 1)), ((0, 1), None), (None, (0, 1))):
        with pytest.raises(InvalidQueryError):
            Stroke(*ends)  # pyright: ignore
    with pytest.raises(InvalidQueryError, match="two points"):
        Stroke((0, 0), (1, 0), [[0, 0, 0], [0, 0, 0]])  # pyright: ignore
    with pytest.raises(InvalidQueryError, match="finite"):
        Stroke.loop([[0, 0, 0], [float("inf"), 0, 0]])


def test_strokes_on_a_closed_side_are_counted_from_its_vertex_0() -> None:
    """Every rotation of a fill is another answer once strokes say where edges are."""
    boundary = Boundary.closed(12)
    whole = list(query.fills(Source(), boundary, limit=None, max_irregular=4, origins=("learned",)))
    for end in (4, 6):
        strokes = [Stroke((0, 0), (0, end))]
        found = list(
            query.fills(
                Source(),
                boundary,
                strokes=strokes,
                tolerance=0,
                limit=None,
                max_irregular=4,
                origins=("learned",),
            )
        )
        assert found
        assert all(count_edges_off(fill, strokes, 0) == 0 for fill in found)
        # By hand: of all fills, turned by every number of edges, those with such a strand.
        wanted = set()
        for fill in whole:
            for turn in range(12):
                start = Stroke((0, turn), (0, (turn + end) % 12))
                if fill.strict and count_edges_off(fill, [start], 0) == 0:
                    wanted.add((code_of(fill, True), fill.n_quads))
        assert {(code_of(f, True), f.n_quads) for f in found if f.strict} == wanted


@pytest.mark.parametrize("per_pattern", [1, 2, 3])
def test_no_pattern_has_more_fills_than_asked_for(per_pattern: int) -> None:
    """In the default order too, whose first fill is found apart from the others."""
    options = {"strict": True, "origins": ("learned",), "limit": None}
    for boundary in ((4, 4, 5, 4, 5), (4, 5, 6, 5), (5, 6, 5)):
        whole = list(query.fills(Source(), boundary, **options))  # pyright: ignore
        stream = query.fills(Source(), boundary, per_pattern=per_pattern, **options)  # pyright: ignore
        found = list(stream)
        counts = Counter(fill.pattern.id for fill in found)
        every = Counter(fill.pattern.id for fill in whole)
        assert counts == {p: min(n, per_pattern) for p, n in every.items()}
        assert stream.truncated == (max(every.values()) > per_pattern)
        assert len({code_of(fill) for fill in found}) == len(found)
