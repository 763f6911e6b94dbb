"""The sieve for systems: what it drops has no solution, and it drops what its conditions say."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb._native.query.solving.feasibility import sift_systems, state_claims
from patterndb.core.halfedge import Int32Array
from query.listing.table import get_strict_table
from query.request import PatternFilter
from query.solving import feasibility
from query.solving.feasibility import LANES, Lanes
from query.solving.systems import Systems, make_systems
from tests.query.solving.test_feasibility import boundaries
from tests.support.query.cases import Chords, brute_force, find_orientations, small_class

#: Beyond these the sieve cuts off, as in rust/query/src/solving/sieve.rs.
MOST_SURPLUS, LONGEST_BASE = 127, 15

Joins = NDArray[np.uint8]


def passing_lanes(systems: Systems, lengths: Int32Array) -> NDArray[np.bool_]:
    """(rows, lanes) bool: what passes the sieve."""
    lanes = Lanes.of_lengths(lengths)
    stated = np.zeros((len(systems.claimant), len(lanes.marks) * LANES), np.uint8)
    every = np.arange(len(stated), dtype=np.int32)
    state_claims(systems, np.ascontiguousarray(lanes.lengths.T), every, 0, stated)
    found = np.zeros((len(systems.base), len(lanes.lengths)), np.bool_)
    sift_systems(systems, lanes, stated.view(np.int64), found)
    return found[:, lanes.lane_of]


def meets_conditions(base: Sequence[int], joins: Joins, lengths: Sequence[int]) -> bool:
    """The two conditions, side by side."""
    slack = [a - b for a, b in zip(lengths, base, strict=True)]
    near = [np.flatnonzero(row).tolist() for row in joins]
    return min(slack) >= 0 and all(
        i in near[i] or slack[i] <= sum(slack[j] for j in near[i]) for i in range(len(base))
    )


def draw_joins(chance: random.Random, w: int) -> Joins:
    """The polychords between w sides, by numbers; at least one on each."""
    joins = np.zeros((w, w), np.uint8)
    for i in range(w):
        for j in range(i, w):
            if chance.random() < (0.1 if i == j else 0.3):
                joins[i, j] = joins[j, i] = chance.randint(1, 2)
    for i in range(w):
        if not joins[i].any():
            j = chance.randrange(w)
            joins[i, j] = joins[j, i] = 1
    return joins


def base_of(joins: Joins) -> list[int]:
    return (joins.sum(axis=1, dtype=int) + np.diagonal(joins)).tolist()


@settings(max_examples=150, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_nothing_that_has_widths_is_dropped(seed: int) -> None:
    chance = random.Random(seed)
    w = chance.randint(1, 5)
    joins = np.array([draw_joins(chance, w) for _ in range(chance.randint(1, 4))])
    base = np.array([base_of(one) for one in joins], np.int32)
    lanes = [[chance.randint(1, 8) for _ in range(w)] for _ in range(chance.randint(1, 40))]
    passing = passing_lanes(make_systems(base, joins), np.array(lanes, np.int32))
    for row, one in enumerate(joins):
        pairs = np.argwhere(np.triu(one)).tolist()
        sides = [pair for pair in pairs for _ in range(one[tuple(pair)])]
        chords = Chords.from_sides(w, sides)
        assert chords.base_lengths().tolist() == base[row].tolist()
        for lane, lengths in enumerate(lanes):
            assert passing[row, lane] == meets_conditions(base[row].tolist(), one, lengths)
            # Trying takes long where there is much to try.
            if sum(lengths) <= 16:
                assert passing[row, lane] or not brute_force(chords, lengths)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(st.integers(0, 2**32))
def test_long_sides_and_many_lanes_pass_where_the_conditions_hold(seed: int) -> None:
    """Of what is cut off more may pass, never less; what is not is told exactly."""
    chance = random.Random(seed)
    w = chance.randint(1, 20)
    joins = np.array([draw_joins(chance, w) for _ in range(3)])
    wide = chance.choice([1, 1, 40, 1000])
    base = np.array([base_of(one) for one in joins], np.int32) * chance.randint(1, wide)
    longest = chance.choice([6, 60, 2000])
    lanes = [[chance.randint(1, longest) for _ in range(w)] for _ in range(2 * w)]
    # Lengths that the first can meet, and nearly.
    for _ in range(w):
        widths = np.array([chance.randint(0, longest // 4) for _ in range(w * w)]).reshape(w, w)
        widths = np.triu(widths) * (joins[0] > 0)
        lengths = base[0] + widths.sum(axis=0) + widths.sum(axis=1)
        lengths[chance.randrange(w)] += chance.choice([0, 0, 1, -1])
        lanes.append(np.clip(lengths, 1, None).tolist())
    passing = passing_lanes(make_systems(base, joins), np.array(lanes, np.int32))
    for row, one in enumerate(joins):
        for lane, lengths in enumerate(lanes):
            holds = meets_conditions(base[row].tolist(), one, lengths)
            assert passing[row, lane] or not holds
            short = sum(lengths) < MOST_SURPLUS and base[row].sum() < MOST_SURPLUS
            if short and base[row].max() <= LONGEST_BASE:
                assert passing[row, lane] == holds


@pytest.mark.parametrize("w", [1, 3, 9, 70])
def test_claims_are_shared_and_no_two_are_equal(w: int) -> None:
    chance = random.Random(w)
    # More than there is room for at first.
    joins = np.array([draw_joins(chance, w) for _ in range(150 if w < 70 else 5)])
    base = np.array([base_of(one) for one in joins], np.int32)
    made = make_systems(base, joins)
    graphs = made
    told = [
        (int(s), tuple(graphs.near[a:b].tolist()))
        for s, a, b in zip(
            made.claimant, graphs.near_first[:-1], graphs.near_first[1:], strict=True
        )
    ]
    assert len(set(told)) == len(told)
    assert np.unique(graphs.claim).tolist() == list(range(len(told)))
    for row, one in enumerate(joins):
        for s in range(w):
            near = np.flatnonzero(one[s])
            assert told[graphs.claim[row, s]] == (s, tuple(near.tolist()))
            more = int(base[row][near].sum() - base[row, s])
            assert made.surplus[row, s] == (0 if one[s, s] else min(more + 1, MOST_SURPLUS))


@pytest.mark.parametrize("n_sides", [1, 5, 6, 9])
def test_few_rows_answer_as_all(n_sides: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Few rows have only their own claims stated, many have all, by several threads."""
    monkeypatch.setattr(feasibility, "CLAIMS_PER_THREAD", 3)
    monkeypatch.setattr(feasibility, "ROWS_PER_THREAD", 50)
    patterns = small_class(n_sides)
    table = get_strict_table(patterns)
    for boundary in boundaries(n_sides, random.Random(7), 4, 6):
        rows = PatternFilter().choose_rows(patterns, boundary)
        whole = find_orientations(table, boundary, rows, threads=3)
        for at in range(0, len(rows), 5):
            few = find_orientations(table, boundary, rows[at : at + 1])
            assert few.tolist() == whole[at : at + 1].tolist()
