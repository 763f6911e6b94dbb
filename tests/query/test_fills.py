"""Queries: complete, without repeats, in order, and honest about what is left out."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Iterable
from functools import cache
from itertools import product

import numpy as np
import pytest

import query
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from patterndb.errors import InvalidBoundaryError, PatternDBError
from query import Boundary, Fill
from query.boundary import CornerKind
from query.errors import InvalidQueryError
from query.listing.explanation import explain_impossible
from query.recognition import is_mesh
from query.request import NO_DOUBLETS, PatternFilter
from query.solving import feasibility, widths
from tests.support.fillchecks import check_fill
from tests.support.query.cases import (
    LEARNED,
    Answer,
    Source,
    answer,
    class_of,
    code_of,
    small_class,
    small_fills,
    small_patterns,
)
from tests.support.reference.code import Code

#: As a query is without options.
ANYTHING = {
    "strict": False,
    "origins": None,
    "order": None,
    "valence": NO_DOUBLETS,
}


#: Parts that boundaries are shared out in.
PARTS = 10


def every(boundary: Boundary, **options: object) -> Answer:
    return answer(Source(), boundary, **{"limit": None, **options})


def coded(found: Iterable[Fill], boundary: Boundary) -> list[Code]:
    return [code_of(fill, boundary.n_sides == 0) for fill in found]


@cache
def some_boundaries(count: int, most: int = 14) -> list[Boundary]:
    """Boundaries that small disks fill; few sides are as likely as many."""
    chance = random.Random(count)
    by_sides: dict[tuple[int, bool], list[Boundary]] = {}
    for boundary in sorted(small_fills(), key=repr):
        if boundary.perimeter <= most:
            by_sides.setdefault((boundary.n_sides, boundary.convex), []).append(boundary)
    per_class = -(-count // len(by_sides))
    return [
        b for group in by_sides.values() for b in chance.sample(group, min(per_class, len(group)))
    ]


#: Tests that share out some boundaries among them: the small disks are laid on boundaries only
#: where one of them runs, not whenever tests are collected.
in_parts = pytest.mark.parametrize("part", range(PARTS))


def is_small(fill: Fill) -> bool:
    """Is it among the small disks?"""
    inner = fill.disk().valence()[fill.perimeter :]
    return len(inner) <= 4 and all(3 <= v <= 5 for v in inner)


@in_parts
def test_exactly_the_small_disks_are_found_and_none_twice(part: int) -> None:
    """All quad disks of that size are known: a query must list each, in every way it lies."""
    for boundary in some_boundaries(260)[part::PARTS]:
        found = every(boundary)
        codes = coded(found, boundary)
        assert len(set(codes)) == len(codes)
        small = {code for code, fill in zip(codes, found, strict=True) if is_small(fill)}
        assert small == small_fills()[boundary]
        assert not found.truncated
        assert found.reason is None
        assert found.feasible_patterns == len({fill.pattern.id for fill in found})


@in_parts
def test_fills_are_disks_along_their_boundary(part: int) -> None:
    for boundary in some_boundaries(60, 12)[part::PARTS]:
        for fill in every(boundary):
            document = json.loads(json.dumps(fill.to_json()))
            kinds = list(boundary.corner_counts)
            if boundary.n_sides == 0:
                # The first vertex of the side is no corner.
                kinds = [2]
            irregular = check_fill(boundary.lengths, document, kinds)
            assert irregular == (fill.n_irregular, 0), "strict fills are regular on the boundary"


def test_json_has_exactly_these_keys() -> None:
    fill = query.best(Source(), (4, 4, 4))
    assert fill is not None
    document = fill.to_json()
    assert set(document) == {
        "pattern",
        "origin",
        "frequency",
        "widths",
        "rotation",
        "mirrored",
        "n_irregular",
        "n_irregular_boundary",
        "strict",
        "flow_distance",
        "n_vertices",
        "quads",
        "sides",
    }
    assert document["pattern"] == f"{fill.pattern.id:016x}"
    assert [len(side) - 1 for side in document["sides"]] == [4, 4, 4]


@pytest.mark.parametrize("boundary", [(4, 4, 4, 4), (5, 4, 6, 3, 6), (6, 5, 5), (7, 9)], ids=str)
def test_fills_come_in_order(boundary: tuple[int, ...]) -> None:
    found = every(Boundary(boundary))
    by_pattern = [(f.n_irregular, -f.pattern.frequency, f.pattern.id) for f in found]
    assert by_pattern == sorted(by_pattern)
    assert len(set(by_pattern)) > 1
    within = [
        (*key, sum(w * w for w in f.widths), f.widths, f.mirrored, f.rotation)
        for key, f in zip(by_pattern, found, strict=True)
    ]
    assert within == sorted(within)


@in_parts
def test_shorter_lists_are_beginnings_and_say_that_they_are(part: int) -> None:
    for boundary in some_boundaries(30)[part::PARTS]:
        whole = every(boundary)
        codes = coded(whole, boundary)
        per_pattern = Counter(fill.pattern.id for fill in whole)
        for limit in (1, 2, 5, 20, len(whole), len(whole) + 1):
            found = answer(Source(), boundary, limit=limit)
            assert coded(found, boundary) == codes[:limit]
            assert found.truncated == (len(whole) > limit)
            assert found.feasible_patterns == whole.feasible_patterns
        for most in (1, 2, 4):
            found = answer(Source(), boundary, limit=None, per_pattern=most)
            kept: Counter[int] = Counter()
            expected = []
            for fill, code in zip(whole, codes, strict=True):
                kept[fill.pattern.id] += 1
                if kept[fill.pattern.id] <= most:
                    expected.append(code)
            assert coded(found, boundary) == expected
            assert found.truncated == (max(per_pattern.values()) > most)
        best = query.best(Source(), boundary, **LEARNED)
        assert best is not None
        assert code_of(best, boundary.n_sides == 0) == codes[0]


@pytest.mark.parametrize("boundary", [(5, 5, 6), (4, 5, 4, 5), (3, 4, 5, 4, 4), (6, 8)], ids=str)
def test_cpsat_gives_the_same_list(boundary: tuple[int, ...]) -> None:
    kernel = answer(Source(), boundary, limit=12, per_pattern=2)
    other = answer(Source(), boundary, limit=12, per_pattern=2, solver="cp-sat")
    assert len(kernel) > 0
    assert [f.to_json() for f in kernel] == [f.to_json() for f in other]
    assert kernel.feasible_patterns == other.feasible_patterns
    assert kernel.truncated == other.truncated


def test_the_list_does_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(widths, "ROWS_PER_THREAD", 1)
    monkeypatch.setattr(feasibility, "ROWS_PER_THREAD", 5)
    for boundary, mode in product(some_boundaries(20)[::3], (LEARNED, ANYTHING)):
        lists = [
            [f.to_json() for f in answer(Source(), boundary, threads=threads, **mode)]
            for threads in (1, 2, 8)
        ]
        assert lists[0] == lists[1] == lists[2]
        assert lists[0]


@in_parts
def test_filters_take_away_and_add_nothing(part: int) -> None:
    for boundary in some_boundaries(20)[part::PARTS]:
        whole = every(boundary)
        for most in (0, 1, 2, 3):
            expected = [f.to_json() for f in whole if f.n_irregular <= most]
            assert [f.to_json() for f in every(boundary, max_irregular=most)] == expected
        for least, greatest in ((3, 5), (3, 4), (3, 3), (5, 6)):
            expected = [
                f.to_json()
                for f in whole
                if all(least <= v <= greatest for v in f.pattern.valences)
            ]
            assert [f.to_json() for f in every(boundary, valence=(least, greatest))] == expected


def test_patterns_that_expand_to_the_same_fill_give_it_once() -> None:
    """A polychord that crosses itself, widened, is itself a pattern: the fill is listed once."""
    shared = 0
    for pattern in small_patterns():
        if not pattern.self_crossing:
            continue
        polychords = pattern.polychords()
        wide = [2 if c else 1 for c in polychords.crosses_itself]
        fill = answer(
            class_of(pattern.n_sides, [pattern]),
            Boundary(_wide_lengths(pattern, wide), _kinds(pattern)),
            limit=None,
        )
        twins_of = [_own_pattern(f) for f in fill]
        others = {p.id: p for p in twins_of if p.id != pattern.id}
        if not others:
            continue
        shared += 1
        both = answer(
            class_of(pattern.n_sides, [pattern, *others.values()]),
            fill.boundary,
            limit=None,
        )
        codes = [code_of(f) for f in both]
        assert len(set(codes)) == len(codes)
        assert set(codes) >= {code_of(f) for f in fill}
        one = answer(
            class_of(pattern.n_sides, [pattern, *others.values()]),
            fill.boundary,
            limit=len(codes),
        )
        assert not one.truncated, "a fill that is listed already is none beyond the limit"
        if shared == 12:
            break
    assert shared


def _wide_lengths(pattern: Pattern, widths: list[int]) -> list[int]:
    return [sum(widths[c] for c in side) for side in pattern.label]


def _kinds(pattern: Pattern) -> tuple[CornerKind, ...]:
    return tuple("convex" if k == 1 else "reflex" for k in pattern.corners)


def _own_pattern(fill: Fill) -> Pattern:
    """The pattern that the fill itself reduces to."""
    return Pattern.from_disk(reduce_disk(QuadMesh.from_quads(fill.quads).twin))


def test_a_rectangle_is_a_grid() -> None:
    fill = query.best(Source(), (3, 5, 3, 5))
    assert fill is not None
    assert (fill.n_quads, fill.n_irregular, fill.n_vertices) == (15, 0, 24)


def test_edges_between_the_same_two_vertices_are_no_mesh() -> None:
    # Quads on both sides of two edges between vertices 0 and 2.
    assert is_mesh(np.array([[0, 1, 2, 3], [0, 3, 2, 4]], np.int32))
    assert not is_mesh(np.array([[0, 1, 2, 3], [0, 1, 4, 5]], np.int32))
    assert not is_mesh(np.array([[0, 1, 0, 3]], np.int32))


@pytest.mark.parametrize(
    ("boundary", "options", "words"),
    [
        (Boundary((2, 1, 1)), {}, ["side 1 has length 1", "4 sides, not 3", "length 2"]),
        (Boundary((1, 3)), {}, ["side 0 has length 1"]),
        (Boundary((4, 4, 4)), {"max_irregular": 0}, ["1 below 4", "at least 1"]),
        (Boundary((4, 4, 4)), {"valence": (4, 7)}, ["1 below 4", "4 to 7", "widen"]),
        (Boundary((4,) * 7), {"max_irregular": 1, "valence": (3, 5)}, ["3 above 4", "at least 3"]),
        (Boundary((4,) * 7), {"valence": (3, 4)}, ["3 above 4", "3 to 4"]),
        (Boundary.closed(8), {"max_irregular": 1}, ["one closed side", "at least 2"]),
        (Boundary((2,) * 30), {}, ["no pattern with 30 sides", "learn"]),
        (Boundary((9,) * 6), {"max_irregular": 0}, ["2 above 4", "at least 1"]),
        (Boundary((2, 2, 30)), {}, ["3 sides", "2, 2, 30", "fits"]),
    ],
    ids=str,
)
def test_an_empty_list_says_why(
    boundary: Boundary, options: dict[str, object], words: list[str]
) -> None:
    found = answer(Source(), boundary, **options)  # pyright: ignore
    assert len(found) == 0
    assert query.best(Source(), boundary, **{**LEARNED, **options}) is None  # pyright: ignore
    assert found.feasible_patterns == 0
    assert not found.truncated
    assert found.reason is not None
    for word in words:
        assert word in found.reason


def test_what_is_called_impossible_has_no_small_fill() -> None:
    for boundary in small_fills():
        assert explain_impossible(boundary, PatternFilter()) is None
    for boundary in some_boundaries(100)[::3]:
        for filters in [
            *(PatternFilter(max_irregular=n) for n in range(4)),
            *(PatternFilter(max_irregular=2, valence=(3, g)) for g in (3, 4, 5)),
            *(PatternFilter(valence=(least, 5)) for least in (3, 4, 5)),
        ]:
            if explain_impossible(boundary, filters):
                options = {"max_irregular": filters.max_irregular, "valence": filters.valence}
                assert not every(boundary, **options)


@pytest.mark.parametrize(
    "options",
    [
        {"limit": 0},
        {"per_pattern": 0},
        {"threads": 0},
        {"max_irregular": -1},
        {"valence": (5, 3)},
        {"valence": (0, 3)},
        {"solver": "simplex"},
    ],
    ids=str,
)
def test_options_that_ask_for_nothing_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(InvalidQueryError) as refusal:
        answer(Source(), (4, 4, 4), **options)  # pyright: ignore
    assert isinstance(refusal.value, PatternDBError)
    assert next(iter(options)) in str(refusal.value)


def test_a_boundary_that_is_none_and_a_class_of_other_patterns_are_refused() -> None:
    with pytest.raises(InvalidBoundaryError, match="odd"):
        answer(Source(), (4, 4, 5))
    with pytest.raises(InvalidQueryError, match="patterns of 5 sides"):
        answer(small_class(5), (4, 4, 4))
    assert answer(small_class(3), (4, 4, 4))
