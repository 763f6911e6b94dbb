"""Fitting splines: exact where it must be, least where it may not, never worse by correction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from scipy.linalg import lapack, null_space

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines import Spline, fit_spline
from patterndb_sketch.features.splines.fit import (
    EXACT,
    ROUNDS,
    OpenRows,
    correct_parameters,
    solve_constrained,
)
from patterndb_sketch.features.splines.knots import average_knots

Points = np.ndarray


def walk(seed: int, m: int, noise: float = 0.02) -> Points:
    """(m, 3) samples along a curve with some noise."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, m)[:, None]
    waves = sum(
        rng.normal(size=3) * np.sin(k * np.pi * t + rng.uniform(0, 6, 3)) / k for k in range(1, 5)
    )
    return waves + noise * rng.normal(size=(m, 3))


def some_constraints(seed: int, samples: Points, most: int) -> list[tuple[int, Points]]:
    rng = np.random.default_rng(seed + 1)
    count = rng.integers(1, min(most, len(samples)) + 1)
    numbers = rng.choice(len(samples), count, replace=False)
    return [(int(i), samples[i] + 0.1 * rng.normal(size=3)) for i in numbers]


def dense(parameters: Points, spline: Spline) -> Points:
    return BSpline.design_matrix(parameters, spline.knots, spline.degree).toarray()


class TestCubic:
    @settings(max_examples=60)
    @given(st.integers(0, 2**32), st.integers(4, 300))
    def test_is_reproduced(self, seed: int, m: int) -> None:
        """A cubic, sampled unevenly, comes back to 1e-10, with and without constraints."""
        rng = np.random.default_rng(seed)
        cubic = Spline(3, [0, 0, 0, 0, 1, 1, 1, 1], rng.normal(size=(4, 3)))
        # No two samples nearly at one place: of four such points no cubic can be told to 1e-10.
        t = (np.arange(m) + np.r_[0.0, rng.uniform(-0.4, 0.4, m - 2), 0.0]) / (m - 1.0)
        held = [(int(i), cubic(t[i])[0]) for i in rng.choice(m, rng.integers(0, 4), replace=False)]
        fit = fit_spline(cubic(t), parameters=t, constraints=held, rounds=0)
        fine = np.linspace(0.0, 1.0, 301)
        assert np.abs(fit.spline(fine) - cubic(fine)).max() < 1e-10
        assert fit.error < 1e-12

    def test_is_reproduced_as_a_graph_over_a_line(self) -> None:
        t = np.linspace(0.0, 1.0, 101)
        samples = np.stack([3.0 * t, 0.0 * t, 0.0 * t], axis=1)
        fit = fit_spline(samples)
        assert np.abs(fit.spline(t) - samples).max() < 1e-12


class TestConstrainedLeastSquares:
    @settings(max_examples=80)
    @given(st.integers(0, 2**32), st.integers(6, 200))
    def test_lagrange_conditions(self, seed: int, m: int) -> None:
        """Constraints to 1e-10, and the gradient is a combination of theirs."""
        samples = walk(seed, m)
        held = some_constraints(seed, samples, 8)
        fit = fit_spline(samples, constraints=held)
        spread = np.linalg.norm(np.ptp(samples, axis=0))
        rows = dense(fit.parameters, fit.spline)
        wanted = samples.copy()
        for i, point in held:
            wanted[i] = point
            gap = np.linalg.norm(fit.spline(fit.parameters[i])[0] - point)
            assert gap < 1e-10 * max(spread, 1.0)
        exact = rows[[i for i, _ in held]]
        gradient = rows.T @ (rows @ fit.spline.control - wanted)
        # Moves that keep the constraints change nothing to first order; of constraints that nearly
        # depend on each other, to fewer digits.
        assert np.abs(null_space(exact).T @ gradient).max(initial=0.0) < 1e-5
        assert fit.error == pytest.approx(
            np.sqrt(((rows @ fit.spline.control - wanted) ** 2).sum() / m), abs=1e-12
        )

    @settings(max_examples=80)
    @given(st.integers(0, 2**32), st.integers(6, 120))
    def test_against_lapack(self, seed: int, m: int) -> None:
        samples = walk(seed, m)
        held = some_constraints(seed, samples, 5)
        fit = fit_spline(samples, constraints=held, rounds=0)
        rows = dense(fit.parameters, fit.spline)
        numbers = [i for i, _ in held]
        free = np.setdiff1d(np.arange(m), numbers)
        if len(free) + len(numbers) < rows.shape[1]:
            return
        for c in range(3):
            goal = np.array([point[c] for _, point in held])
            *_, x, info = lapack.dgglse(rows[free], rows[numbers], samples[free, c], goal)
            assert info == 0
            assert fit.spline.control[:, c] == pytest.approx(x, abs=1e-7)

    @settings(max_examples=60)
    @given(st.integers(0, 2**32), st.integers(5, 60), st.data())
    def test_rank_deficient(self, seed: int, m: int, data: st.DataObject) -> None:
        """Too few samples, constraints twice: still a least squares solution, the smallest."""
        rng = np.random.default_rng(seed)
        t = np.r_[0.0, np.sort(rng.uniform(size=m - 2)), 1.0]
        n = data.draw(st.integers(4, 2 * m))
        knots = average_knots(np.linspace(0.0, 1.0, n), 3, n)
        rows = BSpline.design_matrix(t, knots, 3).toarray()
        held = rng.choice(m, rng.integers(0, 4), replace=False)
        held = np.sort(np.r_[held, held[:1]])
        target = rng.normal(size=(n, 3))
        wanted = rng.normal(size=(m, 3))
        wanted[held] = rows[held] @ target  # so that the constraints agree
        found = solve_constrained(OpenRows.of(t, knots, 3), wanted, held)
        # By the null space of the constraints, densely.
        exact = rows[held]
        start = np.linalg.pinv(exact, rcond=1e-10) @ wanted[held]
        space = null_space(exact, rcond=1e-10) if len(held) else np.eye(n)
        rest = np.linalg.pinv(rows @ space, rcond=1e-7) @ (wanted - rows @ start)
        best = start + space @ rest
        size = 1.0 + np.abs(best).max()
        assert np.abs(exact @ found - wanted[held]).max(initial=0.0) < 1e-8 * size
        mine, other = (np.linalg.norm(rows @ x - wanted) for x in (found, best))
        assert mine <= other + 1e-6 * size

    def test_the_same_constraint_twice_is_one(self) -> None:
        samples = walk(1, 50)
        point = samples[20] + [0.0, 0.1, 0.0]
        once = fit_spline(samples, constraints=[(20, point)])
        twice = fit_spline(samples, constraints=[(20, point), (20, list(point)), (20, point)])
        assert (once.spline.control == twice.spline.control).all()
        assert twice.note == ""

    def test_coinciding_samples_share_a_constraint(self) -> None:
        samples = np.repeat(walk(2, 40), 2, axis=0)
        point = samples[20] + [0.0, 0.1, 0.0]
        fit = fit_spline(samples, constraints=[(20, point), (21, point)])
        assert np.abs(fit.spline(fit.parameters[20]) - point).max() < 1e-10
        with pytest.raises(InvalidFeatureError, match="samples 20 and 21 have one parameter"):
            fit_spline(samples, constraints=[(20, point), (21, point + 0.1)])

    def test_conflicting_constraints(self) -> None:
        samples = walk(3, 30)
        with pytest.raises(InvalidFeatureError, match="samples 7 and 7 have one parameter"):
            fit_spline(samples, constraints=[(7, samples[7]), (7, samples[8])])
        # Five neighbours cannot all be met by the four functions there are.
        many = [(i, samples[i] + 0.1 * (-1) ** i * np.ones(3)) for i in range(10, 15)]
        with pytest.raises(InvalidFeatureError, match="5 constraints cannot all be met by 4"):
            fit_spline(samples, n_control=4, constraints=many)

    @settings(max_examples=60)
    @given(st.integers(0, 2**32), st.integers(6, 100), st.integers(1, 30))
    def test_however_close_together(self, seed: int, m: int, count: int) -> None:
        samples = walk(seed, m)
        rng = np.random.default_rng(seed + 2)
        begin = int(rng.integers(0, m))
        held = [
            (i, samples[i] + 0.01 * rng.normal(size=3)) for i in range(begin, min(begin + count, m))
        ]
        fit = fit_spline(samples, constraints=held)
        for i, point in held:
            assert np.linalg.norm(fit.spline(fit.parameters[i])[0] - point) < 1e-9
        more = len(fit.spline.control) > max(m // 5, 4)
        assert more == ("constraints close together" in fit.note)


class TestCorrection:
    @settings(max_examples=80)
    @given(st.integers(0, 2**32), st.integers(2, 200), st.floats(0.0, 0.5), st.booleans())
    def test_the_error_never_rises(self, seed: int, m: int, noise: float, hold: bool) -> None:
        """At most three rounds, each better, parameters in order, constraints exact at the end."""
        samples = walk(seed, m, noise)
        held = some_constraints(seed, samples, 4) if hold else []
        fit = fit_spline(samples, constraints=held)
        assert fit.rounds <= ROUNDS and len(fit.errors) == fit.rounds + 1
        assert (np.diff(fit.errors) < 0.0).all() and fit.error == fit.errors[-1]
        assert fit.errors[0] == fit_spline(samples, constraints=held, rounds=0).error
        assert (np.diff(fit.parameters) > 0.0).all()
        assert (fit.parameters[0], fit.parameters[-1]) == (0.0, 1.0)
        spread = np.linalg.norm(np.ptp(np.concatenate([samples, *[[p] for _, p in held]]), axis=0))
        assert fit.residual <= EXACT * spread
        for i, point in held:
            assert np.linalg.norm(fit.spline(fit.parameters[i])[0] - point) <= 2 * EXACT * spread

    def test_it_helps(self) -> None:
        # Chords through a zig-zag: its parameters run unevenly, and are mended.
        turn = np.linspace(0.0, 3.0, 120)
        samples = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
        samples[::3] *= 1.02
        fit = fit_spline(samples)
        assert fit.rounds == ROUNDS
        assert fit.errors[-1] < 0.999 * fit.errors[0]

    @settings(max_examples=40, derandomize=True)
    @given(st.integers(0, 2**32))
    def test_steps_lead_to_the_feet(self, seed: int) -> None:
        spline = fit_spline(walk(seed, 60, 0.0), n_control=8).spline
        rng = np.random.default_rng(seed + 3)
        t = np.r_[0.0, np.sort(rng.uniform(0.05, 0.95, 12)), 1.0]
        samples = spline(t)
        start = t.copy()
        start[1:-1] += rng.uniform(-1, 1, 12) * 0.2 * np.minimum(np.diff(t)[:-1], np.diff(t)[1:])
        moved = start
        for _ in range(60):
            moved = correct_parameters(spline, samples, moved)
            assert (np.diff(moved) > 0.0).all()
        # At a foot the sample is straight beside the curve. Where the curve turns sharply it may
        # have two, and Newton's steps lead to the nearer one along it.
        off = spline(moved) - samples
        assert np.abs((off * spline.tangent(moved)).sum(axis=1)).max() < 1e-9
        before = np.linalg.norm(spline(start) - samples, axis=1)
        assert (off**2).sum() <= (before**2).sum()


class TestNumbers:
    @pytest.mark.parametrize(
        ("m", "n"), [(2, 2), (3, 3), (4, 4), (19, 4), (25, 5), (200, 40), (400, 80)]
    )
    def test_control_points(self, m: int, n: int) -> None:
        fit = fit_spline(walk(5, m))
        assert len(fit.spline.control) == n
        assert fit.spline.degree == min(3, m - 1)
        assert (fit.note != "") == (m < 4)

    def test_few_samples_lower_the_degree(self) -> None:
        samples = np.array([[0.0, 0, 0], [1, 2, 0], [3, 2, 1]])
        fit = fit_spline(samples)
        assert fit.note == "degree 2 instead of 3: 3 distinct samples"
        assert fit.spline(fit.parameters) == pytest.approx(samples)
        assert fit_spline(samples[[0, 1, 1, 1, 1]]).spline.degree == 1

    @pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
    def test_of_any_degree(self, degree: int) -> None:
        samples = walk(6, 100, 0.0)
        fit = fit_spline(samples, degree=degree, n_control=30, constraints=[(50, samples[50])])
        assert fit.spline.degree == degree and len(fit.spline.control) == 30
        assert fit.error < 0.02

    def test_more_control_points_than_samples_are_refused_aloud(self) -> None:
        fit = fit_spline(walk(7, 10), n_control=12)
        assert len(fit.spline.control) == 10 and "10 control points instead of 12" in fit.note
        assert fit.error < 1e-10

    def test_it_does_not_matter_where_and_how_large(self) -> None:
        samples = walk(8, 60)
        here = fit_spline(samples, constraints=[(9, samples[9] + 0.1)])
        there = fit_spline(1e3 * samples + 1e6, constraints=[(9, 1e3 * (samples[9] + 0.1) + 1e6)])
        assert there.parameters == pytest.approx(here.parameters, abs=1e-6)
        assert there.error == pytest.approx(1e3 * here.error, rel=1e-6)

    @pytest.mark.parametrize(
        ("samples", "options", "what"),
        [
            (np.zeros((1, 3)), {}, "at least 2 samples"),
            (np.zeros((4, 3)), {}, "one place"),
            (np.eye(3), {"degree": 0}, "degree is 0"),
            (np.eye(3), {"degree": 12}, "degree is 12"),
            (walk(9, 9), {"n_control": 3}, "at least 4 control points"),
            (np.eye(3), {"constraints": [(3, [0, 0, 0])]}, "sample 3"),
            (np.eye(3), {"constraints": [(1, [0, np.inf, 0])]}, "not finite"),
            (np.eye(3), {"constraints": [(1, np.eye(3))]}, "the point of sample 1"),
            (np.eye(3), {"parameters": [0, 1]}, "one for each of the 3"),
            (np.eye(3), {"parameters": [0, 2, 1]}, "below the one before"),
            (np.eye(3), {"parameters": [0, 0.5, 0.9]}, "exactly 1"),
        ],
    )
    def test_refusals(self, samples: Points, options: dict, what: str) -> None:
        with pytest.raises(InvalidFeatureError, match=what):
            fit_spline(samples, **options)
