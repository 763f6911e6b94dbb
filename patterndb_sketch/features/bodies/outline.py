"""The curves and surfaces of a car's left half, from its measures, before edges are rounded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.bodies.car import CHIN, Car
from patterndb_sketch.features.bodies.coons import Coons, Curve, bent, bezier, segment, symmetric
from patterndb_sketch.features.bodies.wheelhouse import Wheelhouse, wheelhouse

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
