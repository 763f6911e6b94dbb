"""Which side lengths have a regular fill: inequalities against the database and its family."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.counts import (
    CountsProblem,
    find_misjudged_patches,
    has_cheap_fill,
    is_cheap_by_family,
    solve_counts,
)
from query.boundary import Boundary
from query.engine import PatternSource, fills
from query.listing.construction import FamilyLookup
from tests.support.retopo.counts import glued, lists, refuse_unless_sound


@pytest.mark.parametrize(("n_sides", "longest"), [(2, 30), (3, 14), (4, 7), (5, 5), (6, 3)])
def test_up_to_six_sides_the_inequalities_are_the_family_s_answer(
    n_sides: int, longest: int
) -> None:
    for lengths in product(range(1, longest + 1), repeat=n_sides):
        # Turned and mirrored they are the same question.
        if lengths[0] == max(lengths) and lengths[1] >= lengths[-1] and sum(lengths) >= 4:
            assert has_cheap_fill(lengths) == is_cheap_by_family(lengths), lengths


@settings(max_examples=200)
@given(st.integers(3, 6), st.data())
def test_so_they_are_for_long_sides(n_sides: int, data: st.DataObject) -> None:
    lengths = even(data.draw(st.lists(st.integers(1, 60), min_size=n_sides, max_size=n_sides)))
    assert has_cheap_fill(lengths) == is_cheap_by_family(lengths)


@settings(max_examples=100)
@given(st.integers(7, 8), st.data())
def test_for_seven_and_eight_they_lie_between_strict_fills_and_all(
    n_sides: int, data: st.DataObject
) -> None:
    lengths = even(data.draw(st.lists(st.integers(1, 12), min_size=n_sides, max_size=n_sides)))
    strict = FamilyLookup().count(Boundary(lengths), strict=True)
    assert has_cheap_fill(lengths) or strict is None or strict > n_sides - 4
    assert is_cheap_by_family(lengths) or not has_cheap_fill(lengths)


@settings(max_examples=30)
@given(st.integers(1, 12), st.data())
def test_a_query_finds_what_they_promise(
    source: PatternSource, n_sides: int, data: st.DataObject
) -> None:
    lengths = even(data.draw(st.lists(st.integers(2, 9), min_size=n_sides, max_size=n_sides)))
    if sum(lengths) < 4 or not has_cheap_fill(lengths):
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
    found = solve_counts(problem, n_balls=0)
    stuck = {patch for one in found.stuck for patch in one.patches}
    lengths = problem.side_lengths(found.counts)
    for patch in sorted(set(range(n_patches)) - stuck):
        sides = lengths[problem.first_side[patch] : problem.first_side[patch + 1]].tolist()
        boundary = Boundary(sides) if len(sides) > 1 else Boundary.closed(sides[0])
        fill = next(iter(fills(source, boundary, limit=1)), None)
        assert fill is not None and fill.lengths == tuple(sides)


def test_a_rule_of_the_caller_s_serves_whole_networks() -> None:
    problem = glued(3, 25)
    asked = CountsProblem.of(problem.targets, lists(problem), cheap=is_cheap_by_family)
    found = solve_counts(asked, n_balls=2)
    refuse_unless_sound(asked, found)
    by_hand = [
        f
        for f, sides in enumerate(lists(problem))
        if not is_cheap_by_family(tuple(int(sum(found.counts[c] for c in side)) for side in sides))
    ]
    assert found.irregular.tolist() == by_hand
    assert found.narrowly == ()


def test_patches_that_are_judged_narrowly_are_told() -> None:
    # Two neighbours longer than all others: the family has a fill with a vertex of valence 3.
    lengths = (6, 7, 3, 1, 2, 2, 1)
    assert is_cheap_by_family(lengths) and not has_cheap_fill(lengths)
    problem = CountsProblem.of(lengths, [[[k] for k in range(7)]], lengths)
    assert solve_counts(problem).irregular.tolist() == [0]
    assert (
        solve_counts(problem).narrowly == find_misjudged_patches(problem, np.array(lengths)) == (0,)
    )
