"""The curves and surfaces of a car's left half, from its measures, before edges are rounded.

They include both wheelhouses: the arch in the body's side, the tub behind it, and the wall that
ends it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from bodies.car import CHIN, Car
from bodies.coons import Coons, Curve, bent, bezier, segment, symmetric
from patterndb.geometry.points import Floats, Points

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


#: Length in metres over which the shoulder and the sill bend.
SOFT = 0.16

#: How sharply the plan narrows towards nose and tail: the power of the distance.
TAPER_POWER = 4.0

#: The sill lies this much further inside than the shoulder, and rises so much to both ends.
SILL_INSET = 0.05
SILL_RISE = 0.05

#: Curves on a surface: their parameters there, for parameters in [0, 1].
Path = Curve


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """The half of the car with y <= 0, the driver's where traffic keeps to the right.

    surfaces: by name: top, side, nose, tail, floor of the body; screen, roof, window, glass of
              the roof; tub and wall of each wheelhouse, as front_tub.
    paths:    by name, the curves that run within a surface: the base of the roof on ``top``, and
              the inner line of the wheelhouses on ``floor``.
    windscreen, rear_window: (2,) parameters on ``top`` of the outer end of the roof's base.
    houses:   front and rear wheelhouse.
    """

    car: Car
    surfaces: dict[str, Coons]
    paths: dict[str, Path]
    windscreen: Floats
    rear_window: Floats
    houses: tuple[Wheelhouse, Wheelhouse]


def outline(car: Car) -> Outline:
    ground = -car.tyre_radius
    half = car.width / 2.0
    front = car.nose_bow + car.nose_rake - car.front_overhang
    rear = car.wheelbase + car.rear_overhang - car.tail_bow - car.tail_rake
    chin = car.nose_bow + CHIN - car.front_overhang
    apron = car.wheelbase + car.rear_overhang - car.tail_bow - CHIN

    def breadth(t: Floats) -> Floats:
        lost = car.nose_taper * (1.0 - t) ** TAPER_POWER + car.tail_taper * t**TAPER_POWER
        return half - lost

    def shoulder(t: Floats) -> Points:
        x = front + t * (rear - front)
        places = (front, car.cowl, car.rear_base, rear)
        heights = (car.nose_height, car.cowl_height, car.belt_height, car.tail_height)
        return np.stack([x, -breadth(t), ground + bent(x, places, heights, SOFT)], axis=1)

    def sill(t: Floats) -> Points:
        x = chin + t * (apron - chin)
        rise = SILL_RISE * ((1.0 - t) ** 6 + 1.6 * t**6)
        return np.stack([x, SILL_INSET - breadth(t), ground + car.clearance + rise], axis=1)

    ends = np.array([0.0, 1.0])
    nose_side = _upright(sill(ends)[0], shoulder(ends)[0], -car.bumper)
    tail_side = _upright(sill(ends)[1], shoulder(ends)[1], car.bumper)
    hood_edge = _across(shoulder(ends)[0], -car.nose_bow, 0.4 * car.hood_crown)
    deck_edge = _across(shoulder(ends)[1], car.tail_bow, 0.3 * car.hood_crown)
    front_bottom = _across(sill(ends)[0], -car.nose_bow, 0.0)
    rear_bottom = _across(sill(ends)[1], car.tail_bow, 0.0)
    top = symmetric(hood_edge, deck_edge, shoulder, [0, 0, car.hood_crown], 1.0)
    nose = symmetric(front_bottom, hood_edge, nose_side, [-0.3 * car.bumper, 0, 0], 1.0)
    tail = symmetric(rear_bottom, deck_edge, tail_side, [0.3 * car.bumper, 0, 0], -1.0)
    floor = symmetric(front_bottom, rear_bottom, sill, [0, 0, 0], -1.0)
    bulge = np.array([0.0, -car.side_bulge, 0.0])
    side = Coons(sill, shoulder, nose_side, tail_side, bulge, 1.0)

    screen_foot = _on_top(top, car.cowl, half, breadth, front, rear, car.ledge)
    window_foot = _on_top(top, car.rear_base, half, breadth, front, rear, car.ledge)
    screen_middle = _middle(top, car.cowl - car.screen_bow, (front, rear))
    window_middle = _middle(top, car.rear_base + car.rear_bow, (front, rear))
    paths: dict[str, Path] = {
        "windscreen_base": _bow(screen_middle, screen_foot),
        "rear_window_base": _bow(window_middle, window_foot),
        "belt_line": segment(screen_foot, window_foot),
        "hood_seam": segment([screen_foot[0], 0.0], screen_foot),
        "deck_seam": segment(window_foot, [window_foot[0], 1.0]),
    }

    def on_top(name: str) -> Curve:
        return lambda t: top(paths[name](t))

    base, foot, belt = on_top("windscreen_base"), on_top("rear_window_base"), on_top("belt_line")
    lower = belt(ends)
    rail = _rail(car, ground, lower)
    high = rail(ends)
    roof_front = _across(high[0], -0.8 * car.screen_bow, 0.6 * car.roof_crown)
    roof_rear = _across(high[1], 0.8 * car.rear_bow, 0.6 * car.roof_crown)
    a_pillar = _pillar(lower[0], high[0], -0.025)
    c_pillar = _pillar(lower[1], high[1], 0.015)
    surfaces = {
        "top": top, "side": side, "nose": nose, "tail": tail, "floor": floor,
        "screen": symmetric(base, roof_front, a_pillar, [-0.012, 0, 0.008], 1.0),
        "roof": symmetric(roof_front, roof_rear, rail, [0, 0, 0.25 * car.roof_crown], 1.0),
        "window": symmetric(foot, roof_rear, c_pillar, [0.01, 0, 0.01], -1.0),
        "glass": Coons(belt, rail, a_pillar, c_pillar, np.array([0.0, -0.02, 0.0]), 1.0),
    }  # fmt: skip
    houses = (
        wheelhouse(car, "front", 0.0, side, floor, sill),
        wheelhouse(car, "rear", car.wheelbase, side, floor, sill),
    )
    for house in houses:
        surfaces |= house.surfaces
    return Outline(car, surfaces, paths, screen_foot, window_foot, houses)


def _across(end: Floats, bow: float, crown: float) -> Curve:
    """From the middle plane to a point of the left half; the middle is bow further along x and
    crown higher."""

    def curve(t: Floats) -> Points:
        fall = 1.0 - t**2
        return np.stack([end[0] + bow * fall, end[1] * t, end[2] + crown * fall], axis=1)

    return curve


def _upright(low: Floats, high: Floats, bumper: float) -> Curve:
    """From the sill to the shoulder at nose or tail, standing out by about bumper on its way."""
    rise = high - low
    out = np.array([1.6 * bumper, -0.3 * abs(bumper), 0.0])
    return bezier([low, low + 0.3 * rise + out, low + 0.65 * rise + out, high])


def _on_top(
    top: Coons, x: float, half: float, breadth: Curve, front: float, rear: float, ledge: float
) -> Floats:
    """(2,) parameters on top of the point at x, a ledge inside the shoulder."""
    along = np.array([(x - front) / (rear - front)])
    y = ledge - float(breadth(along)[0])
    start = np.array([[0.5 - 0.5 * y / half, along[0]]])
    return top.where(np.array([[x, y]]), (0, 1), start)[0]


def _middle(top: Coons, x: float, span: tuple[float, float]) -> Floats:
    """(2,) parameters on top of the point at x in the middle plane."""
    start = np.array([[0.5, (x - span[0]) / (span[1] - span[0])]])
    return np.r_[0.5, top.where(np.array([[x, 0.0]]), (0, 1), start)[0, 1]]


def _bow(middle: Floats, end: Floats) -> Path:
    """Parameters from the middle plane, at a right angle to it, to the end."""
    return lambda t: middle + np.stack([t, t**2], axis=1) * (end - middle)


def _rail(car: Car, ground: float, lower: Points) -> Curve:
    """The roof's side, over the belt line whose ends are given."""
    high = ground + car.height - car.roof_crown
    x = np.array([car.roof_front, car.roof_rear])
    y = np.interp(x, lower[:, 0], lower[:, 1]) + car.tumblehome

    def curve(t: Floats) -> Points:
        fall = 0.6 * car.roof_fall * (1.0 - t) ** 2.2 + car.roof_fall * t**2.6
        out = 0.12 * car.tumblehome * 4.0 * t * (1.0 - t)
        place = x[0] + t * (x[1] - x[0])
        return np.stack([place, y[0] + t * (y[1] - y[0]) - out, high - fall], axis=1)

    return curve


def _pillar(low: Floats, high: Floats, out: float) -> Curve:
    """A slightly bent pillar; out: how far its middle is moved along x, per metre of length."""
    rise = high - low
    side = np.array([out, -0.03, abs(out)]) * np.linalg.norm(rise)
    return bezier([low, low + rise / 3.0 + side, low + 2.0 * rise / 3.0 + side, high])
