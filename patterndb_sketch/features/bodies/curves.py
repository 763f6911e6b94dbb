"""The named curves of a body: what they are, where they lie, and how their edges are rounded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.bodies.coons import Coons, Curve, segment
from patterndb_sketch.features.bodies.outline import Outline, Path
from patterndb_sketch.features.bodies.rounding import Ridge, Side, ridge, rounded
from patterndb_sketch.features.bodies.wheelhouse import Wheelhouse, inner_line

#: crease: a sharp edge. round: a rounded one, the curve is its ridge. arch: the edge of a wheel
#: arch, sharp or rounded. profile: where the middle plane cuts the body; the surface is smooth
#: there. seam: a line of the network on a smooth surface. hidden: off the surface, where another
#: component hides what would be the edge.
Kind = Literal["crease", "round", "arch", "profile", "seam", "hidden"]

Component = Literal["roof", "body", "front_wheelhouse", "rear_wheelhouse"]

#: Widths of the rounded edges of an ordinary car (edge = 1), in metres; others are sharp.
WIDTHS = {
    "shoulder": 0.014, "hood_edge": 0.022, "front_corner": 0.028, "rear_corner": 0.026,
    "deck_edge": 0.018, "front_bottom": 0.015, "rear_bottom": 0.015, "a_pillar": 0.015,
    "c_pillar": 0.022, "roof_rail": 0.022, "roof_front": 0.014, "roof_rear": 0.014,
    "windscreen_base": 0.010, "belt_line": 0.008, "rear_window_base": 0.010,
    "sill_front": 0.012, "sill_middle": 0.012, "sill_rear": 0.012,
    "front_arch": 0.006, "rear_arch": 0.006,
}  # fmt: skip

#: No edge is rounded by more than this share of the strip between it and the next, the ledge or
#: the deck, nor of its own length: so its ridge is by far the sharpest bend around.
STRIP_SHARE = 0.2
LENGTH_SHARE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A named curve in full: ``at`` maps parameters in [0, 1] to points; ridge: None if smooth."""

    name: str
    kind: Kind
    component: Component
    at: Curve
    ridge: Ridge | None


def lines(outline: Outline) -> tuple[Line, ...]:
    """All named curves of the half body, in the order of the network's components."""
    edges = _edges(outline)
    for house in outline.houses:
        edges += _house_edges(outline, house)
    ridges = [edge.ridge for edge in edges if edge.ridge is not None]
    return tuple(edges + _smooth(outline, ridges))


def _line(
    outline: Outline, name: str, component: Component, sides: tuple[Side, Side], centre: bool
) -> Line:
    """An edge. centre: does it begin in the middle plane, where it need not become sharp?"""
    first, car = sides[0], outline.car

    def at(t: Floats) -> Points:
        return first.surface(first.path(t))

    points = at(np.linspace(0.0, 1.0, 33))
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    width = min(WIDTHS.get(name, 0.0) * car.edge, LENGTH_SHARE * length)
    if component == "roof" or name == "shoulder":
        width = min(width, STRIP_SHARE * car.ledge)
    if name in ("rear_window_base", "deck_edge"):
        tail = car.wheelbase + car.rear_overhang - car.tail_rake
        deck = tail - car.rear_base - max(car.tail_bow, car.rear_bow)
        width = min(width, STRIP_SHARE * deck)

    kind: Kind = "round" if width > 0.0 else "crease"
    if name in ("front_arch", "rear_arch"):
        kind = "arch"
    return Line(name, kind, component, at, ridge(at, sides, width, (not centre, True)))


def _edges(outline: Outline) -> list[Line]:
    surfaces, paths = outline.surfaces, outline.paths

    def on(name: str, path: Path, inward: tuple[float, float]) -> Side:
        return Side(surfaces[name], path, np.array(inward))

    low, high = segment([0.5, 0], [1, 0]), segment([0.5, 1], [1, 1])
    right, left = segment([1, 0], [1, 1]), segment([0, 0], [0, 1])
    long_low, long_high = segment([0, 0], [1, 0]), segment([0, 1], [1, 1])
    up, down, less, more = (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0), (1.0, 0.0)

    def roof(name: str, one: Side, two: Side, centre: bool) -> Line:
        return _line(outline, name, "roof", (one, two), centre)

    def body(name: str, one: Side, two: Side, centre: bool) -> Line:
        return _line(outline, name, "body", (one, two), centre)

    base, foot, belt = (
        on("top", paths["windscreen_base"], down),
        on("top", paths["rear_window_base"], up),
        on("top", paths["belt_line"], more),
    )
    result = [
        roof("windscreen_base", base, on("screen", low, up), True),
        roof("roof_front", on("screen", high, down), on("roof", low, up), True),
        roof("roof_rear", on("roof", high, down), on("window", high, down), True),
        roof("rear_window_base", foot, on("window", low, up), True),
        roof("a_pillar", on("screen", right, less), on("glass", left, more), False),
        roof("c_pillar", on("window", right, less), on("glass", right, less), False),
        roof("roof_rail", on("roof", right, less), on("glass", long_high, down), False),
        roof("belt_line", belt, on("glass", long_low, up), False),
        body("front_bottom", on("nose", low, up), on("floor", low, up), True),
        body("hood_edge", on("nose", high, down), on("top", low, up), True),
        body("deck_edge", on("top", high, down), on("tail", high, down), True),
        body("rear_bottom", on("tail", low, up), on("floor", high, down), True),
        body("front_corner", on("nose", right, less), on("side", left, more), False),
        body("rear_corner", on("tail", right, less), on("side", right, less), False),
        body("shoulder", on("top", right, less), on("side", long_high, down), False),
    ]
    front, rear = outline.houses
    spans = {
        "sill_front": (0.0, front.feet[0]),
        "sill_middle": (front.feet[1], rear.feet[0]),
        "sill_rear": (rear.feet[1], 1.0),
    }
    for name, (a, b) in spans.items():
        above, below = segment([a, 0], [b, 0]), segment([1, a], [1, b])
        result.append(body(name, on("side", above, up), on("floor", below, less), False))
    return result


def _smooth(outline: Outline, ridges: list[Ridge]) -> list[Line]:
    """The profiles in the middle plane, the lines that others hide, and the wheelhouses' seams.

    They cross the roundings of other edges, and so move with them.
    """
    base = float(outline.paths["windscreen_base"](np.zeros(1))[0, 1])
    foot = float(outline.paths["rear_window_base"](np.zeros(1))[0, 1])
    spans: list[tuple[str, Kind, Component, str, float, float]] = [
        ("windscreen_profile", "profile", "roof", "screen", 0.0, 1.0),
        ("roof_profile", "profile", "roof", "roof", 0.0, 1.0),
        ("rear_window_profile", "profile", "roof", "window", 0.0, 1.0),
        ("front_profile", "profile", "body", "nose", 0.0, 1.0),
        ("hood_profile", "profile", "body", "top", 0.0, base),
        ("cabin_profile", "hidden", "body", "top", base, foot),
        ("deck_profile", "profile", "body", "top", foot, 1.0),
        ("rear_profile", "profile", "body", "tail", 0.0, 1.0),
        ("bottom_profile", "profile", "body", "floor", 0.0, 1.0),
    ]
    result: list[Line] = []

    def add(
        name: str,
        kind: Kind,
        component: Component,
        surface: Coons,
        start: list[float],
        end: list[float],
    ) -> None:
        path = segment(start, end)
        mine = [one for one in ridges if surface in one.surfaces and kind != "hidden"]

        def at(t: Floats) -> Points:
            return rounded(surface, surface(path(t)), mine)

        result.append(Line(name, kind, component, at, None))

    for name, kind, component, surface, a, b in spans:
        add(name, kind, component, outline.surfaces[surface], [0.5, a], [0.5, b])
    for house in outline.houses:
        a, b = house.feet
        side, tub = outline.surfaces["side"], house.surfaces[f"{house.name}_tub"]
        add(f"{house.name}_opening", "hidden", "body", side, [a, 0.0], [b, 0.0])
        for where, bend in zip(("front", "rear"), house.bends, strict=True):
            name = f"{house.name}_bend_{where}"
            add(name, "seam", _component(house), tub, [bend, 0.0], [bend, 1.0])
    return result


def _component(house: Wheelhouse) -> Component:
    return "front_wheelhouse" if house.name == "front" else "rear_wheelhouse"


def _house_edges(outline: Outline, house: Wheelhouse) -> list[Line]:
    side, floor = outline.surfaces["side"], outline.surfaces["floor"]
    tub, wall = house.surfaces[f"{house.name}_tub"], house.surfaces[f"{house.name}_wall"]
    component = _component(house)
    low, high = segment([0, 0], [1, 0]), segment([0, 1], [1, 1])
    left, right = segment([0, 0], [0, 1]), segment([1, 0], [1, 1])
    feet, line = house.feet, inner_line(floor, house.inner)
    deep = line(np.array(feet))
    middle = np.array([(feet[0] + feet[1]) / 2.0, 0.0])
    up, down, more, less = np.array([[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0]])

    def inner(t: Floats) -> Points:
        return line(feet[0] + t * (feet[1] - feet[0]))

    def around(t: Floats) -> Points:
        """The inner arch's parameters on the wall: up its left, along its top, down its right."""
        a, b = house.bends
        rise, along = np.clip(t / a, 0.0, 1.0), np.clip((t - a) / (b - a), 0.0, 1.0)
        return np.stack([along, np.minimum(rise, np.clip((1.0 - t) / (1.0 - b), 0, 1))], axis=1)

    def edge(suffix: str, one: Side, two: Side) -> Line:
        return _line(outline, f"{house.name}_{suffix}", component, (one, two), False)

    wall_side = Side(wall, around, np.array([0.5, 0.5]), radial=-1.0)
    return [
        edge("arch", Side(side, house.arch, middle, radial=1.0), Side(tub, low, up)),
        edge("inner_arch", Side(tub, high, down), wall_side),
        edge("tub_front", Side(tub, left, more), Side(floor, segment([1, feet[0]], deep[0]), down)),
        edge("tub_rear", Side(tub, right, less), Side(floor, segment([1, feet[1]], deep[1]), up)),
        edge("inner_sill", Side(floor, inner, less), Side(wall, low, up)),
    ]  # fmt: skip
