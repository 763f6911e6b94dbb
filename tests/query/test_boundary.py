"""What is a boundary, and what is refused with which advice."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.errors import InvalidBoundaryError, PatternDBError
from query import Boundary, fills
from query.boundary import MAX_PERIMETER
from query.engine import PatternSource
from query.errors import InvalidQueryError

NAN = float("nan")


@given(st.lists(st.integers(1, 40), min_size=1, max_size=12))
def test_it_is_a_boundary_exactly_if_the_perimeter_is_even_and_at_least_4(
    lengths: list[int],
) -> None:
    if sum(lengths) % 2 or sum(lengths) < 4:
        with pytest.raises(InvalidBoundaryError):
            Boundary(lengths)
    else:
        boundary = Boundary(lengths)
        assert boundary.lengths == tuple(lengths)
        assert boundary.n_sides == len(lengths)
        assert boundary.perimeter == sum(lengths)
        assert boundary.corners == ("convex",) * len(lengths)
        assert boundary.corner_counts == (1,) * len(lengths)
        assert boundary.convex


def test_one_closed_side_has_no_corner() -> None:
    closed = Boundary.closed(8)
    assert (closed.n_sides, closed.lengths, closed.perimeter) == (0, (8,), 8)
    assert closed == Boundary((8,), corners=())
    assert closed != Boundary((8,)), "one side with one corner is another boundary"


def test_a_reflex_corner_asks_for_three_quads() -> None:
    boundary = Boundary((2, 1, 1, 1, 1, 2), ["convex"] * 3 + ["reflex"] + ["convex"] * 2)
    assert boundary.corner_counts == (1, 1, 1, 3, 1, 1)
    assert not boundary.convex


def test_whole_numbers_of_any_type_are_lengths() -> None:
    assert Boundary(np.array([3, 4, 5])).lengths == (3, 4, 5)
    assert Boundary([3.0, np.float64(4), np.int8(5)]).lengths == (3, 4, 5)
    assert all(type(n) is int for n in Boundary(np.array([3.0, 4.0, 5.0])).lengths)


@pytest.mark.parametrize(
    ("lengths", "corners", "words"),
    [
        ((5, 6, 6), None, ["17 is odd", "change one side by 1"]),
        ((1, 1), None, ["perimeter 2 is below 4", "lengthen"]),
        ((3, 0, 3), None, ["side 1 has length 0", "at least 1"]),
        ((3, -5, 6), None, ["side 1 has length -5"]),
        ((3, 2.5, 3), None, ["side 1 has length 2.5", "whole number"]),
        ((3, NAN, 3), None, ["side 1", "nan", "whole number"]),
        ((float("inf"), 2), None, ["side 0", "whole number"]),
        (("4", 4), None, ["side 0", "'4'", "whole number"]),
        ((None, 4), None, ["side 0", "whole number"]),
        ((), None, ["at least one side", "Boundary.closed(8)"]),
        ((), (), ["at least one side"]),
        ((3, 3, 4), ("convex",), ["3 sides have 3 corners, not 1"]),
        ((3, 3, 4), (), ["3 sides have 3 corners, not 0"]),
        ((4, 4), ("convex", "flat"), ["corner 1 is 'flat'", '"convex", "reflex" or "full"']),
        ((MAX_PERIMETER, 2), None, [f"above the limit of {MAX_PERIMETER}"]),
        ((10**30, 10**30), None, ["above the limit"]),
    ],
)
def test_what_is_refused_says_why_and_what_would_mend_it(
    lengths: tuple[int, ...], corners: tuple[str, ...] | None, words: list[str]
) -> None:
    with pytest.raises(InvalidBoundaryError) as refusal:
        Boundary(lengths, corners)  # pyright: ignore[reportArgumentType]
    assert isinstance(refusal.value, PatternDBError)
    assert isinstance(refusal.value, ValueError)
    for word in words:
        assert word in str(refusal.value)


def test_the_largest_boundary_is_one() -> None:
    assert Boundary((MAX_PERIMETER // 4,) * 4).perimeter == MAX_PERIMETER


def test_full_corners_have_four_quads(source: PatternSource) -> None:
    kinds = {1: "convex", 3: "reflex", 4: "full"}
    asked = 0
    for n_sides in (4, 5, 6, 7):
        patterns = source.pattern_class(n_sides)
        rows = np.flatnonzero((patterns.corners == 4).any(axis=1) & (patterns.min_valence >= 3))
        for row in rows[:3].tolist():
            counts = patterns.corners[row].tolist()
            if not set(counts) <= kinds.keys():
                continue
            pattern = patterns.pattern(row)
            lengths = [len(side) for side in pattern.label]
            if sum(lengths) % 2:
                continue
            boundary = Boundary(lengths, [kinds[k] for k in counts])
            assert boundary.corner_counts == tuple(counts) and not boundary.convex
            listed = list(fills(source, boundary, strict=True, limit=None))
            assert pattern.id in {fill.pattern.id for fill in listed}
            for fill in listed:
                valence = np.bincount(fill.quads.ravel())
                at = list(boundary.side_starts[:-1])
                assert valence[at].tolist() == counts
                assert fill.n_irregular_boundary == 0
            asked += 1
            with pytest.raises(InvalidQueryError, match="strict"):
                fills(source, boundary)
    assert asked >= 6
