"""Strokes on models of real vehicles, and a template on cars of one pack."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.networkjson import read_network
from patterndb_sketch.features.files.strokesjson import read_strokes
from patterndb_sketch.features.registration import box_template, register
from patterndb_sketch.features.ribs import RADIUS
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import snap
from patterndb_sketch.features.strokes import FeatureStroke
from tests.support.features.models import soup
from tests.support.features.ribs import GAP
from tests.support.shared import EXAMPLES, SHARED

DATA = SHARED / "data"
FEATURES = EXAMPLES / "features"

#: A clean body with few triangles, and a torn one with many that cross.
MODELS = ("hatchback_gazebo", "gclass_chrono")

#: Cars of one pack.
CARS = ("normalcar1", "normalcar2", "sportscar")

pytestmark = pytest.mark.skipif(
    not (DATA / "cad").is_dir(), reason="the models are not beside the checkout"
)


def mesh_of(name: str) -> Path:
    folder = "meshes" if name.startswith("q_") else "cad"
    return DATA / folder / f"{name}.obj"


@cache
def model_of(name: str) -> Surface:
    return Surface.from_soup(read_mesh(mesh_of(name)))


@cache
def strokes_of(name: str) -> tuple[FeatureStroke, ...]:
    return read_strokes(FEATURES / f"{name}.strokes.json")


@cache
def car_of(name: str) -> Surface:
    """A car of the pack, turned as templates have it: x to the tail."""
    model = model_of(f"q_car_{name}")
    x, y, z = model.vertices.T
    return Surface.from_soup(PolygonMesh.from_faces(np.stack([y, -x, z], axis=1), model.triangles))


@pytest.mark.parametrize("name", MODELS)
def test_strokes_snap_without_failure(name: str) -> None:
    """Every rib has a contour, samples are on the model, or on a bridge over a gap, and there
    is nothing to note."""
    model = model_of(name)
    for stroke in strokes_of(name):
        curve = snap(model, stroke.points, stroke.settings, closed=stroke.closed)
        assert curve.failed == () and curve.notes == (), stroke.name
        off = model.measure_distances(curve.samples)
        assert off.max() < 1.2 * GAP * RADIUS * model.diagonal, stroke.name
        assert (off < 1e-9 * model.diagonal).mean() > 0.5, stroke.name
        # A curve is where it was drawn: no farther off than ribs reach.
        reach = stroke.settings.radius * model.diagonal
        ends = curve.spline.evaluate([*curve.spline.domain])
        drawn = model.nearest(stroke.points[[0, -1]]).points
        assert np.linalg.norm(ends - drawn, axis=1).max() < reach, stroke.name


@pytest.mark.parametrize("name", MODELS)
def test_the_same_curves_on_the_shuffled_soup(name: str) -> None:
    """Bit for bit on triangles with points of their own, in random order and sense."""
    model = model_of(name)
    torn = Surface.from_soup(PolygonMesh.from_faces(*soup(model.vertices, model.triangles, seed=3)))
    for stroke in strokes_of(name)[::3]:
        curve, other = (
            snap(one, stroke.points, stroke.settings, closed=stroke.closed) for one in (model, torn)
        )
        assert np.array_equal(curve.spline.control, other.spline.control), stroke.name
        assert np.array_equal(curve.samples, other.samples), stroke.name


@pytest.mark.parametrize("path", sorted(FEATURES.glob("*.strokes.json")), ids=lambda p: p.name)
def test_strokes_are_drawn_on_their_models(path: Path) -> None:
    """Every clicked point is on the surface, up to the digits that are written."""
    name = path.name.removesuffix(".strokes.json")
    strokes = strokes_of(name)
    assert len(strokes) >= 8
    for stroke in strokes:
        assert model_of(name).measure_distances(stroke.points).max() < 1e-4, stroke.name


@pytest.mark.parametrize("path", sorted(FEATURES.glob("*.network.json")), ids=lambda p: p.name)
def test_networks_are_along_their_cars(path: Path) -> None:
    """Every curve runs along the surface, as near as a smooth one can be to facets."""
    model = car_of(path.name.removeprefix("q_car_").removesuffix(".network.json"))
    template = box_template(2)
    network = read_network(path)
    assert set(network.curves) == set(template.curves) - set(template.bridged)
    for name, curve in network.curves.items():
        off = model.measure_distances(curve.sample(100))
        assert off.mean() < 0.01 * model.diagonal, name


def test_real_cars_give_a_shape_model() -> None:
    """Each is mirrored exactly and keeps to its curves; two modes reproduce three cars."""
    template = box_template(5)
    laid = [
        register(car_of(name), read_network(FEATURES / f"q_car_{name}.network.json"), template)
        for name in CARS
    ]
    for one in laid:
        free = ~one.fixed & ~one.occluded
        assert one.projected[free].mean() > 0.8
        mirrored = one.points * [1.0, -1.0, 1.0]
        key = np.lexsort(np.round(one.points, 9).T)
        other = np.lexsort(np.round(mirrored, 9).T)
        assert np.abs(one.points[key] - mirrored[other]).max() < 1e-8
    shapes = ShapeModel.from_registrations(laid, names=CARS)
    assert shapes.n_modes == len(CARS) - 1
    for one, numbers in zip(laid, shapes.coefficients, strict=True):
        again = shapes.mean + np.tensordot(numbers, shapes.modes, axes=1)
        assert np.abs(again - one.points).max() < 1e-9
