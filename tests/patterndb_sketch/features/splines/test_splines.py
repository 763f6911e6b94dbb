"""B-spline curves: against their definition, and arc length against fine polylines."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from patterndb._native.features.splines.knots import count_determined
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines import Spline, chordal_parameters, fit_spline
from patterndb_sketch.features.splines.knots import SAME, average_knots, find_distinct


def function(i: int, p: int, knots: np.ndarray, t: float) -> float:
    """The B-spline basis function, from its definition (Cox and de Boor)."""
    if p == 0:
        last = t == knots[-1] == knots[i + 1] and knots[i] < knots[i + 1]
        return float(knots[i] <= t < knots[i + 1] or last)
    result = 0.0
    if knots[i + p] > knots[i]:
        result += (t - knots[i]) / (knots[i + p] - knots[i]) * function(i, p - 1, knots, t)
    if knots[i + p + 1] > knots[i + 1]:
        share = (knots[i + p + 1] - t) / (knots[i + p + 1] - knots[i + 1])
        result += share * function(i + 1, p - 1, knots, t)
    return result


def random_spline(seed: int, degree: int | None = None) -> Spline:
    """Any degree, uneven knots, some of them double."""
    rng = np.random.default_rng(seed)
    p = int(rng.integers(1, 6)) if degree is None else degree
    inner = np.sort(rng.uniform(0.0, 1.0, rng.integers(0, 8)))
    if p > 1 and len(inner) > 2:
        inner[1] = inner[0]
    knots = np.r_[np.zeros(p + 1), inner, np.ones(p + 1)]
    return Spline(p, knots, rng.normal(size=(len(inner) + p + 1, 3)))


def ascending(seed: int, m: int) -> np.ndarray:
    """(m,) distinct parameters, often much denser at one place than at another."""
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.05, 1.0, m - 1) ** rng.integers(1, 6)
    along = np.r_[0.0, np.cumsum(steps)]
    return np.minimum(along / along[-1], 1.0)


class TestCurve:
    @settings(max_examples=40)
    @given(st.integers(0, 2**32))
    def test_is_what_the_definition_says(self, seed: int) -> None:
        spline = random_spline(seed)
        ts = np.r_[np.random.default_rng(seed + 1).uniform(size=8), spline.knots]
        for t, found in zip(ts, spline(ts), strict=True):
            basis = [
                function(i, spline.degree, spline.knots, t) for i in range(len(spline.control))
            ]
            assert found == pytest.approx(basis @ spline.control, abs=1e-12)

    @settings(max_examples=40)
    @given(st.integers(0, 2**32))
    def test_derivatives(self, seed: int) -> None:
        spline = random_spline(seed)
        ts = np.random.default_rng(seed + 2).uniform(0.01, 0.99, 12)
        ts = ts[np.abs(ts[:, None] - spline.knots).min(axis=1) > 1e-3]
        for order in (1, 2):
            low, high = (spline.derivative(ts + s * 1e-6, order - 1) for s in (-1, 1))
            size = 1.0 + np.abs(spline.derivative(ts, order)).max(initial=0.0)
            assert (high - low) / 2e-6 == pytest.approx(
                spline.derivative(ts, order), abs=1e-3 * size
            )
        unit = spline.tangent(ts)
        assert np.linalg.norm(unit, axis=1) == pytest.approx(np.ones(len(ts)))
        assert np.abs(np.cross(unit, spline.derivative(ts))).max(initial=0.0) < 1e-9 * size

    def test_a_tangent_where_the_curve_stands_still(self) -> None:
        spline = Spline(3, [0, 0, 0, 0, 1, 1, 1, 1], [[0, 0, 0], [0, 0, 0], [1, 1, 0], [2, 2, 0]])
        half = math.sqrt(0.5)
        assert spline.tangent([0.0, 0.3]) == pytest.approx(np.array([[half, half, 0]] * 2))

    def test_ends_beyond_the_domain(self) -> None:
        spline = random_spline(1)
        assert (spline([-1.0, 2.0]) == spline([0.0, 1.0])).all()
        assert spline.control[[0, -1]] == pytest.approx(spline([0.0, 1.0]))


class TestArcLength:
    def test_of_a_parabola(self) -> None:
        # (t, t^2): its length in closed form.
        spline = Spline(2, [0, 0, 0, 1, 1, 1], [[0, 0, 0], [0.5, 0, 0], [1, 1, 0]])
        exact = math.sqrt(5.0) / 2.0 + math.asinh(2.0) / 4.0
        assert spline.length == pytest.approx(exact, rel=1e-10)
        t = spline.at_lengths([0.0, exact / 3.0, exact])
        x = t[1]
        part = x * math.sqrt(1 + 4 * x * x) / 2.0 + math.asinh(2.0 * x) / 4.0
        assert part == pytest.approx(exact / 3.0, rel=1e-9)
        assert (t[0], t[2]) == (0.0, pytest.approx(1.0, abs=1e-12))

    @settings(max_examples=25)
    @given(st.integers(0, 2**32), st.integers(2, 60))
    def test_samples_are_equally_far_along(self, seed: int, count: int) -> None:
        spline = random_spline(seed, 3)
        t = spline.at_lengths(np.linspace(0.0, spline.length, count))
        assert (np.diff(t) > 0.0).all() and t[0] == 0.0
        assert (spline.sample(count) == spline(t)).all()
        fine = np.unique(np.r_[np.linspace(0.0, 1.0, 20_001), t])
        along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(spline(fine), axis=0), axis=1))]
        # Random control points may all but make cusps, where arc length is least exact.
        assert spline.length == pytest.approx(along[-1], rel=1e-3)
        steps = np.diff(along[np.searchsorted(fine, t)])
        assert np.abs(steps - along[-1] / (count - 1)).max() < 1e-3 * along[-1]

    def test_of_a_helix(self) -> None:
        turn = np.linspace(0.0, 6.0, 400)
        fit = fit_spline(np.stack([np.cos(turn), np.sin(turn), turn], axis=1))
        assert fit.spline.length == pytest.approx(6.0 * math.sqrt(2.0), rel=1e-7)
        chords = np.linalg.norm(np.diff(fit.spline.sample(100), axis=0), axis=1)
        assert np.ptp(chords) < 1e-6


class TestRefusals:
    @pytest.mark.parametrize(
        ("knots", "what"),
        [
            ([0, 0, 0, 1, 0.5, 2, 2, 2], "ascend"),
            ([0, 0, 0, 1, 1, 2, 2, 3], "first and last 3"),
            ([0, 0, 1, 1, 1, 2, 2, 2], "first and last 3"),
            ([0, 0, 0, 0, 1, 2, 2, 2], "more than 2 times"),
            ([0, 0, 0, np.nan, 1, 2, 2, 2], "finite"),
        ],
    )
    def test_knots(self, knots: list[float], what: str) -> None:
        with pytest.raises(InvalidFeatureError, match=what):
            Spline(2, knots, np.zeros((5, 3)))


class TestParameters:
    @given(st.integers(0, 2**32), st.integers(2, 50))
    def test_are_in_proportion_to_the_chords(self, seed: int, m: int) -> None:
        rng = np.random.default_rng(seed)
        samples = rng.normal(size=(m, 3)).repeat(rng.integers(1, 3, m), axis=0)
        t = chordal_parameters(samples)
        assert t[0] == 0.0 and t[-1] == 1.0
        chords = np.linalg.norm(np.diff(samples, axis=0), axis=1)
        assert np.diff(t) * chords.sum() == pytest.approx(chords, abs=1e-9)
        assert len(find_distinct(t)) == m

    def test_rounding_is_no_distance(self) -> None:
        samples = np.array([[0.0, 0, 0], [1, 0, 0], [1 + 2e-16, 0, 0], [2, 0, 0]])
        t = chordal_parameters(samples)
        assert t == pytest.approx([0.0, 0.5, 0.5, 1.0]) and t[1] == t[2]
        with pytest.raises(InvalidFeatureError, match="one place"):
            chordal_parameters(np.ones((3, 3)))


class TestKnots:
    @settings(max_examples=200)
    @given(st.integers(0, 2**32), st.integers(2, 80), st.data())
    def test_every_control_point_is_determined(
        self, seed: int, m: int, data: st.DataObject
    ) -> None:
        t = ascending(seed, m)
        assert (np.diff(t) > SAME).all()
        degree = data.draw(st.integers(1, min(5, m - 1)))
        n = data.draw(st.integers(degree + 1, m))
        knots = average_knots(t, degree, n)
        assert len(knots) == n + degree + 1 and (np.diff(knots) >= 0.0).all()
        assert count_determined(t, knots, degree) == n
        Spline(degree, knots, np.zeros((n, 3)))

    @settings(max_examples=200)
    @given(st.integers(0, 2**32), st.integers(4, 80), st.data())
    def test_held_parameters_are_interpolated(self, seed: int, m: int, data: st.DataObject) -> None:
        t = ascending(seed, m)
        n = data.draw(st.integers(4, m))
        held = t[sorted(data.draw(st.sets(st.integers(0, m - 1), min_size=1)))]
        knots = average_knots(t, 3, n, held)
        count = len(knots) - 4
        assert n <= count <= m
        assert count_determined(t, knots, 3) == count
        assert count_determined(held, knots, 3) == len(held)

    def test_as_many_as_samples_are_those_of_interpolation(self) -> None:
        t = ascending(3, 9)
        points = np.random.default_rng(4).normal(size=(9, 3))
        inner = [t[j : j + 3].mean() for j in range(1, 6)]
        knots = average_knots(t, 3, 9)
        assert knots == pytest.approx(np.r_[[0.0] * 4, inner, [1.0] * 4])
        curve = make_interp_spline(t, points, k=3, t=knots)
        assert curve(t) == pytest.approx(points)

    @settings(max_examples=200)
    @given(st.integers(0, 2**32), st.integers(1, 30))
    def test_determined_is_a_greatest_matching(self, seed: int, m: int) -> None:
        spline = random_spline(seed)
        rng = np.random.default_rng(seed + 3)
        choice = np.r_[rng.uniform(size=m), spline.knots, spline.knots]
        t = np.sort(rng.choice(choice, m))
        unique = np.unique(t)
        n = len(spline.control)
        positive = [
            [function(i, spline.degree, spline.knots, x) > 0.0 for i in range(n)] for x in unique
        ]
        matched = maximum_bipartite_matching(csr_array(np.array(positive, np.int8)))
        assert count_determined(t, spline.knots, spline.degree) == (matched >= 0).sum()
