"""What stands in and around cars and is none of their surface: wheels, seats, mirrors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from bodies.body import Body
from bodies.car import Car
from bodies.coons import grid_faces
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points

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


Part = tuple[Points, Int64Array]

#: The corners of a box by its faces, counter-clockwise from outside; corner 4 x + 2 y + z.
BOX = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])

#: Distance of the inner shells from the body, and of their borders from its edges, in metres.
SHELL = 0.03
SHELL_BORDER = 0.08


def box(low: ArrayLike, high: ArrayLike) -> Part:
    """A box with eight vertices."""
    ends = np.stack([np.asarray(low, float), np.asarray(high, float)])
    at = np.arange(8)
    points = np.stack([ends[at >> 2, 0], ends[at >> 1 & 1, 1], ends[at & 1, 2]], axis=1)
    return points, BOX


def interior_parts(body: Body) -> list[Part]:
    """Half an engine, a seat with its back, a bench, and shells behind the skin of the half."""
    car = body.car
    floor = car.clearance - car.tyre_radius + 0.06
    bonnet = car.nose_height - car.tyre_radius
    belt = min(car.cowl_height, car.belt_height, car.tail_height) - car.tyre_radius
    half = car.width / 2.0
    seat = car.cowl + 0.62
    bench = car.wheelbase - 0.55
    engine = -0.3 if car.front_overhang > 0.75 else -0.15
    parts = [
        box((engine, -0.3 * half, floor), (0.3, -0.02, bonnet - 0.06)),
        box((seat, -0.62 * half, floor + 0.05), (seat + 0.5, -0.16 * half, floor + 0.22)),
        box((seat + 0.42, -0.62 * half, floor + 0.2), (seat + 0.54, -0.16 * half, belt + 0.03)),
        box((bench, -0.6 * half, floor + 0.05), (bench + 0.45, -0.01, floor + 0.2)),
        box((bench + 0.4, -0.6 * half, floor + 0.2), (bench + 0.48, -0.01, belt - 0.08)),
    ]
    return parts + _shells(body)


def _shells(body: Body) -> list[Part]:
    """Patches of the skin once more, behind it: its faces well away from edges, moved inwards."""
    names = ("hood", "roof", "side_doors", "side_fender", "glass", "windscreen")
    lines = [one.points for one in body.features if one.kind not in ("hidden", "profile", "seam")]
    edges = np.concatenate([_dense(line) for line in lines])
    normals = _normals(body)
    away = KDTree(edges).query(body.points)[0] > SHELL_BORDER
    left = (body.points[:, 1] <= 0.0) & away
    parts: list[Part] = []
    for name in names:
        chosen = body.faces[body.patches == body.patch_names.index(name)]
        chosen = chosen[left[chosen].all(axis=1)]
        if len(chosen):
            used, faces = np.unique(chosen, return_inverse=True)
            parts.append((body.points[used] - SHELL * normals[used], faces.reshape(-1, 4)))
    return parts


def _dense(line: Points) -> Points:
    share = np.linspace(0.0, 1.0, 8, endpoint=False)[:, None, None]
    return np.r_[((1.0 - share) * line[:-1] + share * line[1:]).reshape(-1, 3), line[-1:]]


def _normals(body: Body) -> Points:
    a, b, c, d = (body.points[body.faces[:, k]] for k in range(4))
    flat = np.cross(c - a, d - b)
    total = np.zeros_like(body.points)
    for k in range(4):
        np.add.at(total, body.faces[:, k], flat)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def exterior_parts(body: Body) -> list[Part]:
    """A mirror, two door handles, an aerial and two wheels, of the driver's side."""
    car = body.car
    base = body.corners["a_pillar_base"]
    glass = base + np.array([0.16, 0.0, 0.06])
    spike = glass + np.array(
        [[-0.08, 0.02, -0.03], [0.08, 0.02, -0.03], [0.0, 0.02, 0.08], [0.02, -0.2, 0.02]]
    )
    mirror = spike, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    rail, shoulder = body.feature("roof_rail").smooth, body.feature("shoulder").smooth
    parts: list[Part] = [mirror]
    for x in (car.cowl + 0.95, car.cowl + 1.75):
        at = shoulder[int(np.argmin(np.abs(shoulder[:, 0] - x)))]
        parts.append(box((x, at[1] - 0.05, at[2] - 0.14), (x + 0.18, at[1] + 0.03, at[2] - 0.11)))
    top = rail[-40] * (1.0, 0.3, 1.0)
    parts.append(box(top - np.array([0.0, 0.0, 0.02]), top + np.array([0.01, 0.01, 0.45])))
    parts += [wheel(car, 0.0), wheel(car, car.wheelbase)]
    return parts
