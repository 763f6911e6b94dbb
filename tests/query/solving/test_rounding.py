"""Flows with halves and matchings without: against trying, CP-SAT and Tutte's condition."""

from __future__ import annotations

import random
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.solving.systems import decide_matching
from query.solving.systems import make_systems
from tests.support.query.cases import Chords, brute_force, find_widths, is_feasible

Edges = list[tuple[int, int]]


def decide(w: int, edges: Edges, slack: list[int]) -> tuple[bool, list[int]]:
    """Is there a matching? And the cut, where not even halves would do."""
    joins = np.zeros((1, w, w), np.int32)
    for i, j in edges:
        joins[0, i, j] = joins[0, j, i] = 1
    systems = make_systems(np.ones((1, w), np.int32), joins)
    return decide_matching(systems, 0, np.array(slack, np.int32))


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
    found, cut = decide(w, edges, slack)
    assert found == expected
    chords = Chords.from_sides(w, edges)
    assert is_feasible(chords, chords.base_lengths() + np.array(slack)) == expected
    if cut:
        near = {j for e in edges for i, j in (e, e[::-1]) if i in cut}
        assert sum(slack[s] for s in cut) > sum(slack[s] for s in near)


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
    expected = is_feasible(chords, lengths, by_cpsat=True)
    assert is_feasible(chords, lengths) == expected
    assert decide(w, edges, slack)[0] == expected


def test_a_search_lists_all_where_few_of_many_branches_have_solutions() -> None:
    w, edges = odd_parts(3, 3, 1)
    chords = Chords.from_sides(w, edges)
    for slack in ([3] + [3] * 9, [1] + [3] * 9, [5, *[2, 2, 3] * 3]):
        lengths = (chords.base_lengths() + np.array(slack)).tolist()
        assert find_widths(chords, lengths) == brute_force(chords, lengths)
