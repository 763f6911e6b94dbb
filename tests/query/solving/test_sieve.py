"""What the sieve for systems is made of: claims, and few rows as all.

The tests of rust/query/src/solving/sieve.rs are of its lanes.
"""

from __future__ import annotations

import random

import numpy as np
import pytest
from numpy.typing import NDArray

from query.listing.table import get_strict_table
from query.request import PatternFilter
from query.solving import feasibility
from query.solving.systems import make_systems
from tests.query.solving.test_feasibility import boundaries
from tests.support.query.cases import find_orientations, small_class

#: Beyond this the sieve cuts off, as in rust/query/src/solving/sieve.rs.
MOST_SURPLUS = 127

Joins = NDArray[np.uint8]


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
