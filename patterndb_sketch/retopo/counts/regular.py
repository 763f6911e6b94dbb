"""Counts that leave every four-sided patch a regular grid: one integer program over the network.

A network of the separatrices of a cross field has four-sided patches alone, and counts for which
opposite sides of all of them agree leave no irregular vertex but the field's own. The program of
least errors is small, and nearly a network flow, so that it is solved at once where parity alone is
not (Lyon, Campen, Bommes and Kobbelt 2019, "Parametrization Quantization with Free Boundaries",
solve another for the same end).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import (
    Bounds,
    LinearConstraint,
    milp,
)
from scipy.sparse import coo_array

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts.problem import CountsProblem

#: Nodes of the search at most, and how near to the best it may stop: the same on any machine.
MOST_NODES, GAP = 30, 0.03

#: What a four-sided patch costs whose opposite sides do not agree: it has a pair of irregular
#: vertices at least; and how many edges they may differ by.
IRREGULAR, MOST_GAP = 6.0, 8.0

#: No count is more than so many times its target, and some edges more.
MOST, MORE = 4.0, 12


def solve_regular_counts(problem: CountsProblem) -> Int32Array | None:
    """(c,) counts of least error with which opposite sides of every four-sided patch agree.

    Other patches get an even perimeter, no side longer than the others together. Chains get their
    least, and pinned ones their count. None where there are no such counts, or none were found.
    """
    n, patches = problem.n_chains, problem.n_patches
    if not n:
        return np.zeros(0, np.int32)
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    low: list[float] = []
    high: list[float] = []

    def constrain(terms: list[tuple[int, float]], least: float, most: float) -> None:
        for column, value in terms:
            rows.append(len(low))
            columns.append(column)
            values.append(value)
        low.append(least)
        high.append(most)

    def side(k: int, value: float) -> list[tuple[int, float]]:
        return [(int(c), value) for c in _chains_of_side(problem, k)]

    # By patch half its perimeter, and is it irregular?
    half, irregular = 2 * n, 2 * n + patches
    for f in range(patches):
        first, last = int(problem.first_side[f]), int(problem.first_side[f + 1])
        around = [term for k in range(first, last) for term in side(k, 1.0)]
        constrain([*around, (half + f, -2.0)], 0.0, 0.0)
        if last - first == 4:
            for k in (first, first + 1):
                gap = side(k, 1.0) + side(k + 2, -1.0)
                constrain([*gap, (irregular + f, -MOST_GAP)], -np.inf, 0.0)
                constrain([*gap, (irregular + f, MOST_GAP)], 0.0, np.inf)
        elif last - first > 2:
            for k in range(first, last):
                constrain(around + side(k, -2.0), 0.0, np.inf)
    for c in range(n):
        # The error is at least the count less the target, and the other way round.
        constrain([(n + c, 1.0), (c, -1.0)], -problem.targets[c], np.inf)
        constrain([(n + c, 1.0), (c, 1.0)], problem.targets[c], np.inf)
    total = 2 * (n + patches)
    matrix = coo_array((values, (rows, columns)), (len(low), total)).tocsr()
    least = np.concatenate([problem.least, np.zeros(n), np.full(patches, 2.0), np.zeros(patches)])
    most = np.full(total, np.inf)
    most[:n] = np.maximum(np.ceil(MOST * problem.targets) + MORE, least[:n])
    most[irregular:] = 1.0
    held = np.flatnonzero(problem.pinned)
    least[held] = most[held] = problem.pinned[held]
    cost = np.concatenate(
        [np.zeros(n), problem.weights, np.zeros(patches), np.full(patches, IRREGULAR)]
    )
    whole = np.ones(total)
    whole[n : 2 * n] = 0.0
    found = milp(
        cost,
        integrality=whole,
        bounds=Bounds(least, most),  # pyright: ignore[reportArgumentType]
        constraints=LinearConstraint(matrix, np.array(low), np.array(high)),  # pyright: ignore[reportArgumentType]
        options={"node_limit": MOST_NODES, "mip_rel_gap": GAP},
    )
    if found.x is None:
        return None
    return np.rint(found.x[:n]).astype(np.int32)


def _chains_of_side(problem: CountsProblem, k: int) -> Int32Array:
    return problem.chains[problem.first_chain[k] : problem.first_chain[k + 1]]
