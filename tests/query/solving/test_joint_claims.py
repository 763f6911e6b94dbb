"""Joint claims: what they refuse has no solution with halves, and they refuse all that has none."""

from __future__ import annotations

import random
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.solving.jointclaims import is_refused, sum_needs
from patterndb.core.halfedge import Int32Array
from query.request import PatternFilter
from query.solving import feasibility
from query.solving.systems import MOST_SIDES, Systems, make_systems
from tests.query.solving.test_feasibility import boundaries
from tests.query.solving.test_sieve import base_of, draw_joins
from tests.support.query.cases import small_class

#: As in rust/query/src/solving/jointclaims.rs: claims of a graph, sums of five sides three times.
MOST_CLAIMS, TABLES, SUMS = 32, 3, 32


def refuses(systems: Systems, row: int, need: list[int]) -> bool:
    needs = np.zeros(MOST_SIDES, np.int32)
    needs[: len(need)] = need
    first, last = systems.joint_first[systems.graph[row] :][:2].tolist()
    sums = np.zeros(TABLES * SUMS, np.int32)
    sum_needs(needs, sums)
    return is_refused(first, last, systems.joint, sums)


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


@settings(max_examples=200, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_they_refuse_what_sets_of_sides_refuse(seed: int) -> None:
    chance = random.Random(seed)
    w = chance.randint(2, 8)
    joins = np.array([draw_joins(chance, w) for _ in range(6)])
    joins[3:] = joins[:3]
    base = np.array([base_of(one) for one in joins], np.int32)
    systems = make_systems(base, joins, jointly=True)
    assert systems.graph[3:].tolist() == systems.graph[:3].tolist()
    for row, one in enumerate(joins):
        near = [set(np.flatnonzero(line).tolist()) for line in one]
        first, last = systems.joint_first[systems.graph[row] :][:2].tolist()
        for claim in systems.joint[first:last].tolist():
            some = [s for s in range(w) if claim >> s & 1]
            around = {s for s in range(w) if claim >> (MOST_SIDES + s) & 1}
            assert len(some) > 1
            assert around == set[int]().union(*(near[s] for s in some))
            assert not around & set(some)
        for _ in range(20):
            need = [chance.choice([0, 1, 2, 3, chance.randint(0, 60)]) for _ in range(w)]
            alone = all(s in near[s] or need[s] <= sum(need[t] for t in near[s]) for s in range(w))
            broken = list_breaking(near, need)
            if refuses(systems, row, need):
                assert broken
            elif alone and last - first < MOST_CLAIMS:
                # The sieve asks what single sides claim.
                assert not broken


@pytest.mark.parametrize("w", [1, 12, MOST_SIDES, MOST_SIDES + 1, 20])
def test_graphs_have_claims_up_to_a_number_of_sides(w: int) -> None:
    chance = random.Random(w)
    joins = np.array([draw_joins(chance, w) for _ in range(40)])
    base = np.array([base_of(one) for one in joins], np.int32)
    systems = make_systems(base, joins, jointly=True)
    told = np.diff(systems.joint_first)
    assert len(systems.graph) == 40
    if 1 < w <= MOST_SIDES:
        assert told.min() > 0
        assert told.max() == MOST_CLAIMS
    else:
        assert told.tolist() == [0] * len(told)


@pytest.mark.parametrize("n_sides", [4, 5, 6, 9])
def test_answers_are_those_without_them(n_sides: int, monkeypatch: pytest.MonkeyPatch) -> None:
    patterns = small_class(n_sides)
    made = make_systems(patterns.lengths, patterns.joins, jointly=True)
    assert len(made.joint)
    for boundary in boundaries(n_sides, random.Random(11), 6, 9):
        rows = PatternFilter().choose_rows(patterns, boundary)
        found: list[Int32Array] = []
        for joint in (False, True):
            with monkeypatch.context() as patch:
                if joint:
                    patch.setattr(feasibility, "systems_of", lambda _: made)
                found += [
                    feasibility.find_feasible_rows(patterns, boundary, rows),
                    feasibility.find_feasible_orientations(patterns, boundary, rows),
                ]
        assert found[0].tolist() == found[2].tolist()
        assert found[1].tolist() == found[3].tolist()
