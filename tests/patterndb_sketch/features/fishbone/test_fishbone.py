"""Fishbones: their arrays, what pulls a curve along them, and how they are synchronised."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone import (
    Fishbone,
    curvature,
    find_held_rows,
    find_moves,
    find_terms,
    isophote,
    synchronise,
    tau,
)
from patterndb_sketch.features.fishbone.terms import SCALES


@dataclass(frozen=True)
class Drawn:
    """A rib as given."""

    origin: Points
    points: Points
    normals: Points
    backbone: int


def fishbone_of(
    profile: Callable[[NDArray[np.float64]], Points],
    places: Sequence[float],
    reach: float,
    n: int = 201,
    shifts: Sequence[int] | None = None,
) -> Fishbone:
    """Ribs of one profile (s,) -> (s, 2) in planes across x; shifts move the backbone's rows."""
    s = np.linspace(-reach, reach, n)
    flat = profile(s)
    slope = np.gradient(flat, axis=0)
    normals = np.stack([-slope[:, 1], slope[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    moved = [0] * len(places) if shifts is None else shifts
    ribs = []
    for x, shift in zip(places, moved, strict=True):
        points = np.c_[np.full(n, x), flat]
        row = n // 2 + shift
        ribs.append(Drawn(points[row], points, np.c_[np.zeros(n), normals], row))
    return Fishbone.from_ribs(ribs)


def circle(radius: float) -> Callable[[NDArray[np.float64]], Points]:
    return lambda s: radius * np.stack([np.sin(s / radius), np.cos(s / radius)], axis=1)


def corner(turn: float) -> Callable[[NDArray[np.float64]], Points]:
    """Two legs that meet at 0 and turn by so much."""

    def at(s: NDArray[np.float64]) -> Points:
        c, d = np.cos(turn / 2.0), np.sin(turn / 2.0)
        return np.stack([s * c, -np.abs(s) * d], axis=1)

    return at


@pytest.mark.parametrize("radius", [0.3, 1.0, 20.0])
@pytest.mark.parametrize("n", [41, 201, 1001])
def test_curvature_of_a_circle_is_one_over_its_radius(radius: float, n: int) -> None:
    """Within 1 %, whatever the sampling."""
    window = 0.1 if radius > 0.5 else 0.08
    bone = fishbone_of(circle(radius), [0.0, 0.1], 0.5, n)
    found = curvature(bone, window)
    inner = np.abs(np.linspace(-0.5, 0.5, n)) < 0.5 - SCALES[-1] * window - 2.0 / n
    assert inner.any()
    assert found[:, inner] == pytest.approx(1.0 / radius, rel=0.01)


@pytest.mark.parametrize("turn", [0.1, 0.8, np.pi / 2.0, 2.5])
def test_a_corner_is_a_peak_as_high_as_it_turns(turn: float) -> None:
    bone = fishbone_of(corner(turn), [0.0], 0.5)
    found = curvature(bone, 0.05)[0]
    assert found.argmax() == 100
    assert found[100] == pytest.approx(len(SCALES) * turn / (0.05 * sum(SCALES)), rel=1e-6)
    # On both sides it falls at once, and is 0 beyond the widest window.
    reach = round(SCALES[-1] * 0.05 / 0.005)
    assert (np.diff(found[100 - reach : 101]) > 0.0).all()
    assert (np.diff(found[100 : 101 + reach]) < 0.0).all()
    assert found[np.abs(np.arange(201) - 100) >= reach] == pytest.approx(0.0, abs=1e-6)


def test_facets_of_a_smooth_surface_do_not_outshine_a_corner() -> None:
    """Facets that turn by 4.5 degrees each, beside a corner of 30 degrees."""

    def at(s: NDArray[np.float64]) -> Points:
        angle = np.floor(10.0 * s + 1e-9) * np.radians(4.5) + np.where(s > 0.2, np.pi / 6, 0.0)
        step = np.r_[0.0, np.diff(s)]
        return np.cumsum(np.stack([np.cos(angle), -np.sin(angle)], axis=1) * step[:, None], axis=0)

    found = curvature(fishbone_of(at, [0.0], 0.5), 0.05)[0]
    where = np.linspace(-0.5, 0.5, 201)
    assert abs(where[found.argmax()] - 0.2) < 0.011
    assert found[np.abs(where - 0.2) > 0.21].max() < 0.5 * found.max()


def test_the_isophote_of_a_sphere_is_a_latitude() -> None:
    """a = z and beta = 60 degrees: the rows at that latitude cost nothing, on either side."""
    n, beta = 721, np.radians(60.0)
    polar = np.linspace(0.1, np.pi - 0.1, n)
    ribs = []
    for turn in np.linspace(0.0, 1.0, 9):
        points = np.stack(
            [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=1
        )
        ribs.append(Drawn(points[n // 3], points, points, n // 3))
    bone = Fishbone.from_ribs(ribs)
    off = isophote(bone, (0.0, 0.0, 2.0), beta)
    expected = np.minimum(np.abs(polar - beta), np.abs(np.pi - polar - beta))
    assert off == pytest.approx(np.tile(expected, (9, 1)), abs=1e-7)
    latitude = bone.points[np.arange(9), off[:, : n // 2].argmin(axis=1), 2]
    assert latitude == pytest.approx(np.cos(beta), abs=3e-3)
    # Models have no sides: the other side of the surface is as good.
    turned = Fishbone(
        bone.points, -bone.normals, bone.valid, bone.backbone, bone.ribs, bone.origins
    )
    assert isophote(turned, (0.0, 0.0, 1.0), beta) == pytest.approx(off, abs=1e-12)


def test_tau_is_cheapest_on_the_ridge_and_within_0_and_1() -> None:
    """The printed sum is turned round: a ridge is found, not avoided."""
    bone = fishbone_of(corner(1.0), np.linspace(0.0, 1.0, 7).tolist(), 0.5, shifts=[8] * 7)
    found = find_terms(bone, 0.05, np.inf, (0.0, 0.0, 1.0), 0.0)
    for alpha in (0.0, 0.3, 1.0):
        costs = tau(found, alpha)
        assert costs.min() >= 0.0 and costs.max() <= 1.0
    # The percentile makes the seven best of these samples alike.
    assert (np.abs(tau(found, 1.0).argmin(axis=1) - 100) <= 1).all()
    assert tau(found, 0.5) == pytest.approx((tau(found, 0.0) + tau(found, 1.0)) / 2.0)
    assert found.flat == ()


def test_outliers_do_not_make_a_feature_look_flat() -> None:
    """The 99.5th percentile over the whole fishbone counts as 1."""
    bone = fishbone_of(corner(0.5), np.linspace(0.0, 1.0, 30).tolist(), 0.5)
    points = bone.points.copy()
    points[3, 40, 2] += 0.05
    spiked = Fishbone(points, bone.normals, bone.valid, bone.backbone, bone.ribs, bone.origins)
    found = find_terms(spiked, 0.05, np.inf, (0.0, 0.0, 1.0), 0.0).curvature
    assert found[5:, 100] == pytest.approx(1.0, abs=1e-2)


def test_a_flat_fishbone_has_nothing_to_follow_and_says_so() -> None:
    bone = fishbone_of(corner(0.0), [0.0, 0.5, 1.0], 0.5)
    noisy = Fishbone(
        bone.points + np.random.default_rng(1).normal(0.0, 1e-12, bone.points.shape),
        bone.normals, bone.valid, bone.backbone, bone.ribs, bone.origins,
    )  # fmt: skip
    found = find_terms(noisy, 0.05, np.inf, (0.0, 0.0, 1.0), 0.0)
    assert set(found.flat) == {"curvature", "isophote"}
    assert (found.curvature == 0.0).all() and (found.isophote == 0.0).all()


def test_near_bends_count_more() -> None:
    """A corner of 30 degrees at the backbone against one of 90 degrees three widths away."""

    def at(s: NDArray[np.float64]) -> Points:
        angle = np.where(s > 0.0, np.pi / 6, 0.0) + np.where(s > 0.3, np.pi / 2, 0.0)
        return np.cumsum(np.stack([np.cos(angle), -np.sin(angle)], 1) * 0.005, axis=0)

    bone = fishbone_of(at, [0.0, 0.1], 0.5)
    rows = [
        tau(find_terms(bone, 0.03, nearness, (0.0, 0.0, 1.0), 0.0), 1.0)[0].argmin()
        for nearness in (0.1, np.inf)
    ]
    assert abs(rows[0] - 100) <= 1 and abs(rows[1] - 160) <= 1


def test_synchronised_ribs_jump_by_two_samples_at_most() -> None:
    """Zig-zag: the backbone alternates between both sides of a sharp ridge, figure 6."""
    shifts = [12 if i % 2 else -12 for i in range(40)]
    bone = fishbone_of(corner(2.0), np.linspace(0.0, 4.0, 40).tolist(), 0.5, shifts=shifts)
    assert np.abs(np.diff(bone.backbone)).max() == 24
    for start in (None, 0, 17, 39):
        found = synchronise(bone, start)
        assert len(set(found.backbone.tolist())) == 1
        # Rows of the ribs as they were: how far does one row jump from rib to rib?
        here = found.at(found.backbone)
        was = [int(np.linalg.norm(bone.points[i] - here[i], axis=1).argmin()) for i in range(40)]
        assert np.abs(np.diff(was)).max() <= 2
        # Nothing is lost, and rows that were moved away are not valid.
        assert found.valid.sum() == bone.valid.sum()
        for i in range(40):
            assert (found.points[i][found.valid[i]] == bone.points[i]).all()
        assert (found.points[~found.valid] == 0.0).all()
        padded = tau(find_terms(found, 0.05, np.inf, (0.0, 0.0, 1.0), 0.0), 1.0)
        assert (np.isinf(padded) == ~found.valid).all()


def test_ribs_of_another_sheet_are_left_out() -> None:
    bone = fishbone_of(corner(1.0), np.linspace(0.0, 2.0, 21).tolist(), 0.5)
    points = bone.points.copy()
    points[[0, 9, 20]] += (0.0, 0.0, 3.0)
    found = synchronise(
        Fishbone(points, bone.normals, bone.valid, bone.backbone, bone.ribs, bone.origins)
    )
    assert sorted(set(range(21)) - set(found.ribs.tolist())) == [0, 9, 20]
    with pytest.raises(InvalidFeatureError, match=r"there are ribs 0\.\.20"):
        synchronise(bone, 21)


def test_ribs_are_turned_to_run_one_way() -> None:
    bone = fishbone_of(corner(1.0), np.linspace(0.0, 1.0, 11).tolist(), 0.5, shifts=[5] * 11)
    ribs: list[Drawn | None] = [
        Drawn(bone.origins[i], p[::-1], -n[::-1], 200 - int(b)) if i % 3 == 1 else
        Drawn(bone.origins[i], p, n, int(b))
        for i, (p, n, b) in enumerate(zip(bone.points, bone.normals, bone.backbone, strict=True))
    ]  # fmt: skip
    ribs[4] = None
    found = Fishbone.from_ribs(ribs)
    there = np.setdiff1d(np.arange(11), [4])
    assert (found.ribs == there).all() and (found.backbone == 105).all()
    assert (found.points == bone.points[there]).all()
    assert (found.normals == bone.normals[there]).all()


def test_a_scrap_of_a_rib_makes_no_feature_look_flat() -> None:
    """A rib shorter than the window turns by what it turns over the whole window, not its own."""
    places = np.linspace(0.0, 1.0, 11).tolist()
    bone = fishbone_of(corner(1.0), places, 0.5)
    wanted = curvature(bone, 0.05)
    points = bone.points.copy()
    points[5, :, 1:] *= 1e-6
    scrap = Fishbone(points, bone.normals, bone.valid, bone.backbone, bone.ribs, bone.origins)
    found = curvature(scrap, 0.05)
    assert (np.delete(found, 5, axis=0) == np.delete(wanted, 5, axis=0)).all()
    assert found[5].max() <= wanted.max() * (1.0 + 1e-9)
    points[5] = points[5, :1]
    still = Fishbone(points, bone.normals, bone.valid, bone.backbone, bone.ribs, bone.origins)
    assert (curvature(still, 0.05)[5] == 0.0).all()


@settings(max_examples=40)
@given(st.integers(0, 2**32))
def test_ribs_that_gain_little_move_as_those_beside_them(seed: int) -> None:
    """Against one rib at a time: those that gain half of the usual stay as they were cut, and the
    others go, by what they lack, to the line between the next of those on both sides."""
    rng = np.random.default_rng(seed)
    bone = fishbone_of(corner(1.0), np.sort(rng.uniform(0.0, 3.0, 15)).tolist(), 0.5)
    rows = rng.integers(0, 201, 15)
    gains = rng.uniform(0.0, 1.0, 15) * rng.choice([0.0, 0.3, 1.0], 15)
    costs = np.ones((15, 201))
    costs[np.arange(15), rows] = 1.0 - gains
    found, told = find_moves(bone, rows, costs)
    own = bone.at(rows) - bone.origins
    half = np.median(1.0 - costs[np.arange(15), rows]) / 2.0
    if half == 0.0:
        assert (found == own).all() and len(told) == 15
        return
    assert (told == np.flatnonzero(1.0 - costs[np.arange(15), rows] >= half)).all()
    for i in range(15):
        before, after = told[told <= i], told[told >= i]
        low = before[-1] if len(before) else after[0]
        high = after[0] if len(after) else low
        share = (i - low) / (high - low) if high > low else 0.0
        line = own[low] + share * (own[high] - own[low])
        sure = min(gains[i] / half, 1.0)
        assert found[i] == pytest.approx(sure * own[i] + (1.0 - sure) * line, abs=1e-9)


def test_a_constraint_holds_the_sample_nearest_to_it() -> None:
    bone = fishbone_of(corner(1.0), np.linspace(0.0, 1.0, 11).tolist(), 0.5)
    rows = find_held_rows(bone, [(3, bone.points[3, 17] + 1e-4), (99, (0.0, 0.0, 0.0))])
    assert rows[3] == 17 and (np.delete(rows, 3) == -1).all()


def test_what_is_no_fishbone_is_told() -> None:
    bone = fishbone_of(corner(1.0), [0.0, 1.0], 0.5)
    with pytest.raises(InvalidFeatureError, match="none of the 2 ribs"):
        Fishbone.from_ribs([None, None])
    holed = bone.valid.copy()
    holed[1, 30] = False
    with pytest.raises(InvalidFeatureError, match="rib 1 are not one run"):
        Fishbone(bone.points, bone.normals, holed, bone.backbone, bone.ribs, bone.origins)
    with pytest.raises(InvalidFeatureError, match="window"):
        curvature(bone, 0.0)
    with pytest.raises(InvalidFeatureError, match="nearness"):
        find_terms(bone, 0.1, 0.0, (0.0, 0.0, 1.0), 0.0)
    with pytest.raises(InvalidFeatureError, match="axis"):
        isophote(bone, (0.0, 0.0, 0.0), 0.0)
    with pytest.raises(InvalidFeatureError, match="angle"):
        isophote(bone, (0.0, 0.0, 1.0), 4.0)
    with pytest.raises(InvalidFeatureError, match="alpha"):
        tau(find_terms(bone, 0.1, 1.0, (0.0, 0.0, 1.0), 0.0), 1.5)
