"""Small shape models for the viewer's tests: one car of few quads, bent into others."""

from __future__ import annotations

from functools import cache

import numpy as np

from sketch.features.bodies import body
from sketch.features.files.networkjson import spline_through
from sketch.features.model import Model
from sketch.features.registration import Registration, Template, box_template, register
from sketch.features.shapemodel import ShapeModel

#: Resolution of the body, and vertices per edge of the template's boxes.
COARSE, R = 0.4, 5


@cache
def car_template() -> Template:
    return box_template(R)


@cache
def car_laid() -> Registration:
    car = body("sedan", COARSE, whole=True)
    curves = {c.name: spline_through(c.smooth) for c in car.features if c.kind != "hidden"}
    return register(Model.from_arrays(car.points, car.triangles), curves, car_template())


@cache
def car_shapes(count: int = 6) -> ShapeModel:
    """So many cars, each longer or shorter, higher, wider, and waved along itself; as symmetric
    as the first."""
    laid = car_laid()
    rng = np.random.default_rng(5)
    shapes = [laid.points]
    for _ in range(count - 1):
        sizes = rng.uniform(0.85, 1.2, 3)
        waves, turns = rng.uniform(-0.08, 0.08, 3), rng.uniform(0.0, 6.0, 3)
        x = laid.points[:, :1]
        bent = np.sin(rng.uniform(0.5, 2.5, 3) * x + turns) * waves
        # What goes sideways is mirrored.
        bent[:, 1] = waves[1] * laid.points[:, 1] * np.cos(x[:, 0])
        shapes.append(laid.points * sizes + bent)
    names = tuple(f"car {i}" for i in range(count))
    return ShapeModel.build(
        shapes, laid.quads, laid.features, names=names, template=car_template().name
    )
