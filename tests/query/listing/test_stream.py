"""The list of fills as a stream: lazy, in every order, ended from outside, and filtered."""

from __future__ import annotations

import random
import threading
import time
from collections import Counter
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import query
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.core.quadmesh import QuadMesh
from patterndb.system.deadline import limit_time
from query import Boundary, Fill, Stroke
from query.errors import InvalidQueryError
from query.listing.matches import list_loop_widths
from query.listing.orders import ORDERS
from query.placing.strands import count_edges_off
from tests.support.query.cases import (
    LEARNED,
    Source,
    answer,
    code_of,
    polygon,
    small_class,
    small_patterns,
)

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


@pytest.mark.parametrize("by_limit", [True, False])
def test_who_waits_for_a_measure_is_let_go(by_limit: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, release = threading.Event(), threading.Event()

    def measure(fill: Fill, *_: object) -> tuple[float, Fill]:
        begun.set()
        release.wait(60)
        return 0.0, fill

    monkeypatch.setitem(ORDERS, "small", replace(ORDERS["small"], measure=measure))
    monkeypatch.setattr("query.listing.fills.LARGE_QUADS", 1)
    limit = 0.3 if by_limit else None
    stream = query.fills(Source(), (5, 4, 6, 3, 4), order="small", time_limit=limit)
    try:
        if not by_limit:
            threading.Thread(target=lambda: (begun.wait(60), stream.cancel())).start()
        found = list(stream)
        # The one that was measured when time was up would be first of whatever there is.
        assert len(found) == by_limit
        assert stream.stopped == ("time limit" if by_limit else "cancelled")
        assert begun.is_set() and stream.truncated
    finally:
        release.set()


@pytest.mark.parametrize("options", [{}, {"strict": True}, LEARNED], ids=str)
def test_whoever_has_no_time_still_gets_a_fill(options: dict[str, object]) -> None:
    # Tables are there; what is loaded once takes longer than the list may be late.
    assert next(query.fills(Source(), (5, 4, 6, 3, 4), **options), None)  # pyright: ignore
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
    ({"pattern_corners": (6, 6)}, lambda f: f.pattern.n_sides == 6),
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
        {"pattern_corners": (5, 3)},
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


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_exact_strokes_come_before_near_ones_and_none_is_lost(data: st.DataObject) -> None:
    """With a tolerance the list is that without, and then all fills that miss by an edge."""
    lengths = data.draw(st.lists(st.integers(2, 5), min_size=3, max_size=5), "lengths")
    lengths[0] += sum(lengths) % 2
    boundary = Boundary(lengths)
    edges = [(side, edge) for side in range(len(lengths)) for edge in range(lengths[side])]
    ends = data.draw(st.lists(st.sampled_from(edges), min_size=4, max_size=4, unique=True), "ends")
    strokes = [Stroke(ends[0], ends[1]), Stroke(ends[2], ends[3])]
    strokes = strokes[: data.draw(st.integers(1, 2), "strokes")]
    order = data.draw(st.sampled_from(["artist", "regular", "small", "symmetric"]), "order")
    options = {"origins": ("learned", "family"), "limit": None, "pool": 100_000}

    def ask(tolerance: int) -> list[tuple[int, object]]:
        found = query.fills(
            Source(),
            boundary,
            strokes=strokes,
            tolerance=tolerance,
            order=order,
            max_irregular=4,
            **options,  # pyright: ignore
        )
        offs = ((count_edges_off(fill, strokes, tolerance), fill) for fill in found)
        return [(off, code_of(fill)) for off, fill in offs if off is not None]

    found = ask(1)
    exact = ask(0)
    assert [code for off, code in found if off == 0] == [code for _, code in exact]
    assert all(off == 0 for off, _ in found[: len(exact)])
    every = query.fills(Source(), boundary, max_irregular=4, **options)  # pyright: ignore
    wanted = [code_of(fill) for fill in every if count_edges_off(fill, strokes, 1) is not None]
    assert sorted(code for _, code in found) == sorted(wanted)


def test_a_limit_counts_over_exact_and_near_strokes() -> None:
    boundary, strokes = Boundary((4, 3, 5, 4)), [Stroke((0, 1), (2, 2))]
    whole = [code_of(f) for f in query.fills(Source(), boundary, strokes=strokes, limit=None)]
    exact = query.fills(Source(), boundary, strokes=strokes, tolerance=0, limit=None)
    count = len(list(exact))
    assert 0 < count < len(whole)
    for limit in (1, count, count + 1, len(whole), len(whole) + 1):
        some = query.fills(Source(), boundary, strokes=strokes, limit=limit)
        assert [code_of(fill) for fill in some] == whole[:limit]
        assert some.truncated == (limit < len(whole))


def make_pole(valence: int, frequency: int) -> Pattern:
    """The pattern of quads around one vertex."""
    rim = 2 * valence
    around = [[(2 * k - 1) % rim, 2 * k, 2 * k + 1, rim] for k in range(valence)]
    pattern = Pattern.from_disk(QuadMesh.from_quads(np.array(around)).twin)
    return Pattern.from_trusted_code(pattern.code, frequency=frequency)


@pytest.mark.parametrize("ratio", [1, 2, 4, 20])
def test_a_pole_stands_first_only_where_artists_made_it_more_than_fives(ratio: int) -> None:
    """By what they are worth: patches times symmetries, of which a pole of six has twelve."""
    fives = next(p for p in small_patterns() if p.n_sides == 6 and p.valences == (5, 5))
    symmetries = fives.rotations * (1 if fives.chiral else 2)
    pole = make_pole(6, 10)
    assert pole.valences == (6,) and pole.rotations == 6
    made = Pattern.from_trusted_code(fives.code, frequency=10 * ratio)
    source = PatternClass.from_patterns(6, [pole, made])
    first = query.best(source, (4, 4, 4, 4, 4, 4))
    assert first is not None
    assert first.pattern == (made if 10 * ratio * symmetries > 10 * 12 else pole)
    regular = query.best(source, (4, 4, 4, 4, 4, 4), order="regular")
    assert regular is not None and regular.pattern == pole
    assert query.best(source, (2, 2, 2, 2, 2, 2)).pattern == pole  # pyright: ignore


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_of_strokes_that_no_fill_has_it_is_said_which_go_together(seed: int) -> None:
    """Brute force over all pairs, then all strokes alone."""
    chance = random.Random(seed)
    lengths = [chance.randint(2, 4) for _ in range(chance.randint(3, 4))]
    lengths[0] += sum(lengths) % 2
    edges = [(side, edge) for side in range(len(lengths)) for edge in range(lengths[side])]
    ends = chance.sample(edges, 6)
    strokes = [Stroke(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True)]

    def has_fill(chosen: tuple[int, ...]) -> bool:
        asked = [strokes[i] for i in chosen]
        return query.best(Source(), lengths, strokes=asked, tolerance=0) is not None

    found = query.fills(Source(), lengths, strokes=strokes, tolerance=0)
    if list(found):
        assert found.reason is None and has_fill((0, 1, 2))
        return
    pairs = [pair for pair in combinations(range(3), 2) if has_fill(pair)]
    alone = [(one,) for one in range(3) if has_fill((one,))]
    groups = pairs or alone
    words = ", and with ".join(" and ".join(str(i + 1) for i in group) for group in groups)
    reason = str(found.reason)
    if groups:
        assert f"but there are fills with {words}{'' if pairs else ' alone'}," in reason
    else:
        assert "nor on any one of them" in reason


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_variants_are_what_one_fill_of_each_pattern_leaves_out(data: st.DataObject) -> None:
    """A list with one fill of each pattern and all their variants is the flat list: the first of
    every pattern, in the flat list's order, and the others in that order too."""
    lengths = data.draw(st.lists(st.integers(1, 4), min_size=2, max_size=5), "lengths")
    lengths[0] += sum(lengths) % 2
    if sum(lengths) < 4:
        lengths[0] += 2
    order = data.draw(st.sampled_from(["artist", "regular", "small", "symmetric"]), "order")
    strokes = []
    if data.draw(st.booleans(), "stroke"):
        strokes = [Stroke((0, 0), (1, lengths[1] - 1))]
    options = {"order": order, "strokes": strokes, "pool": 100_000, "max_irregular": 4}
    flat = list(query.fills(Source(), lengths, limit=None, **options))  # pyright: ignore
    by_pattern: dict[int, list[object]] = {}
    for fill in flat:
        by_pattern.setdefault(fill.pattern.id, []).append(code_of(fill))
    found = query.fills(Source(), lengths, limit=None, per_pattern=1, **options)  # pyright: ignore
    folded = list(found)
    assert [fill.pattern.id for fill in folded] == list(by_pattern)
    counts = found.count_variants(folded, most=10)
    for fill, count in zip(folded, counts, strict=True):
        codes = by_pattern[fill.pattern.id]
        assert code_of(fill) == codes[0]
        assert [code_of(one) for one in found.variants(fill)] == codes[1:]
        assert count == min(len(codes) - 1, 10)
        assert len(list(found.variants(fill, limit=2))) == min(len(codes) - 1, 2)
        only = query.fills(Source(), lengths, limit=None, pattern=fill.pattern.name, **options)  # pyright: ignore
        assert sorted(map(code_of, only)) == sorted(codes)  # pyright: ignore
    assert not found.cut_short
    assert found.truncated == (len(folded) < len(flat))


def test_different_patterns_of_families_without_end_come_at_once() -> None:
    """Each of these patterns has more fills than would ever be listed."""
    found = query.fills(Source(), (40, 41, 42, 43, 44, 46), per_pattern=1, limit=8, order="regular")
    folded = list(found)
    assert len({fill.pattern.id for fill in folded}) == 8
    assert found.cut_short
    assert all(0 <= count <= 3 for count in found.count_variants(folded, most=3))
    assert max(found.count_variants(folded, most=3)) == 3


def test_what_follows_a_list_that_its_limit_ended_is_no_proof() -> None:
    strokes = [Stroke((0, i % 5), (3, 3 * i % 5)) for i in range(20)]
    found = query.fills(Source(), (5,) * 6, strokes=strokes, time_limit=1e-9, max_irregular=0)
    assert list(found) == []
    assert (found.stopped, found.complete, found.truncated) == ("time limit", False, True)
    assert "there may be one" in str(found.reason)
    assert found.feasible_patterns is None


def test_of_strokes_that_time_did_not_suffice_for_nothing_is_said() -> None:
    strokes = [Stroke((0, 1), (2, 1)), Stroke((0, 0), (0, 1)), Stroke((1, 0), (1, 2))]
    found = query.fills(Source(), (3, 3, 3, 3), strokes=strokes, tolerance=0)
    assert list(found) == [] and found.complete
    # Time is up while the reason is looked for.
    found._limits.flag[0] = 1
    reason = str(found.reason)
    assert "time was up before it was known which of them go together" in reason
    assert "nor on any one" not in reason


def test_variants_that_time_did_not_suffice_to_count_are_unknown() -> None:
    found = query.fills(Source(), (5, 4, 6, 3, 4), per_pattern=1, limit=3)
    listed = list(found)
    counts = found.count_variants(listed, most=1000)
    assert None not in counts
    found.cancel()
    assert found.count_variants(listed, most=1000) == [None] * len(listed)


def test_the_deadline_of_the_thread_ends_a_list() -> None:
    with limit_time(1e-9):
        found = query.fills(Source(), (5, 4, 6, 3, 4), limit=None)
        list(found)
    assert (found.stopped, found.complete) == ("time limit", False)


@pytest.mark.parametrize(
    "options",
    [
        {"tolerance": 2001},
        {"limit": 2**31},
        {"pool": 10**26},
        {"max_boundary_irregular": 10**26},
        {"max_irregular": 2**63},
        {"max_quads": 2**31},
        {"min_frequency": 10**26},
        {"valence": (3, 2**63)},
        {"pattern_corners": (3, 10**26)},
    ],
)
def test_large_numbers_are_refused(options: dict[str, int]) -> None:
    with pytest.raises(InvalidQueryError, match=next(iter(options))):
        query.fills(Source(), (3, 5, 4, 6), **options)  # pyright: ignore
