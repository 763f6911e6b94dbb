"""Strokes on models of vehicles, and a template on several cars: drawn ones, and as found."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.files.networkjson import read_network
from patterndb_sketch.features.files.strokesjson import read_strokes
from patterndb_sketch.features.registration import FeatureCurves, box_template, register
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import snap
from patterndb_sketch.features.strokes import FeatureStroke
from tests.support.features.drawnbodies import DRAWN, find_body
from tests.support.features.models import soup
from tests.support.features.ribs import GAP
from tests.support.shared import EXAMPLES, SHARED, list_shared

DATA = SHARED / "data"
FEATURES = EXAMPLES / "features"

#: Cars of one pack by artists, where they are.
FOUND = [name for name in ("normalcar1", "normalcar2", "sportscar") if
         (DATA / "meshes" / f"q_car_{name}.obj").is_file()]  # fmt: skip

#: A clean body with few triangles, and a torn one with many that cross; drawn, and as found.
MODELS = [
    "sedan",
    "torn-sedan",
    *(path.stem for path in list_shared(DATA / "cad", "hatchback_gazebo.obj", "gclass_chrono.obj")),
]

#: Of every model with strokes in the examples.
SHOWN = [path.name.removesuffix(".strokes.json") for path in FEATURES.glob("*.strokes.json")]

#: Of every car with a network there.
NETWORKS = [path.name.removesuffix(".network.json") for path in FEATURES.glob("*.network.json")]


def mesh_of(name: str) -> Path:
    if name in DRAWN:
        return find_body(name, ".obj")
    folder = "meshes" if name.startswith("q_") else "cad"
    return DATA / folder / f"{name}.obj"


@cache
def model_of(name: str) -> Surface:
    return Surface.from_soup(read_mesh(mesh_of(name)))


@cache
def strokes_of(name: str) -> tuple[FeatureStroke, ...]:
    return read_strokes(
        find_body(name, ".strokes.json") if name in DRAWN else FEATURES / f"{name}.strokes.json"
    )


def network_of(name: str) -> FeatureCurves:
    """The curves of a car."""
    return read_network(
        find_body(name, ".network.json")
        if name in DRAWN
        else FEATURES / f"q_car_{name}.network.json"
    )


@cache
def car_of(name: str) -> Surface:
    """A car turned as templates have it: x to the tail."""
    if name in DRAWN:
        return model_of(name)
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


@pytest.mark.parametrize("name", ["sedan", *(n for n in sorted(SHOWN) if mesh_of(n).is_file())])
def test_strokes_are_drawn_on_their_models(name: str) -> None:
    """Every clicked point is on the surface, up to the digits that are written."""
    strokes = strokes_of(name)
    assert len(strokes) >= 8
    for stroke in strokes:
        # Drawn bodies: a stroke of the middle plane was moved there from the surface.
        moved = name in DRAWN and not stroke.points[:, 1].any()
        most = 1e-3 if moved else 1e-4
        assert model_of(name).measure_distances(stroke.points).max() < most, stroke.name


@pytest.mark.parametrize(
    "name",
    [
        *("sedan", "wagon"),
        *(n.removeprefix("q_car_") for n in sorted(NETWORKS) if mesh_of(n).is_file()),
    ],
)
def test_networks_are_along_their_cars(name: str) -> None:
    """Every curve runs along the surface, as near as a smooth one can be to facets."""
    model = car_of(name)
    template = box_template(2)
    network = network_of(name)
    assert set(network.curves) == set(template.curves) - set(template.bridged)
    for name, curve in network.curves.items():
        off = model.measure_distances(curve.sample(100))
        assert off.mean() < 0.01 * model.diagonal, name


@pytest.mark.parametrize("cars", [DRAWN[:3], *([FOUND] if FOUND else [])], ids=" ".join)
def test_cars_give_a_shape_model(cars: Sequence[str]) -> None:
    """Each is mirrored exactly and keeps to its curves; two modes reproduce three cars."""
    template = box_template(5)
    laid = [register(car_of(name), network_of(name), template) for name in cars]
    for one in laid:
        free = ~one.fixed & ~one.occluded
        assert one.projected[free].mean() > 0.8
        mirrored = one.points * [1.0, -1.0, 1.0]
        key = np.lexsort(np.round(one.points, 9).T)
        other = np.lexsort(np.round(mirrored, 9).T)
        assert np.abs(one.points[key] - mirrored[other]).max() < 1e-8
    shapes = ShapeModel.from_registrations(laid, names=cars)
    assert shapes.n_modes == len(cars) - 1
    for one, numbers in zip(laid, shapes.coefficients, strict=True):
        again = shapes.mean + np.tensordot(numbers, shapes.modes, axes=1)
        assert np.abs(again - one.points).max() < 1e-9
