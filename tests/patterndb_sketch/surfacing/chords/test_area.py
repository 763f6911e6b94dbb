"""The area that a chord adds, and which chords are worth it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.chords import decompose, find_affordable, measure_added_area
from patterndb_sketch.surfacing.sampling import Loop
from patterndb_sketch.surfacing.tessellation import minimal_area


def wobbly(n: int, seed: int) -> np.ndarray:
    """A closed loop (n, 3) that bends in space."""
    rng = np.random.default_rng(seed)
    t = 2 * np.pi * np.arange(n) / n
    waves = rng.normal(size=(4, 3, 2))
    sum_of = sum(
        a[:, 0] * np.cos(k * t)[:, None] + a[:, 1] * np.sin(k * t)[:, None]
        for k, a in enumerate(waves, 1)
    )
    return np.asarray(sum_of)


def all_chords(n: int) -> np.ndarray:
    pairs = [(i, j) for i in range(n) for j in range(i + 2, n) if (i, j) != (0, n - 1)]
    return np.array(pairs, np.int64)


def c_band() -> Loop:
    """The outline of a band of even width along a C, such as the handle of a cup."""
    t = np.linspace(-2.4, 2.4, 40)
    c = np.c_[np.cos(t), np.sin(t)]
    near = np.c_[c, np.full(40, 0.15)]
    far = np.c_[c, np.full(40, -0.15)][::-1]
    points = np.concatenate([near, far])
    corners = np.zeros(80, bool)
    corners[[0, 39, 40, 79]] = True
    return Loop(points, corners, np.arange(80))


@given(n=st.integers(4, 24), seed=st.integers(0, 10_000))
def test_added_area_is_that_of_the_least_triangulations_of_both_sides(n: int, seed: int) -> None:
    points = wobbly(n, seed)
    chords = all_chords(n)
    whole = minimal_area(points)[1]
    added = measure_added_area(points, chords)
    for (i, j), more in zip(chords.tolist(), added, strict=True):
        sides = (points[i : j + 1], np.concatenate([points[j:], points[: i + 1]]))
        assert sum(minimal_area(side)[1] for side in sides) == pytest.approx(
            whole * (1 + more), rel=1e-9
        )
    # A triangulation of least area is made of chords that add nothing.
    triangles, _ = minimal_area(points)
    edges = {tuple(sorted((int(t[k]), int(t[(k + 1) % 3])))) for t in triangles for k in range(3)}
    for chord, more in zip(map(tuple, chords.tolist()), added, strict=True):
        assert more >= -1e-9
        if chord in edges:
            assert more <= 1e-9


@given(
    seed=st.integers(0, 1000),
    start=st.integers(0, 149),
    turned=st.booleans(),
    scale=st.sampled_from([1e-3, 1.0, 250.0]),
)
def test_what_is_worth_its_area_depends_on_the_shape_alone(
    seed: int, start: int, turned: bool, scale: float
) -> None:
    n = 150
    points = wobbly(n, seed)
    rng = np.random.default_rng(seed)
    chords = all_chords(n)[rng.choice(len(all_chords(n)), 12, replace=False)]
    chords = chords[np.lexsort(chords.T[::-1])]
    worth = find_affordable(points, chords)
    place = (np.arange(n) * (-1 if turned else 1) + start) % n
    moved = np.empty_like(points)
    moved[place] = points
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    named = np.sort(place[chords], axis=1)
    # A turned loop is measured at other vertices; the same ones if it only moved along itself.
    assert np.array_equal(find_affordable(moved, named), worth)
    assert np.array_equal(find_affordable(points * scale + 3.0, chords), worth)
    few = points[::3]
    own = all_chords(len(few))
    assert np.array_equal(find_affordable(few @ rotation.T * scale, own), find_affordable(few, own))


def test_a_bent_band_is_not_closed_off_by_flat_lids() -> None:
    loop = c_band()
    tip = loop.points[[0, 39, 40, 79]]
    across_the_mouth = np.array([[0, 39], [40, 79]])
    ribs = np.array([[10, 69], [20, 59], [30, 49]])
    assert np.linalg.norm(tip[0] - tip[1]) > 1.0
    assert not find_affordable(loop.points, across_the_mouth).any()
    assert find_affordable(loop.points, ribs).all()


def test_the_papers_way_takes_any_chord() -> None:
    loop = c_band()
    ours, papers = decompose(loop), decompose(loop, area_price=math.inf)
    assert papers.n_costly == 0
    assert len(ours.candidates) + ours.n_costly == len(papers.candidates)
    known = {tuple(chord) for chord in papers.candidates.tolist()}
    assert {tuple(chord) for chord in ours.candidates.tolist()} <= known


def test_more_is_affordable_at_a_higher_price_and_nothing_at_none() -> None:
    points = wobbly(40, 3)
    chords = all_chords(40)
    chosen = [
        set(np.flatnonzero(find_affordable(points, chords, price))) for price in (0, 0.3, 3, 1e9)
    ]
    assert all(a <= b for a, b in pairwise(chosen))
    assert len(chosen[0]) < len(chosen[-1])
    with pytest.raises(InvalidNetworkError, match="price"):
        find_affordable(points, chords, -0.1)
    with pytest.raises(InvalidNetworkError, match="price"):
        find_affordable(points, chords, float("nan"))


def test_loops_without_area_or_chords_are_no_trouble() -> None:
    line = np.zeros((6, 3))
    line[:, 0] = [0, 1, 2, 3, 2, 1]
    assert np.array_equal(measure_added_area(line, np.array([[1, 5], [2, 4]])), [0, 0])
    assert find_affordable(np.zeros((5, 3)), np.array([[0, 2]])).tolist() == [False]
    assert find_affordable(line, np.zeros((0, 2), np.int64)).shape == (0,)
