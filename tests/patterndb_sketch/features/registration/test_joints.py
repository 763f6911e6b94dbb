"""Feature curves that are drawn one by one meet exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial import KDTree

from patterndb_sketch.curvenetwork.crossings import ClosestPlaces, find_closest_places
from patterndb_sketch.curvenetwork.polylines import pack_curves
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.registration import CurveJoint, FeatureCurves, join_features
from patterndb_sketch.features.registration.joints import DrawnLine
from patterndb_sketch.features.splines import Spline
from tests.support.features.registration import car, car_curves, car_template, rim

CORNERS = (
    CurveJoint("se", ("south", "east")),
    CurveJoint("ne", ("east", "north")),
    CurveJoint("nw", ("north", "west")),
    CurveJoint("sw", ("west", "south")),
)


def random_curve(rng: np.random.Generator, n: int = 6) -> Spline:
    points = np.cumsum(rng.normal(size=(n, 3)), axis=0)
    return spline_through(points)


def find_closest(one: Spline, other: Spline, reach: float) -> ClosestPlaces:
    lines = [DrawnLine.of(curve, 0.0).drawn for curve in (one, other)]
    return find_closest_places(pack_curves(lines), reach)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_the_closest_places_have_the_least_distance(seed: int) -> None:
    """Against another solver, started from the best of a million pairs."""
    rng = np.random.default_rng(seed)
    a, b = random_curve(rng), random_curve(rng)
    found = find_closest(a, b, np.inf)
    s, t = np.linspace(*a.domain, 1000), np.linspace(*b.domain, 1000)
    away = np.linalg.norm(a(s)[:, None] - b(t)[None], axis=2)
    i, j = np.unravel_index(away.argmin(), away.shape)

    def square(at: np.ndarray) -> float:
        return float(((a(at[0])[0] - b(at[1])[0]) ** 2).sum())

    best = minimize(square, [s[i], t[j]], bounds=[a.domain, b.domain], tol=1e-15)
    assert found.gaps[0] == pytest.approx(np.sqrt(best.fun), abs=2e-4)
    assert found.gaps[0] == pytest.approx(np.linalg.norm(np.diff(found.points[0], axis=0)))


def test_curves_that_cross_twice_are_closest_twice() -> None:
    x = np.linspace(-1.0, 1.0, 60)
    parabola = spline_through(np.c_[x, x**2, 0 * x])
    line = spline_through(np.array([[-1, 0.25, 0.01], [1, 0.25, 0.01]], float))
    found = find_closest(parabola, line, 0.05)
    assert sorted(np.round(found.middles[:, 0], 6)) == [-0.5, 0.5]
    assert found.gaps == pytest.approx(0.01)
    assert found.sines[0] == pytest.approx(np.sqrt(0.5), abs=1e-4)


def test_an_end_is_closest_where_the_other_curve_is_nearest_to_it() -> None:
    """At a sample of the other curve, within an edge, and at its end."""
    x = np.linspace(-1.0, 1.0, 21)
    line = np.c_[x, 0 * x, 0 * x]
    for at in (0.2, 0.23, 1.0):
        short = np.array([[at, 1.0, 0.0], [at, 0.5, 0.0], [at, 0.01, 0.0]])
        found = find_closest_places(pack_curves([line, short]), 0.05)
        assert found.middles == pytest.approx(np.array([[at, 0.005, 0.0]]))
        assert found.lengths == pytest.approx(np.array([[1.0 + at, 0.99]]))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.01, 1.0))
def test_a_line_is_its_curve_and_straight_beyond(seed: int, by: float) -> None:
    curve = random_curve(np.random.default_rng(seed))
    line = DrawnLine.of(curve, by)
    inside = line.locate(np.linspace(by, line.length - by, 101))
    dense = KDTree(curve(np.linspace(*curve.domain, 100_001)))
    assert dense.query(inside)[0].max() < 1e-3
    assert line.length == pytest.approx(curve.length + 2.0 * by, rel=1e-4)
    for end, beyond in zip(curve.domain, (0.0, line.length), strict=True):
        inner = by if beyond == 0.0 else line.length - by
        piece = line.locate(np.linspace(inner, beyond, 9))
        steps = np.diff(piece, axis=0)
        assert np.linalg.norm(np.cross(steps, curve.tangent(end)), axis=1).max() < 1e-4
        assert np.linalg.norm(piece[-1] - piece[0]) == pytest.approx(by)


def test_a_foot_is_the_nearest_point() -> None:
    rng = np.random.default_rng(5)
    line = DrawnLine.of(random_curve(rng), 0.0)
    dense = line.spline(np.linspace(*line.spline.domain, 200_001))
    for point in rng.normal(size=(20, 3)):
        near = np.linalg.norm(dense - point, axis=1).min()
        foot = line.locate(np.array([line.find_foot(point)]))[0]
        assert np.linalg.norm(foot - point) <= near + 3e-5


@pytest.mark.parametrize("beyond", [0.1, 0.0, -0.015], ids=["too long", "as long", "too short"])
def test_endpoints_are_the_pairwise_intersections_and_coincide(beyond: float) -> None:
    """Bit for bit: their end control points are one; and it is the corner, also of short curves."""
    network = join_features(FeatureCurves(rim(beyond=beyond)), CORNERS)
    for joint in CORNERS:
        node = network.nodes[joint.name]
        for name in joint.curves:
            ends = network.curves[name].control[[0, -1]]
            assert any(np.array_equal(end, node) for end in ends)
    assert network.nodes["ne"] == pytest.approx([0.5, 0.5, 0.0], abs=1e-6)
    assert network.curves["south"].length == pytest.approx(1.0, abs=1e-6)


def three_lines() -> dict[str, Spline]:
    """Three lines that pass over one place at different heights, and an arc across them."""
    curves: dict[str, Spline] = {}
    for name, height, degrees in (("a", 0.0, 0.0), ("b", 0.02, 60.0), ("c", 0.06, 120.0)):
        along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
        curves[name] = spline_through(np.outer([-1.0, 1.0], along) + np.array([0, 0, height]))
    turn = np.radians(np.linspace(-20.0, 140.0, 60))
    arc = np.stack([0.8 * np.cos(turn), 0.8 * np.sin(turn), 0.02 + 0.0 * turn], axis=1)
    return curves | {"arc": spline_through(arc)}


THREE = CurveJoint("three", ("a", "b", "c"))
OUT = tuple(CurveJoint(f"{name}_out", (name, "arc")) for name in "abc")


def test_three_curves_meet_in_the_mean_of_the_three_intersections() -> None:
    """Of two lines, one over the other, the intersection is halfway between them."""
    network = join_features(FeatureCurves(three_lines(), tolerance=0.1), [THREE, *OUT])
    assert network.nodes["three"] == pytest.approx([0.0, 0.0, (0.01 + 0.03 + 0.04) / 3], abs=1e-7)
    assert network.gaps["three"] == pytest.approx(0.06)
    for name in "abc":
        ends = network.curves[name].control[[0, -1]]
        assert any(np.array_equal(end, network.nodes["three"]) for end in ends)


def test_a_joint_that_two_of_its_curves_decide_draws_the_third_up() -> None:
    network = join_features(
        FeatureCurves(three_lines(), {"three": ("a", "b")}, tolerance=0.1), [THREE, *OUT]
    )
    assert network.nodes["three"] == pytest.approx([0.0, 0.0, 0.01], abs=1e-7)
    ends = network.curves["c"].control[[0, -1]]
    assert any(np.array_equal(end, network.nodes["three"]) for end in ends)


def test_curves_that_run_on_into_each_other_do_not_say_where() -> None:
    """Two overlap by much; the third alone says where along them the joint is."""
    curves = {
        "left": spline_through(np.array([[-1, 0, 0], [0.08, 0, 0]], float)),
        "right": spline_through(np.array([[-0.08, 0.0, 0.0], [1, 0, 0]])),
        "across": spline_through(np.array([[0.01, -1, 0], [0.01, 1, 0]])),
        "first": spline_through(np.array([[-0.9, -1, 0], [-0.9, 1, 0]])),
        "last": spline_through(np.array([[0.9, -1, 0], [0.9, 1, 0]])),
        "low": spline_through(np.array([[-1, -0.9, 0], [1, -0.9, 0]])),
    }
    joints = [
        CurveJoint("middle", ("left", "right", "across")), CurveJoint("one", ("left", "first")),
        CurveJoint("two", ("right", "last")), CurveJoint("below", ("across", "low")),
        CurveJoint("f", ("first", "low")), CurveJoint("l", ("last", "low")),
    ]  # fmt: skip
    network = join_features(FeatureCurves(curves), joints)
    assert network.nodes["middle"] == pytest.approx([0.01, 0.0, 0.0], abs=1e-7)


def test_every_corner_of_a_car_is_found() -> None:
    """By names alone, to 2 mm: curves are splines through samples. Inner corners lie on curves."""
    template = car_template()
    curves = car_curves()
    network = join_features(
        FeatureCurves(curves), template.joints(list(curves)), template.in_plane()
    )
    assert set(network.nodes) == set(car().corners)
    for name, node in network.nodes.items():
        assert node == pytest.approx(car().corners[name], abs=2e-3)
    for (curve, corner), t in network.parameters.items():
        assert network.curves[curve](t)[0] == pytest.approx(network.nodes[corner], abs=1e-9)
    for name in template.in_plane()[0] & set(curves):
        assert not network.curves[name].control[:, 1].any()


def test_refused_networks_say_what_would_mend_them() -> None:
    short = rim()
    with pytest.raises(InvalidFeatureError, match="lacks the curves north"):
        join_features(
            FeatureCurves({name: short[name] for name in ("south", "east", "west")}), CORNERS
        )
    high = short | {"north": rim(height=0.3)["north"]}
    with pytest.raises(InvalidFeatureError, match=r"at ne.*pass each other at 0\.3.*tolerance"):
        join_features(FeatureCurves(high), CORNERS)
    with pytest.raises(InvalidFeatureError, match="no joint 'up'"):
        join_features(FeatureCurves(short, near={"up": [0, 0, 0]}), CORNERS)
    with pytest.raises(InvalidFeatureError, match="the point near se"):
        join_features(FeatureCurves(short, near={"se": np.eye(3)}), CORNERS)
    with pytest.raises(InvalidFeatureError, match="no joint 'up'"):
        join_features(FeatureCurves(short, meet={"up": ("south", "east")}), CORNERS)
    with pytest.raises(InvalidFeatureError, match="two or more of the curves south, east"):
        join_features(FeatureCurves(short, meet={"se": ("south", "west")}), CORNERS)
    with pytest.raises(InvalidFeatureError, match="south ends at se alone"):
        join_features(FeatureCurves(short), CORNERS[:1])
    with pytest.raises(InvalidFeatureError, match="in the plane y = 0"):
        join_features(FeatureCurves(short), CORNERS, ((), ("ne",)))


def test_curves_that_meet_twice_ask_where() -> None:
    x = np.linspace(-1.0, 1.0, 60)
    curves = {
        "bow": spline_through(np.c_[x, x**2, 0 * x]),
        "line": spline_through(np.array([[-1, 0.25, 0], [1, 0.25, 0]], float)),
    }
    ends = [CurveJoint("left", ("bow", "line")), CurveJoint("right", ("bow", "line"))]
    with pytest.raises(InvalidFeatureError, match="give a point near left"):
        join_features(FeatureCurves(curves), ends)
    network = join_features(
        FeatureCurves(curves, near={"left": [-1, 0, 0], "right": [1, 0, 0]}), ends
    )
    assert network.nodes["left"] == pytest.approx([-0.5, 0.25, 0.0], abs=1e-6)
    assert network.nodes["right"] == pytest.approx([0.5, 0.25, 0.0], abs=1e-6)
    assert network.curves["line"].length == pytest.approx(1.0, abs=1e-6)
