"""Hall conditions: they reject what has no solution with halves, and nothing else."""

from __future__ import annotations

import random
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from query.listing.table import get_strict_table
from query.request import PatternFilter
from query.solving import feasibility
from query.solving.systems import make_systems
from tests.query.solving.test_feasibility import boundaries
from tests.query.solving.test_sieve import base_of, draw_joins
from tests.support.query.cases import find_orientations, find_rows, small_class

#: As in rust/query/src/solving/hall_conditions.rs: conditions of a graph, and its most sides.
MOST_CONDITIONS, MOST_SIDES = 32, 15


def list_breaking(near: list[set[int]], need: list[int]) -> list[tuple[int, ...]]:
    """The sets of two sides and more, none joined to another or itself, that need more than their
    neighbours."""
    return [
        some
        for size in range(2, len(near) + 1)
        for some in combinations(range(len(near)), size)
        if not set[int]().union(*(near[s] for s in some)) & set(some)
        and sum(need[s] for s in some)
        > sum(need[s] for s in set[int]().union(*(near[s] for s in some)))
    ]


def breaks(need: list[int], condition: int) -> bool:
    """Do the sides of a condition need more than their neighbours? As ``Sums`` in Rust."""
    some = sum(n for s, n in enumerate(need) if condition >> s & 1)
    return some > sum(n for s, n in enumerate(need) if condition >> (MOST_SIDES + s) & 1)


@settings(max_examples=200, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_they_reject_what_sets_of_sides_reject(seed: int) -> None:
    chance = random.Random(seed)
    w = chance.randint(2, 8)
    joins = np.array([draw_joins(chance, w) for _ in range(6)])
    joins[3:] = joins[:3]
    base = np.array([base_of(one) for one in joins], np.int32)
    systems = make_systems(base, joins, with_hall=True)
    assert systems.graph[3:].tolist() == systems.graph[:3].tolist()
    for row, one in enumerate(joins):
        near = [set(np.flatnonzero(line).tolist()) for line in one]
        first, last = systems.hall_first[systems.graph[row] :][:2].tolist()
        for condition in systems.hall[first:last].tolist():
            some = [s for s in range(w) if condition >> s & 1]
            around = {s for s in range(w) if condition >> (MOST_SIDES + s) & 1}
            assert len(some) > 1
            assert around == set[int]().union(*(near[s] for s in some))
            assert not around & set(some)
        for _ in range(20):
            need = [chance.choice([0, 1, 2, 3, chance.randint(0, 60)]) for _ in range(w)]
            alone = all(s in near[s] or need[s] <= sum(need[t] for t in near[s]) for s in range(w))
            broken = list_breaking(near, need)
            if any(breaks(need, c) for c in systems.hall[first:last].tolist()):
                assert broken
            elif alone and last - first < MOST_CONDITIONS:
                # The sieve has the conditions of single sides.
                assert not broken


@pytest.mark.parametrize("w", [1, 12, MOST_SIDES, MOST_SIDES + 1, 20])
def test_graphs_have_conditions_up_to_a_number_of_sides(w: int) -> None:
    chance = random.Random(w)
    joins = np.array([draw_joins(chance, w) for _ in range(40)])
    base = np.array([base_of(one) for one in joins], np.int32)
    systems = make_systems(base, joins, with_hall=True)
    told = np.diff(systems.hall_first)
    assert len(systems.graph) == 40
    if 1 < w <= MOST_SIDES:
        assert told.min() > 0
        assert told.max() == MOST_CONDITIONS
    else:
        assert told.tolist() == [0] * len(told)


@pytest.mark.parametrize("n_sides", [4, 5, 6, 9])
def test_answers_are_those_without_them(n_sides: int, monkeypatch: pytest.MonkeyPatch) -> None:
    patterns = small_class(n_sides)
    table = get_strict_table(patterns)
    made = make_systems(patterns.lengths, patterns.joins, with_hall=True)
    assert len(made.hall)
    for boundary in boundaries(n_sides, random.Random(11), 6, 9):
        rows = PatternFilter().choose_rows(patterns, boundary)
        found: list[list[object]] = []
        for with_hall in (False, True):
            with monkeypatch.context() as patch:
                if with_hall:
                    patch.setattr(feasibility, "systems_of", lambda _: made)
                found += [
                    find_rows(table, boundary, rows).tolist(),
                    find_orientations(table, boundary, rows).tolist(),
                ]
        assert found[:2] == found[2:]
