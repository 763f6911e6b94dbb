"""Wheels, for pictures and as clutter: plain tyres of revolution."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.features.bodies.car import Car
from patterndb_sketch.features.bodies.grids import grid_faces

#: Width of a tyre over its radius, and how far it stands inside of the body's side, in metres.
WIDTH = 0.62
INSET = 0.06

#: The half cross-section: radius and offset across, as shares of the tyre's radius and half
#: width, from the rim's middle on the outside over the tread to that on the inside.
SECTION = np.array(
    [[0, -0.55], [0.12, -0.58], [0.16, -0.45], [0.58, -0.55], [0.64, -0.98], [0.68, -1.0],
     [0.94, -0.98], [1.0, -0.75], [1.0, 0.75], [0.94, 0.98], [0.66, 1.0], [0.6, 0.6], [0, 0.6]]
)  # fmt: skip

#: Quads around a tyre.
AROUND = 36


def wheel(car: Car, centre: float) -> tuple[Points, Int64Array]:
    """The left wheel around the axle at x = centre: (v, 3) points, (f, 4) quads."""
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
    radius = car.tyre_radius * SECTION[:, 0]
    half = 0.5 * WIDTH * car.tyre_radius
    y = INSET + half - car.width / 2.0 + half * SECTION[:, 1]
    ring = np.stack([np.cos(turn), np.zeros(len(turn)), np.sin(turn)], axis=1)
    points = radius[None, :, None] * ring[:, None]
    points[..., 0] += centre
    points[..., 1] = y
    return points.reshape(-1, 3), grid_faces(len(turn), len(SECTION))
