"""Curve networks: curves drawn one by one meet exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.registration import CurveJoint, resolve_network
from patterndb_sketch.features.registration.curvenetwork import (
    extend_curve,
    find_approaches,
    find_foot,
)
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


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_the_closest_approach_is_the_least_distance(seed: int) -> None:
    """Against another solver, started from the best of a million pairs."""
    rng = np.random.default_rng(seed)
    a, b = random_curve(rng), random_curve(rng)
    found = find_approaches(a, b, np.inf)[0]
    s, t = np.linspace(*a.domain, 1000), np.linspace(*b.domain, 1000)
    away = np.linalg.norm(a(s)[:, None] - b(t)[None], axis=2)
    i, j = np.unravel_index(away.argmin(), away.shape)

    def square(at: np.ndarray) -> float:
        return float(((a(at[0])[0] - b(at[1])[0]) ** 2).sum())

    best = minimize(square, [s[i], t[j]], bounds=[a.domain, b.domain], tol=1e-15)
    assert found.gap <= np.sqrt(best.fun) + 1e-6
    assert found.gap == pytest.approx(np.linalg.norm(found.points[0] - found.points[1]))
    assert a(found.parameters[0])[0] == pytest.approx(found.points[0])


def test_curves_that_cross_twice_approach_twice() -> None:
    x = np.linspace(-1.0, 1.0, 60)
    parabola = spline_through(np.c_[x, x**2, 0 * x])
    line = spline_through(np.array([[-1, 0.25, 0.01], [1, 0.25, 0.01]], float))
    found = find_approaches(parabola, line, 0.05)
    assert sorted(round(one.middle[0], 6) for one in found) == [-0.5, 0.5]
    assert all(one.gap == pytest.approx(0.01) for one in found)
    assert found[0].sine == pytest.approx(np.sqrt(0.5), abs=1e-4)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.01, 1.0))
def test_a_curve_drawn_out_is_itself_and_straight_beyond(seed: int, by: float) -> None:
    curve = random_curve(np.random.default_rng(seed))
    longer = extend_curve(curve, by)
    t = np.linspace(*curve.domain, 101)
    assert longer(t) == pytest.approx(curve(t), abs=1e-9)
    assert longer.length == pytest.approx(curve.length + 2.0 * by, rel=1e-4)
    for end, start in zip(longer.domain, curve.domain, strict=True):
        piece = longer(np.linspace(start, end, 9))
        steps = np.diff(piece, axis=0)
        assert np.linalg.norm(np.cross(steps, curve.tangent(start)), axis=1).max() < 1e-9
        assert np.linalg.norm(piece[-1] - piece[0]) == pytest.approx(by)


def test_a_foot_is_the_nearest_point() -> None:
    rng = np.random.default_rng(5)
    curve = random_curve(rng)
    dense = curve(np.linspace(*curve.domain, 200_001))
    for point in rng.normal(size=(20, 3)):
        near = np.linalg.norm(dense - point, axis=1).min()
        assert np.linalg.norm(curve(find_foot(curve, point))[0] - point) <= near + 1e-9


@pytest.mark.parametrize("beyond", [0.1, 0.0, -0.015], ids=["too long", "as long", "too short"])
def test_endpoints_are_the_pairwise_intersections_and_coincide(beyond: float) -> None:
    """Bit for bit: their end control points are one; and it is the corner, also of short curves."""
    network = resolve_network(rim(beyond=beyond), CORNERS)
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
    network = resolve_network(three_lines(), [THREE, *OUT], tolerance=0.1)
    assert network.nodes["three"] == pytest.approx([0.0, 0.0, (0.01 + 0.03 + 0.04) / 3], abs=1e-7)
    assert network.gaps["three"] == pytest.approx(0.06)
    for name in "abc":
        ends = network.curves[name].control[[0, -1]]
        assert any(np.array_equal(end, network.nodes["three"]) for end in ends)


def test_a_joint_that_two_of_its_curves_decide_draws_the_third_up() -> None:
    network = resolve_network(
        three_lines(), [THREE, *OUT], tolerance=0.1, meet={"three": ("a", "b")}
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
    network = resolve_network(curves, joints)
    assert network.nodes["middle"] == pytest.approx([0.01, 0.0, 0.0], abs=1e-7)


def test_every_corner_of_a_car_is_found() -> None:
    """By names alone, to 2 mm: curves are splines through samples. Inner corners lie on curves."""
    template = car_template()
    curves = car_curves()
    network = resolve_network(curves, template.joints(list(curves)), plane=template.in_plane())
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
        resolve_network({name: short[name] for name in ("south", "east", "west")}, CORNERS)
    high = short | {"north": rim(height=0.3)["north"]}
    with pytest.raises(InvalidFeatureError, match=r"at ne.*pass each other at 0\.3.*tolerance"):
        resolve_network(high, CORNERS)
    with pytest.raises(InvalidFeatureError, match="no joint 'up'"):
        resolve_network(short, CORNERS, near={"up": [0, 0, 0]})
    with pytest.raises(InvalidFeatureError, match="the point near se"):
        resolve_network(short, CORNERS, near={"se": np.eye(3)})
    with pytest.raises(InvalidFeatureError, match="no joint 'up'"):
        resolve_network(short, CORNERS, meet={"up": ("south", "east")})
    with pytest.raises(InvalidFeatureError, match="two or more of the curves south, east"):
        resolve_network(short, CORNERS, meet={"se": ("south", "west")})
    with pytest.raises(InvalidFeatureError, match="south ends at se alone"):
        resolve_network(short, CORNERS[:1])
    with pytest.raises(InvalidFeatureError, match="in the plane y = 0"):
        resolve_network(short, CORNERS, plane=((), ("ne",)))


def test_curves_that_meet_twice_ask_where() -> None:
    x = np.linspace(-1.0, 1.0, 60)
    curves = {
        "bow": spline_through(np.c_[x, x**2, 0 * x]),
        "line": spline_through(np.array([[-1, 0.25, 0], [1, 0.25, 0]], float)),
    }
    ends = [CurveJoint("left", ("bow", "line")), CurveJoint("right", ("bow", "line"))]
    with pytest.raises(InvalidFeatureError, match="give a point near left"):
        resolve_network(curves, ends)
    network = resolve_network(curves, ends, near={"left": [-1, 0, 0], "right": [1, 0, 0]})
    assert network.nodes["left"] == pytest.approx([-0.5, 0.25, 0.0], abs=1e-6)
    assert network.nodes["right"] == pytest.approx([0.5, 0.25, 0.0], abs=1e-6)
    assert network.curves["line"].length == pytest.approx(1.0, abs=1e-6)
