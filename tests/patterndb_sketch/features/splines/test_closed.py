"""Closed feature curves: one stroke that comes back to its start."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import (
    SplineModel,
    read_curves,
    read_network,
    write_curves,
    write_network,
)
from patterndb_sketch.features.files.strokesjson import read_strokes, write_strokes
from patterndb_sketch.features.fishbone import cut, track_crease
from patterndb_sketch.features.initial import find_initial_curve, is_ring
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from patterndb_sketch.features.snap import Snap, SnapSettings, snap
from patterndb_sketch.features.splines import Spline, fit_spline
from patterndb_sketch.features.strokes import FeatureStroke, recover_curve
from tests.patterndb_sketch.features.fishbone.test_tracking import price
from tests.support.features.rings import can, rim, ring, top, torus

CASES = {"cylinder": (can, rim), "torus": (torus, top)}


def around(points: Points) -> Points:
    """A ring's points with the first at the end again."""
    return np.concatenate([points, points[:1]])


@pytest.fixture(scope="module", params=list(CASES))
def case(request: pytest.FixtureRequest) -> tuple[Surface, Points]:
    """A model and its crease, which goes round."""
    make, crease = CASES[request.param]
    return make(), crease()


def assert_smooth(spline: Spline) -> None:
    """Closed, and differentiable where its period begins as anywhere else: the second derivative,
    too, for a cubic with simple knots."""
    low, high = spline.domain
    assert spline.closed and (spline.evaluate(low) == spline.evaluate(high)).all()
    for order in range(spline.degree):
        before, after = (spline.derivative(low + s * 1e-9, order) for s in (-1.0, 1.0))
        rise = np.abs(spline.derivative(np.linspace(low, high, 500), order + 1)).max()
        assert np.abs(after - before).max() <= 2e-9 * rise * (1.0 + 1e-6) + 1e-12


def test_a_ring_is_found(case: tuple[Surface, Points]) -> None:
    """All the way round on the crease: off by less than a rib's samples are apart, and at the
    joint no more than elsewhere."""
    model, crease = case
    stroke = ring(model, crease, 9, 0.0, 0.03)
    found = snap(model, around(stroke))
    assert_smooth(found.spline)
    assert found.notes == () and found.failed == ()
    spacing = 2.0 * found.settings.radius * model.diagonal / (found.settings.n_samples - 1)
    along = found.spline.sample(2001)
    assert KDTree(crease).query(along)[0].max() < spacing
    assert KDTree(along).query(crease)[0].max() < spacing
    sketch = find_initial_curve(model, around(stroke)).samples
    assert KDTree(crease).query(sketch)[0].max() > 5.0 * spacing
    assert model.measure_distances(found.samples).max() < 1e-9
    # Each sample is there once, and the last is as far from the first as others are.
    steps = np.linalg.norm(np.diff(around(found.samples), axis=0), axis=1)
    assert 0.5 * np.median(steps) < steps.min() and steps.max() < 2.0 * np.median(steps)


@pytest.mark.parametrize("start", [1, 4, 7])
def test_it_does_not_matter_where_a_stroke_begins(case: tuple[Surface, Points], start: int) -> None:
    """The same clicks from another one on: the same curve, up to half a rib's sampling; and
    the other way round."""
    model, crease = case
    stroke = ring(model, crease, 9, 0.0, 0.03)
    found = snap(model, around(stroke))
    spacing = 2.0 * found.settings.radius * model.diagonal / (found.settings.n_samples - 1)
    tree = KDTree(found.spline.sample(20_001))
    for other in (np.roll(stroke, -start, axis=0), np.roll(stroke, -start, axis=0)[::-1]):
        again = snap(model, around(other)).spline
        assert tree.query(again.sample(1001))[0].max() < spacing
        assert again.length == pytest.approx(found.spline.length, rel=1e-3)


def test_pins_are_met_exactly_wherever_they_are(case: tuple[Surface, Points]) -> None:
    """Next to the joint, too: the pin pulls what is on either side of it alike."""
    model, crease = case
    stroke = around(ring(model, crease, 9, 0.0, 0.02))
    free = Snap.begin(model, stroke)
    m = len(free.curve.samples)
    outside = np.array([1.03, 1.03, 1.0])
    for pins in ((0,), (m - 1,), (0, m - 1), (m // 2,)):
        places = model.nearest(free.curve.samples[list(pins)] * outside - [0, 0, 0.03]).points
        held = tuple(zip(pins, places, strict=True))
        for pinned in (
            snap(model, stroke, constraints=held),
            free.with_constraints(held).curve,
            Snap.begin(model, stroke, constraints=held).again().curve,
        ):
            assert_smooth(pinned.spline)
            met = pinned.spline.evaluate(pinned.parameters[list(pins)])
            assert np.abs(met - places).max() < 1e-9
            assert (pinned.samples[list(pins)] == places).all()


def test_a_stroke_is_closed_by_its_ends_or_as_it_says() -> None:
    """The first point again closes it; nearly the first does not; what is said comes first."""
    model = can()
    stroke = ring(model, rim(), 9, 0.0, 0.02)
    nearly = np.concatenate([stroke, stroke[:1] + np.array([0.0, 1e-4, 0.0])])
    assert is_ring(around(stroke)) and is_ring(around(stroke) + 1e-15 * np.arange(10)[:, None])
    assert not is_ring(stroke) and not is_ring(nearly)
    assert not is_ring(stroke[[0, 1, 0]])
    for points, said, closed in (
        (around(stroke), None, True),
        (around(stroke), False, False),
        (stroke, None, False),
        (stroke, True, True),
        (nearly, None, False),
    ):
        found = snap(model, points, closed=said)
        assert found.spline.closed == closed
    one, other = (snap(model, points, closed=True) for points in (stroke, around(stroke)))
    assert (one.spline.control == other.spline.control).all()
    for few in (stroke[:2], stroke[[0, 1, 0, 1]][:3]):
        with pytest.raises(InvalidFeatureError, match="closed curve needs at least 3 places"):
            snap(model, few, closed=True)


def test_settings_of_a_closed_curve_are_changed(case: tuple[Surface, Points]) -> None:
    """It stays closed under every setting, degree and price of moving."""
    model, crease = case
    begun = Snap.begin(model, around(ring(model, crease, 9, 0.0, 0.02)))
    for changed in (
        SnapSettings(degree=2),
        SnapSettings(degree=5),
        SnapSettings(strict=True),
        SnapSettings(continuity=0.0),
        SnapSettings(alpha=0.0),
        SnapSettings(rounds=2),
    ):
        snapped = begun.with_settings(changed)
        assert_smooth(snapped.curve.spline)
        assert len(snapped.curve.samples) == len(begun.curve.samples)


def test_files_and_sessions_keep_curves_closed(tmp_path: Path) -> None:
    """Strokes, curves, networks and sessions are read back as they were written; a session's
    curve that is closed is found again, and so is one that was opened."""
    model = can()
    stroke = ring(model, rim(), 9, 0.0, 0.02)
    strokes = [
        FeatureStroke("by ends", around(stroke)),
        FeatureStroke("said", stroke, closed=True),
        FeatureStroke("opened", around(stroke), closed=False),
        FeatureStroke("open", stroke),
    ]
    write_strokes(tmp_path / "strokes.json", strokes)
    again = read_strokes(tmp_path / "strokes.json")
    assert [one.closed for one in again] == [None, True, False, None]
    found = [recover_curve(model, one) for one in again]
    assert [one.curve.spline.closed for one in found] == [True, True, False, False]
    write_curves(tmp_path / "curves.json", found)
    for one, other in zip(found, read_curves(tmp_path / "curves.json"), strict=True):
        assert SplineModel.of(one.curve.spline) == SplineModel.of(other.curve.spline)
        assert (one.curve.parameters == other.curve.parameters).all()
    network = read_network(tmp_path / "curves.json")
    write_network(tmp_path / "network.json", network)
    for name, spline in read_network(tmp_path / "network.json").curves.items():
        assert SplineModel.of(spline) == SplineModel.of(network.curves[name])
    session = FeatureSession("can.obj").with_curves(found, SnapSettings())
    FEATURE_SESSION.write(tmp_path / "a.session", session)
    again = FEATURE_SESSION.read(tmp_path / "a.session").curves
    for one, kept in zip(found, again, strict=True):
        curve = recover_curve(model, kept.stroke, kept.constraints).curve
        assert (curve.spline.control == one.curve.spline.control).all()
    ring_ = {"curves": {"rim": rim()[::40].tolist()}}
    (tmp_path / "polyline.json").write_text(json.dumps(ring_))
    spline = read_network(tmp_path / "polyline.json").curves["rim"]
    assert_smooth(spline)
    assert KDTree(rim()).query(spline.sample(500))[0].max() < 3e-3
    assert isinstance(read_network(tmp_path / "polyline.json"), FeatureCurves)


def round_price(rows: tuple[int, ...], seam: int, costs: np.ndarray, *rest: object) -> float:
    """What rows that go round cost: those of the unrolled ribs, the first of them counted once."""
    m, k = costs.shape
    wide = np.full((m + 1, k + 2 * abs(seam)), np.inf)
    begin = abs(seam)
    wide[:m, begin : begin + k] = costs
    wide[m, begin - seam : begin - seam + k] = 0.0
    cross, bends, change, reach = rest
    turned = np.zeros((*wide.shape, 3))
    turned[:m, begin : begin + k] = bends
    turned[m, begin - seam : begin - seam + k] = np.asarray(bends)[0]
    shifted = (*(row + begin for row in rows), rows[0] + begin - seam)
    return price(shifted, wide, cross, turned, change, reach)  # type: ignore[arg-type]


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6))
def test_no_way_round_is_cheaper(seed: int) -> None:
    """Of all rows, with holes and whatever rows the seam shifts by; with no price of change it is
    the cut."""
    rng = np.random.default_rng(seed)
    m, k = int(rng.integers(1, 5)), int(rng.integers(1, 6))
    costs = rng.random((m, k))
    costs[rng.random((m, k)) < 0.2] = np.inf
    costs[np.arange(m), rng.integers(0, k, m)] = rng.random(m)
    cross = rng.random(m) * rng.choice([0.05, 0.5])
    bends = rng.normal(size=(m, k, 3))
    seam = int(rng.integers(-3, 4))
    reach = rng.integers(0, 4, m)
    for change in (0.0, 0.2, 1.0):
        found = track_crease(costs, cross, bends, change, reach, seam)
        rest = (cross, bends, change, reach)
        every = [
            round_price(rows, seam, costs, *rest)
            for rows in product(range(k), repeat=m)
            if np.isfinite(costs[np.arange(m), list(rows)]).all()
        ]
        assert found.cost == pytest.approx(min(every), abs=1e-12)
        own = round_price(tuple(found.rows.tolist()), seam, costs, *rest)
        assert own == pytest.approx(min(every), abs=1e-12)
    wide = np.full(m, k + 9)
    plain = cut(costs, cross, seam)
    same = track_crease(costs, cross, bends, 0.0, wide, seam)
    assert plain.cost == pytest.approx(same.cost, abs=1e-12)


def circle(turn: np.ndarray) -> Points:
    return np.stack([np.cos(turn), np.sin(turn), 0.3 * np.sin(3.0 * turn)], axis=1)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(0, 3))
def test_closed_splines_are_smooth_and_meet_constraints(
    seed: int, degree: int, n_held: int
) -> None:
    """Whatever the parameters' spacing and wherever constraints are; errors never rise."""
    rng = np.random.default_rng(seed)
    m = int(rng.integers(12, 90))
    turn = np.cumsum(rng.uniform(0.05, 1.0, m) ** rng.integers(1, 4))
    turn *= 2.0 * np.pi / (turn[-1] + 0.3)
    samples = circle(turn) + 0.01 * rng.normal(size=(m, 3))
    numbers = rng.choice(m, n_held, replace=False).tolist()
    held = [(i, samples[i] + 0.05 * rng.normal(size=3)) for i in numbers]
    fit = fit_spline(samples, degree=degree, constraints=held, closed=True)
    assert_smooth(fit.spline)
    assert fit.residual < 1e-9 and (np.diff(fit.errors) < 0.0).all()
    for number, place in held:
        assert fit.spline.evaluate(fit.parameters[number])[0] == pytest.approx(place, abs=1e-9)
    assert (np.diff(fit.parameters) >= 0.0).all() and np.ptp(fit.parameters) < 1.0
    written = SplineModel.of(fit.spline)
    assert SplineModel.of(written.spline()) == written


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(3, 12))
def test_a_closed_spline_is_the_open_one_of_its_unrolled_period(
    seed: int, degree: int, n: int
) -> None:
    """Evaluation, derivatives, arc length: against the same pieces written out with ends."""
    rng = np.random.default_rng(seed)
    knots = np.r_[0.0, np.cumsum(rng.uniform(0.1, 1.0, n))]
    control = rng.normal(size=(n, 3))
    spline = Spline(degree, knots, control, closed=True)
    period = knots[-1]
    long = np.concatenate([knots[:-1] + turn * period for turn in range(-8, 10)])
    begin = 8 * n - degree
    written = BSpline(
        long[begin : begin + n + 2 * degree + 1],
        control[np.arange(n + degree) % n],
        degree,
        extrapolate=False,
    )
    t = rng.uniform(0.0, period, 30)
    for order in range(degree + 1):
        assert spline.derivative(t, order) == pytest.approx(
            written.derivative(order)(t) if order else written(t), abs=1e-9 * (10.0**order)
        )
        turned = spline.derivative(t + 3.0 * period, order)
        assert turned == pytest.approx(spline.derivative(t, order), abs=1e-7 * (10.0**order))
    fine = spline.evaluate(np.linspace(0.0, period, 40_001))
    length = np.linalg.norm(np.diff(fine, axis=0), axis=1).sum()
    assert spline.length == pytest.approx(length, rel=1e-3)


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: Spline(3, [0, 1, 2], np.eye(3)[:2], closed=True), "at least 3"),
        (lambda: Spline(3, [0, 1, 2], np.eye(3), closed=True), "needs 4 knots, of one period"),
        (lambda: Spline(3, [0, 0, 0, 0], np.eye(3), closed=True), "period has no length"),
        (lambda: Spline(3, [0, 2, 1, 3], np.eye(3), closed=True), "ascend"),
        (lambda: Spline(1, [0, 1, 1, 2], np.eye(3), closed=True), "break apart"),
    ],
)
def test_what_is_no_closed_spline_is_refused(make: Callable[[], Spline], what: str) -> None:
    with pytest.raises(InvalidFeatureError, match=what):
        make()
