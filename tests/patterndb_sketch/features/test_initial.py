"""The first curve of a sketch: through the clicks, evenly sampled, on the model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.initial import (
    FEWEST,
    MOST,
    SPACING,
    find_initial_curve,
    interpolate_points,
)
from patterndb_sketch.features.splines import chordal_parameters
from tests.support.features.models import soup, sphere, sphere_model, to_model
from tests.support.meshes import models
from tests.support.shared import MESHES

SPHERE = sphere_model()


#: Artists' cars are a larger run.
PATHS = [*models()[::3], *sorted(MESHES.glob("q_car_*.obj"))[:3]]


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_samples_are_on_the_surface(path: Path) -> None:
    """To 1e-9, by distances triangle by triangle; and they are the nearest points."""
    model = Surface.from_soup(read_mesh(path))
    rng = np.random.default_rng(1)
    clicked = model.vertices[rng.choice(len(model.vertices), 4, replace=False)]
    curve = find_initial_curve(model, clicked)
    through = curve.through.sample(len(curve.samples))
    some = rng.choice(len(through), 12, replace=False)
    own = model.corners[curve.triangles]
    assert (
        max(to_model(p[None], t[None])[0] for p, t in zip(curve.samples, own, strict=True)) < 1e-9
    )
    assert curve.lengths[some] == pytest.approx(to_model(through[some], model.corners), abs=1e-9)
    assert curve.lengths == pytest.approx(np.linalg.norm(curve.samples - through, axis=1))
    # The clicked points themselves were on the surface.
    assert curve.samples[[0, -1]] == pytest.approx(clicked[[0, -1]], abs=1e-9)


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.integers(2, 8))
def test_interpolates_the_clicks_and_samples_evenly(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    clicked = rng.normal(size=(k, 3))
    clicked /= np.linalg.norm(clicked, axis=1, keepdims=True)
    curve = find_initial_curve(SPHERE, clicked)
    assert curve.n_clicked == k
    assert curve.through(chordal_parameters(clicked)) == pytest.approx(clicked, abs=1e-9)
    assert curve.through.degree == min(3, k - 1)
    m = len(curve.samples)
    steps = curve.through.length / (SPACING * SPHERE.diagonal)
    assert FEWEST <= m <= MOST
    assert m == min(max(round(steps) + 1, FEWEST), MOST)
    if FEWEST < m < MOST:
        assert curve.through.length / (m - 1) == pytest.approx(SPACING * SPHERE.diagonal, rel=0.03)


def test_two_clicks_are_a_straight_line() -> None:
    ends = np.array([[1.0, 0, 0], [0, 1, 0]])
    through = find_initial_curve(SPHERE, ends).through
    t = np.linspace(0, 1, 9)
    assert through(t) == pytest.approx((1 - t)[:, None] * ends[0] + t[:, None] * ends[1])
    assert through.length == pytest.approx(np.sqrt(2.0))


def test_a_double_click_is_one() -> None:
    clicked = np.array([[1.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 1e-9], [0, 0, 1]])
    curve = find_initial_curve(SPHERE, clicked)
    once = find_initial_curve(SPHERE, clicked[[0, 2, 4]])
    assert curve.n_clicked == 3
    assert (curve.samples == once.samples).all()


def test_the_soup_has_the_same_curve() -> None:
    """On the shuffled, unoriented triangle soup the samples are the same, bit for bit."""
    apart = Surface.from_soup(PolygonMesh.from_faces(*soup(*sphere(), 2)))
    clicked = SPHERE.vertices[[3, 40, 90, 200]]
    one, other = find_initial_curve(SPHERE, clicked), find_initial_curve(apart, clicked)
    assert one.samples.tobytes() == other.samples.tobytes()


def test_closed_sketches_pass_through_their_start_twice() -> None:
    points = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]])
    spline = interpolate_points(points)
    assert spline([0.0, 1.0]) == pytest.approx(points[[0, 0]])


@pytest.mark.parametrize(
    ("clicked", "what"),
    [
        (np.zeros((0, 3)), "no point"),
        ([[1.0, 0, 0]], "one place"),
        ([[1.0, 0, 0], [1, 0, 0]], "one place"),
        ([[1.0, 0, 0], [np.nan, 0, 0]], "not finite"),
    ],
)
def test_refusals(clicked: object, what: str) -> None:
    with pytest.raises(InvalidFeatureError, match=what):
        find_initial_curve(SPHERE, clicked)
