"""Wheelhouses: the arch in the body's side, the tub behind it, and the wall that ends it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.bodies.car import Car
from patterndb_sketch.features.bodies.coons import Coons, Curve, segment

#: The arch and the tub bend from upright to level at these shares of the arch's angle.
BENDS = (0.3, 0.7)

#: Depth of a wheelhouse, as a share of half the car's width.
DEPTH = 0.34

#: Points of the arch that are solved for; between them its parameters are a cubic spline.
ARCH_SAMPLES = 241


@dataclass(frozen=True, slots=True, eq=False)
class Wheelhouse:
    """One wheelhouse, open to the side and to the ground.

    name:      front or rear. centre: x of its axle; the arch is a circle around it in side view.
    arch:      parameters of the arch on the side, from its front foot over the top.
    feet:      the arch's ends on the sill, as the sill's parameters.
    inner:     y of the wall.
    bends:     the bends as parameters of the arch.
    surfaces:  NAME_tub over the arch (p) and to the inside (q), NAME_wall.
    """

    name: str
    centre: float
    arch: Curve
    feet: tuple[float, float]
    inner: float
    bends: tuple[float, float]
    surfaces: dict[str, Coons]


def _zero(function: Callable[[float], float], low: float, high: float) -> float:
    return float(np.asarray(brentq(function, low, high, xtol=1e-15)))


def inner_line(floor: Coons, inner: float) -> Curve:
    """Parameters on the floor of the line at y = inner, for its q in [0, 1]."""

    def path(q: Floats) -> Points:
        # The floor's y is (2 p - 1) times the sill's at every q.
        return np.stack([0.5 + 0.5 * inner / floor.right(q)[:, 1], q], axis=1)

    return path


def wheelhouse(
    car: Car, name: str, centre: float, side: Coons, floor: Coons, sill: Curve
) -> Wheelhouse:
    """The wheelhouse around the axle at x = centre, cut into the side and the floor."""
    radius = car.arch_radius

    def beyond(p: float) -> float:
        x, _, z = sill(np.array([p]))[0]
        return float(np.hypot(x - centre, z) - radius)

    ends = sill(np.array([0.0, 1.0]))[:, 0]
    middle = (centre - ends[0]) / (ends[1] - ends[0])
    feet = (_zero(beyond, 0.0, middle), _zero(beyond, middle, 1.0))
    low = sill(np.array(feet))
    first, last = np.arctan2(low[:, 2], low[:, 0] - centre)
    first += 2.0 * np.pi * (first < 0.0)
    t = np.linspace(0.0, 1.0, ARCH_SAMPLES)
    turn = first + t * (last - first)
    circle = np.stack([centre + radius * np.cos(turn), radius * np.sin(turn)], axis=1)
    height = float(np.ptp(side.left(np.array([0.0, 1.0]))[:, 2]))
    start = np.stack(
        [(circle[:, 0] - ends[0]) / (ends[1] - ends[0]), (circle[:, 1] - low[0, 2]) / height], 1
    )
    arch = CubicSpline(t, side.where(circle, (0, 2), start))

    inner = -(1.0 - DEPTH) * car.width / 2.0
    line = inner_line(floor, inner)
    deep = floor(line(np.array(feet)))

    def outer(t: Floats) -> Points:
        return side(arch(t))

    off = (deep - outer(np.array([0.0, 1.0])))[:, [0, 2]]

    def inside(t: Floats) -> Points:
        points = outer(t)
        points[:, [0, 2]] += (1.0 - t)[:, None] * off[0] + t[:, None] * off[1]
        points[:, 1] = inner
        return points

    def along_floor(foot: float) -> Curve:
        path = segment([1.0, foot], line(np.array([foot]))[0])
        return lambda t: floor(path(t))

    a, b = BENDS

    def part(start: float, end: float) -> Curve:
        return lambda t: inside(start + t * (end - start))

    def bottom(t: Floats) -> Points:
        points = floor(line(feet[0] + t * (feet[1] - feet[0])))
        points[:, 1] = inner
        return points

    nothing = np.zeros(3)
    tub = Coons(outer, inside, along_floor(feet[0]), along_floor(feet[1]), nothing, -1.0)
    wall = Coons(bottom, part(a, b), part(0.0, a), part(1.0, b), nothing, 1.0)
    surfaces = {f"{name}_tub": tub, f"{name}_wall": wall}
    return Wheelhouse(name, centre, arch, feet, inner, BENDS, surfaces)
