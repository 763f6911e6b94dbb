"""The cut through a fishbone: the same as a maximum flow, brute force and a held row."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from ortools.graph.python.max_flow import SimpleMaxFlow

from patterndb._native.features.fishbone.cut import cheapest
from patterndb.geometry.points import Floats
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone import cut
from patterndb_sketch.features.fishbone.cut import hold_rows

#: Stands for an infinite capacity.
BIG = 1 << 40


def priced(costs: Floats, cross: Floats, rows: NDArray[np.int64]) -> float:
    """What a cut at these rows costs."""
    moved = np.abs(np.diff(rows))
    return float(costs[np.arange(len(rows)), rows].sum() + (cross * moved).sum())


def flow_value(costs: Floats, cross: Floats, *, one_way: bool) -> int:
    """The minimum cut of the graph of figure 5: rib edges down the columns, cross edges between.

    one_way: edges up the columns cannot be cut, so that each is cut once; otherwise rib edges
    have the same capacity both ways, as printed in the paper.
    """
    m, k = costs.shape
    graph = SimpleMaxFlow()
    source, sink = m * (k + 1), m * (k + 1) + 1
    for i in range(m):
        top = i * (k + 1)
        graph.add_arc_with_capacity(source, top, BIG)
        graph.add_arc_with_capacity(top + k, sink, BIG)
        for j in range(k):
            capacity = int(costs[i, j]) if np.isfinite(costs[i, j]) else BIG
            graph.add_arc_with_capacity(top + j, top + j + 1, capacity)
            graph.add_arc_with_capacity(top + j + 1, top + j, BIG if one_way else capacity)
            if i + 1 < m:
                graph.add_arc_with_capacity(top + j, top + k + 1 + j, int(cross[i]))
                graph.add_arc_with_capacity(top + k + 1 + j, top + j, int(cross[i]))
    assert graph.solve(source, sink) == graph.OPTIMAL
    return graph.optimal_flow()


def random_case(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Whole costs with rows missing at the ends of ribs, and some ribs held."""
    m, k = int(rng.integers(1, 13)), int(rng.integers(1, 16))
    costs = rng.integers(0, 1000, (m, k)).astype(float)
    cross = rng.integers(0, (10, 100, 1500)[rng.integers(3)], m - 1).astype(float)
    held = np.full(m, -1)
    for i in range(m):
        low = int(rng.integers(0, k))
        costs[i, : low // 2] = np.inf
        costs[i, k - int(rng.integers(0, k - low // 2)) :] = np.inf
        if rng.random() < 0.2:
            held[i] = rng.choice(np.flatnonzero(np.isfinite(costs[i])))
    return hold_rows(costs, held), cross


@pytest.mark.parametrize("one_way", [True, False])
def test_the_cut_costs_what_the_maximum_flow_is_worth(one_way: bool) -> None:
    """Exact dynamic programme over columns: equal to the minimum cut, whatever the cross edges'
    capacity, with padding and held rows."""
    rng = np.random.default_rng(7)
    for _ in range(200):
        costs, cross = random_case(rng)
        found = cut(costs, cross)
        assert found.cost == priced(costs, cross, found.rows)
        assert found.cost == flow_value(costs, cross, one_way=one_way)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_choice_of_rows_is_cheaper(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, k = int(rng.integers(1, 5)), int(rng.integers(1, 5))
    costs = rng.random((m, k)) * rng.integers(0, 2, (m, k))
    cross = rng.random(m - 1) * 0.5
    every = [priced(costs, cross, np.array(rows)) for rows in product(range(k), repeat=m)]
    found = cut(costs, cross)
    assert found.cost == pytest.approx(min(every), abs=1e-12)
    assert priced(costs, cross, found.rows) == pytest.approx(min(every), abs=1e-12)


def slow(costs: Floats, cross: Floats) -> float:
    """The same programme with every step tried, O(m k^2)."""
    best = costs[0]
    steps = np.abs(np.subtract.outer(np.arange(costs.shape[1]), np.arange(costs.shape[1])))
    for i in range(1, len(costs)):
        best = (best[None, :] + cross[i - 1] * steps).min(axis=1) + costs[i]
    return float(best.min())


def test_the_envelope_by_two_passes_is_the_one_of_all_steps() -> None:
    rng = np.random.default_rng(3)
    for _ in range(30):
        costs, cross = rng.random((40, 60)), rng.random(39) * 0.1
        rows, cost = cheapest(costs, cross)
        assert cost == pytest.approx(slow(costs, cross), abs=1e-12)
        assert cost == pytest.approx(priced(costs, cross, rows), abs=1e-12)


def test_held_rows_are_hit_exactly() -> None:
    """A constraint costs 0 at its sample and infinitely much elsewhere in its column."""
    rng = np.random.default_rng(5)
    costs = rng.random((30, 50))
    rows = np.full(30, -1)
    rows[[0, 11, 29]] = [49, 0, 25]
    found = cut(hold_rows(costs, rows), 2.0).rows
    assert found[[0, 11, 29]].tolist() == [49, 0, 25]


def test_dear_cross_edges_keep_one_row_and_free_ones_none() -> None:
    rng = np.random.default_rng(9)
    costs = rng.random((20, 30))
    assert len(set(cut(costs, 100.0).rows.tolist())) == 1
    assert (cut(costs, 0.0).rows == costs.argmin(axis=1)).all()


def test_what_cannot_be_cut_is_told() -> None:
    with pytest.raises(InvalidFeatureError, match="rib 1 may be cut nowhere"):
        cut([[1.0, 2.0], [np.inf, np.inf]], 0.1)
    with pytest.raises(InvalidFeatureError, match="not negative"):
        cut([[1.0, -2.0]], 0.1)
    with pytest.raises(InvalidFeatureError, match="not negative"):
        cut([[1.0, np.nan]], 0.1)
    with pytest.raises(InvalidFeatureError, match="ribs, samples"):
        cut(np.zeros((0, 3)), 0.1)
