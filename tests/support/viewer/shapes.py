"""Small shape models for the viewer's tests: one car of few quads, bent into others."""

from __future__ import annotations

from functools import cache

import numpy as np
from bodies import body

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.registration import Registration, Template, box_template, register
from patterndb_sketch.features.shapemodel import ShapeModel
from viewer.keymap import Effect
from viewer.shapes import ShapesState
from viewer.shapes.commands import KEYS
from viewer.shapes.picture import compose_shape

#: Resolution of the body, and vertices per edge of the template's boxes.
COARSE, R = 0.4, 5


@cache
def car_template() -> Template:
    return box_template(R)


@cache
def car_laid() -> Registration:
    car = body("sedan", COARSE, whole=True)
    curves = {c.name: spline_through(c.smooth) for c in car.features if c.kind != "hidden"}
    return register(
        Surface.from_soup(PolygonMesh.from_faces(car.points, car.triangles)),
        curves,
        car_template(),
    )


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


def opened(count: int = 6) -> ShapesState:
    state = ShapesState(car_shapes(count), car_template())
    compose_shape(state, 1040.0, 860.0)
    return state


def keys(state: ShapesState, text: str) -> None:
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW


def number(state: ShapesState, name: str, *, mirrored: bool = False) -> int:
    lines = enumerate(state.skin.lines)
    return next(i for i, one in lines if one.name == name and one.mirrored == mirrored)


def seen(state: ShapesState, name: str, *, mirrored: bool = False) -> tuple[float, float]:
    """Where the middle vertex of a curve is seen."""
    line = state.sight.lines[number(state, name, mirrored=mirrored)]
    x, y = line[len(line) // 2, :2].tolist()
    return x, y


def drag(
    state: ShapesState, start: tuple[float, float], by: tuple[float, float], *, drop: bool = True
) -> None:
    """Press, move in three steps, and release."""
    state.move(*start)
    state.press(*start)
    for share in (0.6, 0.8):
        state.move(start[0] + share * by[0], start[1] + share * by[1])
    assert state.move(start[0] + by[0], start[1] + by[1])
    if drop:
        assert state.release(start[0] + by[0], start[1] + by[1])


def slide(state: ShapesState, mode: int, *sigmas: float) -> None:
    """Drag a mode's slider through values."""
    state.shaping.begin()
    for value in sigmas:
        state.shaping.set_mode(mode, value)
    state.shaping.finish()
