"""Flows with halves and matchings without: against trying, CP-SAT and Tutte's condition."""

from __future__ import annotations

import random
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.solving.matching import is_matchable, is_soluble
from patterndb.core.halfedge import Int32Array
from query.solving import cpsat, solve
from query.solving.systems import Chords, make_systems
from tests.support.query.cases import brute_force

Edges = list[tuple[int, int]]

#: Rows of the scratch in which a cut is found.
COPY_BY, QUEUE = 3, 4


def decide(w: int, edges: Edges, slack: list[int]) -> tuple[int, Int32Array, Int32Array]:
    """The result of ``matchable``, its flow or matching, and its scratch."""
    joins = np.zeros((1, w, w), np.int32)
    for i, j in edges:
        joins[0, i, j] = joins[0, j, i] = 1
    graphs = make_systems(np.ones((1, w), np.int32), joins).graphs
    flow = np.zeros((w, w), np.int32)
    scratch = np.empty((5, w), np.int32)
    cut = is_matchable(np.array(slack, np.int32), 0, *graphs, flow, scratch)
    return cut, flow, scratch


def tutte(w: int, edges: Edges, slack: list[int]) -> bool:
    """Is there a perfect b-matching, by the condition on every set of sides?

    For every set U of sides, the slack of U is at least that of the sides that U isolates,
    plus one for every other component of odd slack (Tutte 1952).
    """
    near = [{j for e in edges for i, j in (e, e[::-1]) if i == s} for s in range(w)]
    for size in range(w + 1):
        for chosen in combinations(range(w), size):
            left = set(range(w)) - set(chosen)
            asked = 0
            while left:
                component = {left.pop()}
                grown = True
                while grown:
                    more = {t for s in component for t in near[s]} & left
                    component |= more
                    left -= more
                    grown = bool(more)
                total = sum(slack[s] for s in component)
                (first, *others) = component
                asked += total % 2 if others or first in near[first] else total
            if sum(slack[s] for s in chosen) < asked:
                return False
    return True


def check(w: int, edges: Edges, slack: list[int], expected: bool) -> None:
    cut, flow, scratch = decide(w, edges, slack)
    assert (cut == 0) == expected
    m = len(edges)
    class_i, class_j = np.array(edges, np.int32).reshape(-1, 2).T.copy()
    need = np.array(slack, np.int32)
    # Twice the same class, and one that is closed and would help.
    helpful = np.r_[class_i, class_i[:1], 0].astype(np.int32)
    helped = np.r_[class_j, class_j[:1], 0].astype(np.int32)
    closed = np.array([False] * (m + 1) + [True])
    assert is_soluble(need, helpful, helped, m + 2, closed) == expected
    if cut > 0:
        sides = scratch[QUEUE, :cut].tolist()
        near = {j for e in edges for i, j in (e, e[::-1]) if i in sides}
        assert near == set(np.flatnonzero(scratch[COPY_BY] >= 0).tolist())
        assert sum(slack[s] for s in sides) > sum(slack[s] for s in near)
    if cut == 0:
        allowed = {e for i, j in edges for e in ((i, j), (j, i))}
        assert (flow >= 0).all()
        assert all(flow[i, j] == 0 or (i, j) in allowed for i in range(w) for j in range(w))
        # A matching after rounding, else a flow; they count what a side sends to itself
        # once and twice.
        is_flow = flow.sum(axis=0).tolist() == slack and flow.sum(axis=1).tolist() == slack
        is_matching = (flow == flow.T).all()
        is_matching &= (flow.sum(axis=1) + np.diagonal(flow)).tolist() == slack
        assert is_flow or is_matching


def random_graph(chance: random.Random, w: int) -> Edges:
    share = chance.choice([0.2, 0.35, 0.6])
    loops = chance.choice([0.0, 0.1])
    return [
        (i, j)
        for i in range(w)
        for j in range(i, w)
        if chance.random() < (loops if i == j else share)
    ]


@settings(max_examples=200, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_matchings_are_found_exactly_where_tutte_says(seed: int) -> None:
    chance = random.Random(seed)
    w = chance.randint(1, 7)
    edges = random_graph(chance, w)
    slack = [0] * w
    if edges and chance.random() < 0.7:
        for _ in range(chance.randint(1, 12)):
            for s in chance.choice(edges):
                slack[s] += 1
        for _ in range(chance.choice([0, 0, 2])):
            slack[chance.randrange(w)] += 1
    else:
        slack = [chance.randint(0, 4) for _ in range(w)]
    if edges:
        check(w, edges, slack, tutte(w, edges, slack))


def odd_parts(parts: int, size: int, hub: int) -> tuple[int, Edges]:
    """Complete graphs of an odd number of sides, each joined to the same ``hub`` sides."""
    edges: Edges = []
    for p in range(parts):
        part = range(hub + p * size, hub + (p + 1) * size)
        edges += combinations(part, 2)
        edges += [(h, part[0]) for h in range(hub)]
    return hub + parts * size, edges


@pytest.mark.parametrize(("parts", "size", "hub"), [(3, 3, 1), (2, 3, 1), (2, 5, 0), (4, 3, 2)])
@pytest.mark.parametrize("wide", [1, 2, 3])
def test_odd_parts_need_as_many_units_of_the_hub(
    parts: int, size: int, hub: int, wide: int
) -> None:
    w, edges = odd_parts(parts, size, hub)
    for units in range(parts + 2):
        slack = [0] * w
        for u in range(units if hub else 0):
            slack[u % hub] += 1
        slack[hub:] = [wide] * (w - hub)
        check(w, edges, slack, tutte(w, edges, slack))


@pytest.mark.parametrize("seed", range(6))
def test_large_systems_are_decided_as_cpsat_does(seed: int) -> None:
    chance = random.Random(seed)
    w = 34
    ring = [(s, (s + 1) % w) for s in range(w)]
    far = [chance.sample(range(w), 2) for _ in range(51)]
    edges = sorted({*ring, *((min(pair), max(pair)) for pair in far)})
    chords = Chords.from_sides(w, edges)
    slack = [0] * w
    for _ in range(40):
        for s in chance.choice(edges):
            slack[s] += chance.choice([1, 1, 6])
    slack[0] += sum(slack) % 2
    lengths = chords.base_lengths() + np.array(slack)
    expected = cpsat.is_feasible(chords, lengths)
    assert solve.is_feasible(chords, lengths) == expected
    assert (decide(w, edges, slack)[0] == 0) == expected


def test_a_search_lists_all_where_few_of_many_branches_have_solutions() -> None:
    w, edges = odd_parts(3, 3, 1)
    chords = Chords.from_sides(w, edges)
    for slack in ([3] + [3] * 9, [1] + [3] * 9, [5, *[2, 2, 3] * 3]):
        lengths = (chords.base_lengths() + np.array(slack)).tolist()
        rows = [tuple(r) for r in solve.find_solutions(chords, lengths, None).widths.tolist()]
        assert rows == brute_force(chords, lengths)
