"""Which side lengths have a regular fill: inequalities against the database and its family."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.counts import (
    has_regular_fill,
    solve_counts,
)
from query.boundary import Boundary
from query.engine import PatternSource, fills
from query.listing.construction import FamilyLookup
from tests.support.retopo.counts import glued


def is_regular_by_family(lengths: tuple[int, ...]) -> bool:
    """Has the complete family a fill of |N - 4| irregular vertices?"""
    if sum(lengths) % 2:
        return False
    count = FamilyLookup().count(Boundary(lengths))
    return count is not None and count <= abs(len(lengths) - 4)


@pytest.mark.parametrize(("n_sides", "longest"), [(2, 30), (3, 14), (4, 7), (5, 5), (6, 3)])
def test_up_to_six_sides_the_inequalities_are_the_family_s_answer(
    n_sides: int, longest: int
) -> None:
    for lengths in product(range(1, longest + 1), repeat=n_sides):
        # Turned and mirrored they are the same question.
        if lengths[0] == max(lengths) and lengths[1] >= lengths[-1] and sum(lengths) >= 4:
            assert has_regular_fill(lengths) == is_regular_by_family(lengths), lengths


@settings(max_examples=200)
@given(st.integers(3, 6), st.data())
def test_so_they_are_for_long_sides(n_sides: int, data: st.DataObject) -> None:
    lengths = even(data.draw(st.lists(st.integers(1, 60), min_size=n_sides, max_size=n_sides)))
    assert has_regular_fill(lengths) == is_regular_by_family(lengths)


@settings(max_examples=100)
@given(st.integers(7, 8), st.data())
def test_for_seven_and_eight_they_lie_between_strict_fills_and_all(
    n_sides: int, data: st.DataObject
) -> None:
    lengths = even(data.draw(st.lists(st.integers(1, 12), min_size=n_sides, max_size=n_sides)))
    strict = FamilyLookup().count(Boundary(lengths), strict=True)
    assert has_regular_fill(lengths) or strict is None or strict > n_sides - 4
    assert is_regular_by_family(lengths) or not has_regular_fill(lengths)


@settings(max_examples=30)
@given(st.integers(1, 12), st.data())
def test_a_query_finds_what_they_promise(
    source: PatternSource, n_sides: int, data: st.DataObject
) -> None:
    lengths = even(data.draw(st.lists(st.integers(2, 9), min_size=n_sides, max_size=n_sides)))
    if sum(lengths) < 4 or not has_regular_fill(lengths):
        return
    found = min(fill.n_irregular for fill in fills(source, Boundary(lengths), limit=5))
    assert found <= abs(n_sides - 4)


def even(lengths: list[int]) -> tuple[int, ...]:
    return (lengths[0] + sum(lengths) % 2, *lengths[1:])


@settings(max_examples=20)
@given(st.integers(0, 2**32), st.integers(1, 12))
def test_every_patch_has_a_fill_for_the_counts_that_are_chosen(
    source: PatternSource, seed: int, n_patches: int
) -> None:
    problem = glued(seed, n_patches, 0.2)
    found = solve_counts(problem, searches=0)
    stuck = {patch for one in found.stuck for patch in one.patches}
    lengths = problem.side_lengths(found.counts)
    for patch in sorted(set(range(n_patches)) - stuck):
        sides = lengths[problem.first_side[patch] : problem.first_side[patch + 1]].tolist()
        boundary = Boundary(sides) if len(sides) > 1 else Boundary.closed(sides[0])
        fill = next(iter(fills(source, boundary, limit=1)), None)
        assert fill is not None and fill.lengths == tuple(sides)


def test_a_vertex_of_valence_three_between_corners_is_not_looked_for() -> None:
    # Two neighbours longer than all others: the family has a fill with such a vertex.
    lengths = (6, 7, 3, 1, 2, 2, 1)
    assert is_regular_by_family(lengths) and not has_regular_fill(lengths)
