"""The search finds the least cost, solving every sub-cycle once."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.chords import (
    MOST_COUNTED,
    count_subproblems,
    decompose,
    find_candidates,
    find_endpoints,
    keep_within_budget,
    search_cuts,
)
from patterndb_sketch.surfacing.sampling import Loop
from tests.support.surfacing.chords import (
    CLOSE,
    SHAPES,
    Recursion,
    all_costs,
    helix,
    parted,
    perimeter,
    random_chords,
    random_loop,
    ring,
    spread,
)

SEEDS = st.integers(0, 2**32 - 1)


def pieces_cost(points: np.ndarray, pieces: tuple[np.ndarray, ...]) -> float:
    return sum(spread(points[piece]) / spread(points) for piece in pieces)


def is_decomposition(n: int, chords: np.ndarray, pieces: tuple[np.ndarray, ...]) -> None:
    """Do the pieces, all in the loop's sense, use each edge once and each chord twice?"""
    assert len(pieces) == len(chords) + 1
    steps = [
        (int(a), int(b)) for piece in pieces for a, b in zip(piece, np.roll(piece, -1), strict=True)
    ]
    both = [tuple(chord) for chord in chords.tolist()] + [(j, i) for i, j in chords.tolist()]
    assert sorted(steps) == sorted([(i, (i + 1) % n) for i in range(n)] + both)
    for piece in pieces:
        assert piece.dtype == np.int64
        # Once round: positions rise but for one step.
        assert sum(b < a for a, b in zip(piece, np.roll(piece, -1), strict=True)) == 1


@given(SEEDS, st.integers(4, 14), st.integers(0, 8), st.sampled_from([0.0, 0.02, 0.1, 0.6]))
def test_it_equals_brute_force_over_all_sets_of_chords_and_orders_of_cuts(
    seed: int, n: int, m: int, alpha: float
) -> None:
    rng = np.random.default_rng(seed)
    points, chords = random_loop(rng, n), random_chords(rng, n, m)
    costs = list(all_costs(points, tuple(range(n)), [tuple(c) for c in chords.tolist()], alpha))
    found = search_cuts(points, chords, alpha)
    least = min(cost for cost, _ in costs)
    assert found.cost == pytest.approx(least, abs=CLOSE)
    assert len(found.chosen) in {cuts for cost, cuts in costs if cost <= least + CLOSE}
    is_decomposition(n, chords[found.chosen], found.pieces)


@given(SEEDS, st.integers(4, 30), st.integers(0, 16), st.sampled_from([0.0, 0.05, 0.1, 0.6]))
@settings(max_examples=40)
def test_it_equals_the_recursion_and_solves_each_of_its_sub_problems_once(
    seed: int, n: int, m: int, alpha: float
) -> None:
    rng = np.random.default_rng(seed)
    points, chords = random_loop(rng, n), random_chords(rng, n, m)
    slow = Recursion(points, chords, alpha)
    found = search_cuts(points, chords, alpha)
    assert found.cost == pytest.approx(slow.cost, abs=CLOSE)
    assert found.n_subproblems == count_subproblems(n, chords) == len(slow.memo)
    is_decomposition(n, chords[found.chosen], found.pieces)
    if alpha == 0.0:
        assert found.cost == pytest.approx(pieces_cost(points, found.pieces), abs=CLOSE)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.4])
def test_cycles_of_candidates_are_solved_as_by_the_recursion(name: str, alpha: float) -> None:
    loop = ring(SHAPES[name]())
    found = decompose(loop, alpha)
    slow = Recursion(loop.points, found.candidates, alpha)
    assert found.cost == pytest.approx(slow.cost, abs=CLOSE)
    assert found.n_subproblems == len(slow.memo)
    is_decomposition(len(loop.points), found.chords, found.pieces)
    # Chords are few where they cost; where they are free, the last may gain next to nothing.
    if alpha:
        assert len(found.chords) == slow.cuts


def test_of_equal_costs_fewer_chords_win_then_the_first_chord() -> None:
    # Two unit squares at a right angle: the fold is worth a cut, diagonals of squares never are.
    points = np.array([[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [0, 0, 0]], float)
    for alpha in (0.0, 0.1):
        found = search_cuts(points, np.array([[0, 2], [2, 5], [3, 5], [1, 5]]), alpha)
        assert found.chosen.tolist() == [1]
        assert found.cost == pytest.approx(alpha / 6, abs=CLOSE)
    # A tetrahedron's four edges: both diagonals leave two triangles, and are equally long.
    skew = np.array([[1, 1, 1], [1, -1, -1], [-1, -1, 1], [-1, 1, -1]], float)
    assert search_cuts(skew, np.array([[0, 2], [1, 3]])).chosen.tolist() == [0]
    assert search_cuts(skew, np.array([[1, 3], [0, 2]])).chosen.tolist() == [0]


def test_the_two_halves_of_a_chord_are_two_sub_problems() -> None:
    # Under the chord a flat half circle, beyond it a wave: boundaries of the same one chord.
    t = np.linspace(0, math.pi, 9)
    flat = np.c_[np.cos(t), np.sin(t), 0 * t]
    wave = np.c_[np.cos(t + math.pi), np.sin(t + math.pi), np.sin(2 * t)][1:-1]
    points = np.concatenate([flat, wave])
    chord = np.array([[0, 8]])
    halves = parted(tuple(range(16)), chord[0])
    scores = [spread(points[list(half)]) / spread(points) for half in halves]
    assert scores[0] == pytest.approx(0.0, abs=CLOSE) and scores[1] > 0.1
    found = search_cuts(points, chord, 0.0)
    assert found.n_subproblems == 3
    assert found.cost == pytest.approx(sum(scores), abs=CLOSE)


@pytest.mark.parametrize("n", [150, 400])
def test_cycles_may_have_any_number_of_ends(n: int) -> None:
    # Teeth around a circle: every chord cuts off one, the more gain the less is left.
    rng = np.random.default_rng(n)
    points = random_loop(rng, n)
    starts = np.arange(0, n - 2, 3)
    chords = np.c_[starts, starts + 2]
    assert count_subproblems(n, chords) == min(MOST_COUNTED, 2 ** len(chords) + len(chords))
    # A ladder: rungs do not cross, but for the last of each side.
    rungs = np.array([(i, n - 1 - i) for i in range(n // 2 - 1)])
    found = search_cuts(points, rungs[rungs[:, 1] - rungs[:, 0] < n - 1], 0.05)
    assert np.unique(rungs).size > 64
    is_decomposition(n, rungs[rungs[:, 1] - rungs[:, 0] < n - 1][found.chosen], found.pieces)
    assert found.cost <= pieces_cost(points, (np.arange(n),))
    few = rungs[1:40:2]
    slow = Recursion(points, few, 0.05)
    fast = search_cuts(points, few, 0.05)
    assert fast.cost == pytest.approx(slow.cost, abs=CLOSE)
    assert fast.n_subproblems == len(slow.memo)


def test_a_comb_of_65_teeth_is_solved_beyond_64_ends_as_by_the_recursion() -> None:
    # Chords from one vertex to all others: few sub-problems, and more ends than bits in a word.
    n = 70
    points = random_loop(np.random.default_rng(7), n)
    fan = np.array([(0, j) for j in range(2, n - 1)])
    slow = Recursion(points, fan, 0.01)
    fast = search_cuts(points, fan, 0.01)
    assert len(np.unique(fan)) > 64
    assert fast.cost == pytest.approx(slow.cost, abs=CLOSE)
    assert fast.n_subproblems == len(slow.memo)


@given(SEEDS, st.integers(6, 40), st.integers(0, 20))
def test_the_number_of_sub_problems_is_the_same_for_every_alpha(seed: int, n: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    points, chords = random_loop(rng, n), random_chords(rng, n, m)
    chords = keep_within_budget(points, chords, 5_000)
    counts = {search_cuts(points, chords, alpha).n_subproblems for alpha in (0.0, 0.1, 0.6, 10.0)}
    assert len(counts) == 1


@pytest.mark.parametrize("name", SHAPES)
def test_a_larger_alpha_makes_no_more_pieces(name: str) -> None:
    loop = ring(SHAPES[name]())
    counts = [len(decompose(loop, alpha).chords) for alpha in (0.0, 0.1, 0.4, 2.0)]
    assert all(more >= fewer for more, fewer in pairwise(counts))
    assert counts[0] > 0
    alpha = 1.01 * perimeter(loop.points) / 1e-3
    assert len(decompose(loop, alpha).chords) == 0


def rotation(rng: np.random.Generator) -> np.ndarray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


@given(SEEDS, st.floats(-6, 6), st.sampled_from([0.0, 1.0, 1e3, 1e6]))
@example(1, 0.0, 1e6)
def test_flatness_and_cost_are_invariant_under_similarity(
    seed: int, magnitude: float, away: float
) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(6, 40))
    points, chords = random_loop(rng, n), random_chords(rng, n, 6)
    moved = (points @ rotation(rng).T + away * rng.normal(size=3)) * 10.0**magnitude
    # Far from the origin, the coordinates themselves have lost digits.
    tolerance = 1e-9 + 1e-13 * away
    before, after = search_cuts(points, chords), search_cuts(moved, chords)
    assert after.cost == pytest.approx(before.cost, abs=10 * tolerance)
    assert after.chosen.tolist() == before.chosen.tolist()


@given(SEEDS, st.floats(-3, 3), st.sampled_from([0.0, 1.0, 1e5]), st.sampled_from([0.0, 0.1]))
def test_a_planar_cycle_is_never_cut(
    seed: int, magnitude: float, away: float, alpha: float
) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 40))
    flat = random_loop(rng, n) * [1, 1, 0]
    points = (flat @ rotation(rng).T + away * rng.normal(size=3)) * 10.0**magnitude
    chords = random_chords(rng, n, 10)
    for form in ("relative", "printed"):
        found = search_cuts(points, chords, alpha, form)
        assert found.cost == 0 and len(found.chosen) == 0
        assert found.pieces[0].tolist() == list(range(n))
    cut = decompose(Loop(points, np.ones(n, bool), np.arange(n)), alpha, max_subproblems=1)
    assert len(cut.chords) == cut.n_dropped == 0 and not cut.exhausted


def test_the_printed_flatness_is_the_product_of_the_variances() -> None:
    rng = np.random.default_rng(3)
    points, chords = random_loop(rng, 20), random_chords(rng, 20, 7)
    variances = np.linalg.eigvalsh(np.cov(points.T, bias=True))
    whole = search_cuts(points, chords[:0], form="printed")
    assert whole.cost == pytest.approx(float(np.prod(variances)), rel=1e-9)
    # Its unit is length to the sixth: at unit size nothing is cut, at a hundred times it all is.
    assert len(search_cuts(points, chords, 0.1, "printed").chosen) == 0
    large = search_cuts(100 * points, chords, 0.1, "printed")
    assert len(large.chosen) > 0
    pieces = [np.cov(100 * points[piece].T, bias=True) for piece in large.pieces]
    flat = sum(max(0.0, float(np.linalg.det(c))) for c in pieces)
    assert large.cost == pytest.approx(flat, rel=1e-6)


def test_what_exceeds_the_budget_loses_its_longest_candidates() -> None:
    loop = ring(helix(2.5), 0.2)
    whole = decompose(loop)
    assert whole.n_dropped == 0 and not whole.exhausted
    less = decompose(loop, max_subproblems=whole.n_subproblems - 1)
    assert 0 < less.n_dropped <= len(whole.candidates) / 2
    assert less.n_subproblems < whole.n_subproblems and not less.exhausted
    kept = keep_within_budget(loop.points, whole.candidates, whole.n_subproblems - 1)
    assert len(kept) == len(whole.candidates) - less.n_dropped
    assert count_subproblems(len(loop.points), kept) == less.n_subproblems
    lengths = {
        tuple(chord): np.linalg.norm(loop.points[chord[0]] - loop.points[chord[1]])
        for chord in whole.candidates.tolist()
    }
    kept_lengths = [lengths.pop(tuple(chord)) for chord in kept.tolist()]
    assert max(kept_lengths) < min(lengths.values())
    assert np.array_equal(less.candidates, whole.candidates)
    assert less.cost >= whole.cost - CLOSE
    # One more chord than were kept would not have fitted.
    shortest = min(lengths, key=lambda chord: lengths[chord])
    more = np.concatenate([kept, [shortest]])
    equal = [chord for chord in lengths if lengths[chord] < lengths[shortest] * (1 + 1e-9)]
    assert count_subproblems(len(loop.points), more) >= whole.n_subproblems or len(equal) > 1


def test_a_search_that_is_given_up_says_so() -> None:
    loop = ring(helix(2.5), 0.2)
    found = decompose(loop, max_subproblems=20)
    assert found.exhausted
    assert found.n_dropped == len(found.candidates) > 0
    assert len(found.chords) == 0
    assert [piece.tolist() for piece in found.pieces] == [list(range(len(loop.points)))]
    assert found.cost == pytest.approx(1.0)


def test_the_densest_cycle_keeps_to_the_budget() -> None:
    # A zigzag between two circles: all its corners see each other.
    n = 120
    t = 2 * math.pi * np.arange(n) / n
    points = np.c_[np.cos(t), np.sin(t), 0.5 * (np.arange(n) % 2)]
    loop = Loop(points, np.ones(n, bool), np.arange(n))
    candidates = find_candidates(loop, find_endpoints(loop)).chords
    for chords in (candidates, random_chords(np.random.default_rng(0), n, 2_000)):
        kept = keep_within_budget(points, chords, 200_000)
        assert count_subproblems(n, chords) > 200_000 >= count_subproblems(n, kept)
        assert search_cuts(points, kept).n_subproblems == count_subproblems(n, kept)
    found = decompose(loop)
    assert found.n_subproblems <= 200_000
    assert found.n_dropped > 0


def test_what_is_no_problem_is_refused() -> None:
    points = random_loop(np.random.default_rng(0), 8)
    for chords in ([[0, 1]], [[0, 7]], [[3, 1]], [[-1, 4]], [[2, 8]]):
        with pytest.raises(InvalidNetworkError, match="chord 0"):
            search_cuts(points, np.array(chords))
    with pytest.raises(InvalidNetworkError, match="same positions"):
        search_cuts(points, np.array([[0, 4], [0, 4]]))
    for alpha in (-0.1, math.nan, math.inf):
        with pytest.raises(InvalidNetworkError, match="alpha"):
            search_cuts(points, np.array([[0, 4]]), alpha)
    with pytest.raises(InvalidNetworkError, match="sub-problems"):
        search_cuts(
            random_loop(np.random.default_rng(0), 300), np.array([(i, i + 2) for i in range(200)])
        )
    with pytest.raises(InvalidNetworkError, match="budget"):
        decompose(Loop(points, np.ones(8, bool), np.arange(8)), max_subproblems=0)
