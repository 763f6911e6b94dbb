"""What the tests of registration share: a sheet as a template, its rim, bumpy models, and cars."""

from __future__ import annotations

from functools import cache

import numpy as np
from bodies import Body, body
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.registration import (
    ChainStep,
    FeatureChain,
    Registration,
    Template,
    TemplatePart,
    box_template,
    register,
)
from patterndb_sketch.features.splines import Spline

#: Resolution of the bodies and vertices per edge of the boxes in tests.
COARSE, R = 0.6, 6


def grid_quads(n: int) -> NDArray[np.int32]:
    """The quads of n x n vertices, rows along x, counter-clockwise seen from above."""
    at = np.arange(n * n).reshape(n, n)
    cells = [at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]]
    return np.stack(cells, axis=-1).reshape(-1, 4).astype(np.int32)


def sheet(n: int) -> Template:
    """n x n vertices between four curves, named by where they are."""
    at = np.arange(n * n, dtype=np.int32).reshape(n, n)
    sides = {"south": at[0], "east": at[:, -1], "north": at[-1, ::-1], "west": at[::-1, 0]}
    corners = ("sw", "se", "ne", "nw", "sw")
    chains = tuple(
        FeatureChain(
            name, np.ascontiguousarray(side), (ChainStep(name, corners[i], corners[i + 1]),)
        )
        for i, (name, side) in enumerate(sides.items())
    )
    whole = np.zeros(n * n, np.int32)
    return Template("sheet", grid_quads(n), (TemplatePart("sheet"),), whole, chains, whole > 0)


def rim(size: float = 1.0, height: float = 0.0, beyond: float = 0.1) -> dict[str, Spline]:
    """Four straight curves about a square; they cross each other and go on."""
    low, high = -size / 2.0, size / 2.0
    square = np.array([[low, low], [high, low], [high, high], [low, high]])
    result: dict[str, Spline] = {}
    for i, name in enumerate(("south", "east", "north", "west")):
        a, b = square[i], square[(i + 1) % 4]
        ends = np.array([a - beyond * (b - a), b + beyond * (b - a)])
        result[name] = spline_through(np.c_[ends, [height, height]])
    return result


def bump(x: Points, y: Points, height: float = 0.1) -> Points:
    """A hill over the square about the origin that is flat at its rim."""
    return height * np.cos(np.pi * x) * np.cos(np.pi * y)


def hill(n: int = 33, height: float = 0.1) -> tuple[Points, NDArray[np.int64]]:
    """The points and triangles of the hill."""
    side = np.linspace(-0.5, 0.5, n)
    y, x = np.meshgrid(side, side, indexing="ij")
    points = np.stack([x, y, bump(x, y, height)], axis=-1).reshape(-1, 3)
    quads = grid_quads(n).astype(np.int64)
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


@cache
def car(name: str = "sedan") -> Body:
    return body(name, COARSE, whole=True)


@cache
def car_model(name: str = "sedan") -> Surface:
    return Surface.from_soup(PolygonMesh.from_faces(car(name).points, car(name).triangles))


@cache
def car_curves(name: str = "sedan") -> dict[str, Spline]:
    """Those that can be drawn."""
    return {
        one.name: spline_through(one.smooth) for one in car(name).features if one.kind != "hidden"
    }


@cache
def car_template() -> Template:
    return box_template(R)


@cache
def laid(name: str = "sedan") -> Registration:
    return register(car_model(name), car_curves(name), car_template())
