"""Snapping: from a rough stroke to the feature beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from bodies import body, degrade, stroke
from scipy.spatial import KDTree

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.snap import Snap, SnapSettings, snap


def swept(
    profile: Points, along: Points, bend: Callable[[Points], Points] | None = None
) -> Surface:
    """A profile (k, 2) of y and z, swept over places (n,) of x, then bent."""
    k, n = len(profile), len(along)
    points = np.array([(x, y, z) for x in along for y, z in profile])
    i, j = np.meshgrid(np.arange(n - 1), np.arange(k - 1), indexing="ij")
    a = (i * k + j).ravel()
    triangles = np.concatenate([np.c_[a, a + k, a + 1], np.c_[a + 1, a + k, a + k + 1]])
    return Surface.from_soup(
        PolygonMesh.from_faces(points if bend is None else bend(points), triangles)
    )


def hat(count: int = 21) -> Points:
    """A profile with its ridge at y = 0, rounded: y, z."""
    y = np.r_[np.linspace(-1.0, -0.06, count), np.linspace(-0.05, 0.05, 9)]
    y = np.r_[y, np.linspace(0.06, 1.0, count)]
    return np.stack([y, -0.7 * np.sqrt(y**2 + 0.02**2)], axis=1)


def wave(points: Points) -> Points:
    """The ridge of :func:`hat` along y = 0.15 sin(1.5 x)."""
    moved = points.copy()
    moved[:, 1] += 0.15 * np.sin(1.5 * moved[:, 0])
    return moved


def off_ridge(points: Points) -> float:
    return float(np.abs(points[:, 1] - 0.15 * np.sin(1.5 * points[:, 0])).mean())


@pytest.fixture(scope="module")
def ridge() -> Surface:
    return swept(hat(), np.linspace(0.0, 4.0, 61), wave)


@pytest.fixture(scope="module")
def drawn(ridge: Surface) -> Points:
    """A stroke beside the ridge."""
    x = np.array([0.3, 1.0, 1.8, 2.6, 3.2, 3.7])
    y = 0.15 * np.sin(1.5 * x) + np.array([0.05, -0.04, 0.05, 0.03, -0.05, 0.04])
    return ridge.nearest(np.stack([x, y, np.zeros(6)], axis=1)).points


@pytest.fixture(scope="module")
def begun(ridge: Surface, drawn: Points) -> Snap:
    return Snap.begin(ridge, drawn)


def test_a_ridge_is_found(ridge: Surface, drawn: Points, begun: Snap) -> None:
    """A tenth of the stroke's own error is left; samples are on the model."""
    sketched = off_ridge(find_initial_curve(ridge, drawn).samples)
    assert off_ridge(begun.curve.spline.sample(200)) < 0.1 * sketched
    assert ridge.measure_distances(begun.curve.samples).max() < 1e-9
    assert begun.curve.failed == () and begun.curve.notes == ()


@pytest.mark.parametrize(("radius", "window"), [(0.02, 0.003), (0.03, 0.003)])
def test_the_edge_of_a_rounded_box_is_found(radius: float, window: float) -> None:
    """Its middle, where nothing but the window tells it from the rest of the rounding."""
    turn = np.linspace(0.0, np.pi / 2.0, 9)
    arc = 1.0 - radius + radius * np.stack([np.sin(turn), np.cos(turn)], axis=1)
    profile = np.concatenate([[[0.0, 1.0], [0.4, 1.0]], arc, [[1.0, 0.4], [1.0, 0.0]]])
    box = swept(profile, np.linspace(0.0, 3.0, 16))
    apex = np.array([1.0, 1.0]) * (1.0 - radius + radius * np.sqrt(0.5))
    x, off = np.linspace(0.3, 2.7, 6), np.array([0.06, 0.05, -0.04, -0.05, 0.03, -0.02])
    rough = np.stack([x, 1.0 - np.maximum(off, 0.0), 1.0 + np.minimum(off, 0.0)], axis=1)
    found = snap(box, rough, SnapSettings(window=window)).spline.sample(200)
    own = np.linalg.norm(find_initial_curve(box, rough).samples[:, 1:] - apex, axis=1)
    assert np.linalg.norm(found[:, 1:] - apex, axis=1).mean() < 0.25 * own.mean()


def test_a_ridge_around_a_bumpy_cylinder_is_found() -> None:
    """Bumps of the surface are wide, the ridge around it narrow: it is the ridge that is found."""
    turn = np.linspace(0.0, 1.2 * np.pi, 91)
    z = np.r_[
        np.linspace(-1.0, -0.25, 12), np.linspace(-0.24, 0.24, 41), np.linspace(0.25, 1.0, 12)
    ]
    t, h = np.meshgrid(turn, z, indexing="ij")
    at = 0.1 * np.sin(2.0 * t)
    radius = 1.0 + 0.02 * np.sin(5.0 * t) * np.cos(4.0 * h) + 0.1 / (1.0 + ((h - at) / 0.04) ** 2)
    points = np.stack([radius * np.cos(t), radius * np.sin(t), h], axis=2).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(90), np.arange(len(z) - 1), indexing="ij")
    a, k = (i * len(z) + j).ravel(), len(z)
    model = Surface.from_soup(
        PolygonMesh.from_faces(
            points, np.concatenate([np.c_[a, a + k, a + 1], np.c_[a + 1, a + k, a + k + 1]])
        )
    )

    def off(curve: Points) -> float:
        angle = np.arctan2(curve[:, 1], curve[:, 0]) % (2.0 * np.pi)
        return float(np.abs(curve[:, 2] - 0.1 * np.sin(2.0 * angle)).mean())

    s = np.linspace(0.2, 1.1 * np.pi, 10)
    # On the crest, as a user sees it: from inside, the ridge's feet are the nearest.
    rough = np.stack([1.1 * np.cos(s), 1.1 * np.sin(s), 0.1 * np.sin(2.0 * s)], axis=1)
    rough[:, 2] += 0.03 * np.sin(2.5 * np.arange(10))
    rough = model.nearest(rough).points
    assert off(snap(model, rough).spline.sample(200)) < 0.25 * off(
        find_initial_curve(model, rough).samples
    )


def test_an_isophote_is_found() -> None:
    """alpha = 0 on a sphere: a = z and beta = 60 degrees give the latitude of 30 degrees."""
    polar, turn = np.linspace(0.3, 2.8, 61), np.linspace(0.0, 2.5, 61)
    p, t = np.meshgrid(polar, turn, indexing="ij")
    points = np.stack([np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)], axis=2)
    i, j = np.meshgrid(np.arange(60), np.arange(60), indexing="ij")
    a = (i * 61 + j).ravel()
    model = Surface.from_soup(
        PolygonMesh.from_faces(
            points.reshape(-1, 3),
            np.concatenate([np.c_[a, a + 61, a + 1], np.c_[a + 1, a + 61, a + 62]]),
        )
    )
    s = np.linspace(0.4, 2.1, 5)
    lift = np.cos(np.radians(60.0)) + np.array([0.04, -0.05, 0.05, -0.04, 0.05])
    flat = np.sqrt(1.0 - lift**2)
    rough = np.stack([flat * np.cos(s), flat * np.sin(s), lift], axis=1)
    found = snap(model, rough, SnapSettings(alpha=0.0, beta=np.radians(60.0))).spline.sample(100)
    assert np.abs(found[:, 2] - 0.5).mean() < 0.25 * np.abs(lift - 0.5).mean()


def test_the_same_curve_on_the_shuffled_unoriented_soup(
    ridge: Surface, drawn: Points, begun: Snap
) -> None:
    """Bit for bit: nothing depends on order, sense or welding."""
    rng = np.random.default_rng(4)
    corners = ridge.corners[rng.permutation(len(ridge.corners))]
    for one in corners:
        one[:] = one[rng.permutation(3)]
    soup = Surface.from_soup(
        PolygonMesh.from_faces(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    )
    found = snap(soup, drawn)
    assert (found.spline.control == begun.curve.spline.control).all()
    assert (found.samples == begun.curve.samples).all()


def test_constraints_are_hit_exactly(ridge: Surface, drawn: Points) -> None:
    """In the first place, and when one is dragged later."""
    free = snap(ridge, drawn)
    m = len(free.samples)
    targets = ridge.nearest(free.samples[[m // 3, 2 * m // 3]] + (0.0, 0.1, 0.0)).points
    held = list(zip((m // 3, 2 * m // 3), targets, strict=True))
    for found in (
        snap(ridge, drawn, constraints=held),
        Snap.begin(ridge, drawn).with_constraints(held).curve,
        Snap.begin(ridge, drawn, constraints=held[:1]).with_constraints(held).again().curve,
    ):
        met = found.spline.evaluate(found.parameters[[m // 3, 2 * m // 3]])
        assert np.abs(met - targets).max() < 1e-9
        assert (found.samples[[m // 3, 2 * m // 3]] == targets).all()


def test_a_drag_builds_only_the_ribs_near_it_anew(begun: Snap) -> None:
    m = len(begun.curve.samples)
    target = begun.model.nearest(begun.curve.samples[[m // 2]] + (0.0, 0.06, 0.0)).points[0]
    moved = begun.with_constraints([(m // 2, target)])
    kept = np.array([a is b for a, b in zip(moved.ribs, begun.ribs, strict=True)])
    assert not kept[m // 2] and kept[: m // 5].all() and kept[-m // 5 :].all()
    # Taken away again, the curve is as it was.
    back = moved.with_constraints(())
    assert back.curve.constraints == ()
    assert np.abs(back.curve.spline.sample(50) - begun.curve.spline.sample(50)).max() < 0.01


def test_sliders_cut_the_same_ribs_again(begun: Snap) -> None:
    """alpha, beta, axis, stiffness and theta need no new ribs; the same settings change nothing."""
    same = begun.with_settings(begun.settings)
    assert (same.curve.spline.control == begun.curve.spline.control).all()
    there = begun.with_settings(
        replace(begun.settings, alpha=0.4, beta=0.3, axis=(0.0, 1.0, 0.0), stiffness=3.0)
    )
    assert there.fishbone is begun.fishbone
    assert np.abs(there.curve.samples - begun.curve.samples).max() > 1e-3
    back = there.with_settings(begun.settings)
    assert (back.curve.spline.control == begun.curve.spline.control).all()
    wider = begun.with_settings(replace(begun.settings, radius=0.06))
    assert wider.fishbone is not begun.fishbone
    assert (
        wider.curve.spline.control
        == snap(begun.model, begun.stroke, wider.settings).spline.control
    ).all()  # fmt: skip


def test_stiffness_straightens_and_strict_is_stiffest(begun: Snap) -> None:
    """Rows change less the stiffer the curve; with theta >= max tau hardly at all."""

    def moves(settings: SnapSettings) -> int:
        bone = begun.fishbone
        samples = begun.with_settings(settings).curve.samples
        rows = [
            int(np.linalg.norm(bone.points[i] - one, axis=1).argmin())
            for i, one in enumerate(samples)
        ]
        return int(np.abs(np.diff(rows)).sum())

    soft = moves(replace(begun.settings, theta=0.01))
    stiff = moves(replace(begun.settings, theta=0.01, stiffness=100.0))
    strict = moves(replace(begun.settings, strict=True))
    assert soft >= stiff >= strict
    assert strict <= 2


def test_a_stroke_beyond_the_model_is_told(ridge: Surface) -> None:
    """Samples go to the nearest surface; ribs without a contour are left out and named."""
    x = np.linspace(0.5, 5.5, 7)
    rough = np.stack([x, 0.15 * np.sin(1.5 * x), np.zeros(7)], axis=1)
    found = snap(ridge, rough)
    assert any("far off the model" in note for note in found.notes)
    with pytest.raises(InvalidFeatureError, match="all clicked points are at one place"):
        snap(ridge, rough[[0, 0]])


def test_ribs_that_fail_are_named_and_bridged() -> None:
    """Two halves of a ridge with a wide gap: the curve goes on across it."""
    y = hat()
    halves = [swept(y, np.linspace(a, b, 30)) for a, b in ((0.0, 1.7), (2.3, 4.0))]
    count = len(halves[0].vertices)
    model = Surface.from_soup(
        PolygonMesh.from_faces(
            np.concatenate([half.vertices for half in halves]),
            np.concatenate([halves[0].triangles, halves[1].triangles + count]),
        )
    )
    x = np.array([0.3, 1.2, 2.0, 2.8, 3.7])
    rough = np.stack([x, 0.05 * (-1.0) ** np.arange(5), np.zeros(5)], axis=1)
    found = Snap.begin(model, rough, SnapSettings(radius=0.03))
    assert len(found.curve.samples) == len(found.ribs)
    missing = [i for i, rib in enumerate(found.ribs) if rib is None]
    assert set(missing) <= set(found.curve.failed)
    assert bool(found.curve.failed) == any("no contour" in note for note in found.curve.notes)
    here = np.abs(found.curve.samples[:, 0] - 2.0) > 0.5
    assert np.abs(found.curve.samples[here, 1]).mean() < 0.01


def test_flat_surfaces_are_told() -> None:
    plate = swept(np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]), np.linspace(0.0, 3.0, 4))
    rough = np.array([(0.5, 0.1, 0.0), (1.5, -0.1, 0.0), (2.5, 0.1, 0.0)])
    found = snap(plate, rough)
    assert any("curvature is the same everywhere" in note for note in found.notes)


@pytest.mark.parametrize("short", [(0.004, 0.004), (0.002, 0.006)])
def test_a_ridge_that_lies_in_a_gap_is_found(short: tuple[float, float]) -> None:
    """Both sides of a roof end short of its ridge: the curve is where they would meet, off the
    model, at the samples of ribs that are nearest; it is the same on the soup, bit for bit."""
    along, sides = np.linspace(0.0, 4.0, 41), []
    for way, end in zip((-1.0, 1.0), short, strict=True):
        y = way * np.linspace(end, 1.0, 12)
        sides.append(swept(np.stack([y, -0.7 * np.abs(y)], axis=1), along))
    count = len(sides[0].vertices)
    points = np.concatenate([side.vertices for side in sides])
    triangles = np.concatenate([sides[0].triangles, sides[1].triangles + count])
    roof = Surface.from_soup(PolygonMesh.from_faces(points, triangles))
    x, off = np.linspace(0.4, 3.6, 6), 0.03 * (-1.0) ** np.arange(6)
    rough = roof.nearest(np.stack([x, off, -0.7 * np.abs(off)], axis=1)).points
    found = snap(roof, rough)
    width = float(np.hypot(sum(short), 0.7 * (short[1] - short[0])))
    spacing = 2.0 * found.settings.radius * roof.diagonal / (found.settings.n_samples - 1)
    assert np.abs(found.samples[:, 1]).max() < spacing and len(found.repaired) > 0
    assert np.abs(found.spline.sample(100)[:, 1:]).max() < 0.5 * spacing
    lengths = roof.measure_distances(found.samples)
    assert np.median(lengths) > min(short) and lengths.max() < 1.2 * width
    corners = np.random.default_rng(1).permutation(roof.corners).reshape(-1, 3)
    soup = Surface.from_soup(
        PolygonMesh.from_faces(corners, np.arange(len(corners)).reshape(-1, 3))
    )
    assert (snap(soup, rough).spline.control == found.spline.control).all()


def lateral(curve: Points, feature: Points, drawn: Points) -> float:
    """Mean distance of the feature, between the feet of the stroke's ends, from the curve."""
    true = at_lengths(feature, np.linspace(0.0, arc_length(feature)[-1], 2001))
    low, high = np.sort(KDTree(true).query(drawn[[0, -1]])[1])
    fine = at_lengths(curve, np.linspace(0.0, arc_length(curve)[-1], 2001))
    return float(KDTree(fine).query(true[low : high + 1])[0].mean())


@pytest.mark.parametrize("state", ["clean", "cluttered", "torn"])
def test_features_of_a_car_are_found(state: str) -> None:
    """At most a quarter of the stroke's own error, in the middle of the features."""
    made = body("coupe")
    if state == "clean":
        model = Surface.from_soup(PolygonMesh.from_faces(made.points, made.triangles))
    elif state == "cluttered":
        mess = degrade(made, 1, flips=0.5, interior=True, shuffle=True)
        model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
    else:
        mess = degrade(made, 1, gaps=0.001, flips=0.5, shuffle=True)
        model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
    good = 0
    names = ("roof_rail", "shoulder", "hood_edge", "sill_middle", "front_arch", "windscreen_base")
    for name in names:
        feature = made.feature(name)
        rough = stroke(made, name, 0.01, 0)
        found = snap(model, rough)
        own = lateral(find_initial_curve(model, rough).samples, feature.points, rough)
        good += lateral(found.spline.sample(401), feature.points, rough) < 0.25 * own
        assert (len(found.repaired) > 0) == (state == "torn")
    assert good >= len(names) - (state == "torn")


@pytest.mark.parametrize(
    ("name", "value"),
    [("alpha", 1.5), ("beta", -0.1), ("stiffness", 0.5), ("theta", -1.0), ("window", 0.0),
     ("continuity", -1.0), ("nearness", 0.0), ("radius", 0.0), ("n_samples", 2), ("rounds", 0)],
)  # fmt: skip
def test_settings_out_of_range_are_told(name: str, value: float) -> None:
    with pytest.raises(InvalidFeatureError, match=name):
        SnapSettings(**{name: value})  # pyright: ignore[reportArgumentType]
