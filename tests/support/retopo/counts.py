"""Problems of counts that its tests share, and what must hold for any answer."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.retopo.counts import Counts, CountsProblem

Patches = list[list[list[int]]]


def glued(seed: int, n_patches: int, pins: float = 0.0, regularity: float = 1.0) -> CountsProblem:
    """Random polygons of 1 to 7 sides of 1 to 3 chains, glued at random: also to themselves."""
    chance = np.random.default_rng(seed)
    sizes = [
        [
            int(chance.choice([1, 1, 1, 2, 3]))
            for _ in range(chance.choice([1, 2, 3, 4, 4, 4, 5, 6, 7]))
        ]
        for _ in range(n_patches)
    ]
    n_doors = sum(map(sum, sizes))
    n_pairs = int(chance.integers(0, n_doors // 2 + 1))
    names = np.r_[np.repeat(np.arange(n_pairs), 2), np.arange(n_pairs, n_doors - n_pairs)]
    left = chance.permutation(names).tolist()
    patches = [[[left.pop() for _ in range(side)] for side in patch] for patch in sizes]
    n_chains = n_doors - n_pairs
    targets = np.exp(chance.uniform(-1, 2.3, n_chains))
    pinned = np.where(chance.random(n_chains) < pins, chance.integers(1, 7, n_chains), 0)
    return CountsProblem.of(targets, patches, pinned, regularity=regularity)


def grid(rows: int, columns: int) -> tuple[Patches, int]:
    """Cells of a grid; chains along x first, row by row, then those along y."""
    across = (rows + 1) * columns
    patches = [
        [
            [i * columns + j],
            [across + i * (columns + 1) + j + 1],
            [(i + 1) * columns + j],
            [across + i * (columns + 1) + j],
        ]
        for i in range(rows)
        for j in range(columns)
    ]
    return patches, across + rows * (columns + 1)


def lists(problem: CountsProblem) -> Patches:
    return [
        [
            problem.chains[problem.first_chain[k] : problem.first_chain[k + 1]].tolist()
            for k in range(problem.first_side[f], problem.first_side[f + 1])
        ]
        for f in range(problem.n_patches)
    ]


def refuse_unless_sound(problem: CountsProblem, counts: Counts) -> None:
    """Bounds and pins are kept; a patch that is odd or small is stuck, and rightly so."""
    n = counts.counts
    pinned = problem.pinned > 0
    assert np.array_equal(n[pinned], problem.pinned[pinned])
    assert np.all(n[~pinned] >= problem.least[~pinned])
    perimeters = problem.perimeters(n)
    odd = np.flatnonzero(perimeters % 2)
    assert len(odd) == sum(one.odd for one in counts.stuck)
    for one in counts.stuck:
        assert all(problem.pinned[chain] for chain in one.pinned)
        if one.odd:
            assert len(set(odd.tolist()) & set(one.patches)) == 1
            # Whatever the free chains within get, they count twice; none leads out.
            inside = np.isin(problem.ends, one.patches)
            assert not np.any((inside.sum(axis=1) == 1) & ~pinned)
            assert problem.pinned[inside.sum(axis=1) == 1].sum() % 2
            assert "odd" in str(one)
        else:
            assert set(problem.patch_chains(one.patches[0])) == set(one.pinned)
            assert perimeters[one.patches[0]] < 4
    small = {one.patches[0] for one in counts.stuck if not one.odd}
    assert set(np.flatnonzero((perimeters < 4) & (perimeters % 2 == 0)).tolist()) == small
    assert counts.cost == pytest.approx(float(problem.errors(n).sum()))
    assert counts.total == pytest.approx(problem.sum_costs(n))
    assert counts.bound <= counts.total + 1e-6
