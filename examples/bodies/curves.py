"""The named curves of a body: what they are, where they lie, and how their edges are rounded.

An edge is rounded so that its ridge stays a known curve. Where two surfaces meet along a curve,
their cross-section is a corner with legs of slope sin(a) to both sides of the bisector. A usual
fillet would cut the corner off and leave the place of the ridge open. Here both surfaces are moved
outwards along the bisector, by

    sin(a) (s - g(s)),   g(s) = sqrt(s^2 + w^2) - w

at the distance s from the curve, so that the corner becomes a hyperbola with its apex on the
curve: the curve stays where it is, the surfaces share their tangent planes along it, and the
curvature across has its greatest value there, sin(a) / (w cos(a)^2), up to what the surfaces
themselves curve (a shift of the order of w^3 times the change of their curvature). The width w
falls to zero at the curve's ends: corners, where curves meet, are sharp points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

from bodies.coons import Coons, Curve, segment, unit
from bodies.outline import Outline, Path, Wheelhouse, inner_line
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points

#: Samples of a curve to find feet on it: a curve of 4 m bends by less than 1e-6 m between two.
SAMPLES = 1601

#: Every so many samples the slopes of the surfaces are taken, and interpolated between.
COARSE = 10

#: A rounding ends at this many widths from the curve; the hyperbola is at 90 % of its legs.
REACH = 10.0

#: The width grows from a curve's ends over this many widths, at most this share of its length.
RAMP = 10.0
RAMP_SHARE = 0.3

#: Points as near as this, in metres, are on the curve.
ON_CURVE = 3e-6


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """One of the surfaces that meet along a curve.

    path:   the curve's parameters there. inward: (2,) a direction in them that leads into it;
            if ``radial`` is 1 or -1, a point that it leads away from or towards.
    """

    surface: Coons
    path: Curve
    inward: Floats
    radial: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Ridge:
    """A curve along which two surfaces meet, rounded.

    parameters: (m,); points: (m, 3) there. bisector: (m, 3) unit, outwards.
    sines:      per side (m,), sin(a) of its leg: positive on a convex edge.
    widths:     (m,) the width w.
    sides:      the surfaces that meet, and where the curve lies in them.
    """

    parameters: Floats
    points: Points
    bisector: Points
    sines: tuple[Floats, Floats]
    widths: Floats
    sides: tuple[Side, Side]
    tree: KDTree

    @property
    def surfaces(self) -> tuple[Coons, Coons]:
        return self.sides[0].surface, self.sides[1].surface

    def radius(self) -> Floats:
        """(m,) radius of the cross-section on the curve: 0 where sharp."""
        sine = np.abs(sum(self.sines) / 2.0)
        return self.widths * (1.0 - sine**2) / np.maximum(sine, 1e-9)

    def foot(self, points: Points) -> tuple[Floats, Int64Array, Floats]:
        """(n,) distances of points (n, 3), the segments of their feet, and how far along."""
        _, near = self.tree.query(points)
        best = np.full(len(points), np.inf)
        segment, along = np.zeros(len(points), np.int64), np.zeros(len(points))
        for shift in (-1, 0):
            first = np.clip(np.asarray(near) + shift, 0, len(self.points) - 2)
            start = self.points[first]
            run = self.points[first + 1] - start
            share = np.einsum("ij,ij->i", points - start, run) / np.einsum("ij,ij->i", run, run)
            share = np.clip(share, 0.0, 1.0)
            distance = np.linalg.norm(points - start - share[:, None] * run, axis=1)
            nearer = distance < best
            best[nearer] = distance[nearer]
            segment[nearer], along[nearer] = first[nearer], share[nearer]
        return best, segment, along


def ridge(curve: Curve, sides: tuple[Side, Side], width: float, ends: tuple[bool, bool]) -> Ridge:
    """The curve between two surfaces, rounded by ``width``, sharp at the ``ends`` that say so."""
    t = np.linspace(0.0, 1.0, SAMPLES)
    points = curve(t)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.r_[0.0, np.cumsum(steps)]
    # The surfaces' slopes change slowly: fewer samples of them will do.
    few = slice(None, None, COARSE)
    tangents = unit(np.gradient(points, along, axis=0, edge_order=2))[few]
    normals: list[Points] = []
    conormals: list[Points] = []
    for side in sides:
        at = np.clip(side.path(t[few]), 0.0, 1.0)
        dp, dq = side.surface.slopes(at)
        lead = np.broadcast_to(side.inward, at.shape)
        if side.radial:
            lead = side.radial * (at - side.inward)
        into = lead[:, :1] * dp + lead[:, 1:] * dq
        into = into - np.einsum("ij,ij->i", into, tangents)[:, None] * tangents
        normals.append(side.surface.outward * unit(np.cross(dp, dq)))
        conormals.append(unit(into))
    rough = unit(normals[0] + normals[1])
    bisector = unit(CubicSpline(t[few], rough)(t))
    sines = tuple(CubicSpline(t[few], -np.einsum("ij,ij->i", into, rough))(t) for into in conormals)
    ramp = min(RAMP * width, RAMP_SHARE * along[-1])
    widths = np.full(len(t), width)
    if width > 0.0:
        for sharp, way in ((ends[0], along), (ends[1], along[-1] - along)):
            if sharp:
                widths = widths * smooth(way / ramp)
    return Ridge(
        t, points, bisector, (sines[0], sines[1]), widths,
        sides, KDTree(points),
    )  # fmt: skip


def rounded(surface: Coons, points: Points, ridges: Sequence[Ridge]) -> Points:
    """The points (n, 3) of a surface, moved by the ridges along it.

    A ridge's share fades to none, with its slope, towards every other ridge of the surface:
    each has its own rounding and no other's.
    """
    feet = [one.foot(points) for one in ridges]
    moved = points.copy()
    for i, one in enumerate(ridges):
        if not one.widths.any():
            continue
        s, segment, along = feet[i]
        near = (s > ON_CURVE) & (s < REACH * one.widths.max())
        for j, other in enumerate(feet):
            if j != i:
                near &= other[0] > ON_CURVE
        k = np.flatnonzero(near)
        if not len(k):
            continue
        share = along[k]
        at = segment[k]

        def blend(values: Floats, at: Int64Array = at, share: Floats = share) -> Floats:
            low, high = values[at], values[at + 1]
            weight = share if values.ndim == 1 else share[:, None]
            return low + weight * (high - low)

        width = blend(one.widths)
        sine = blend(one.sines[one.surfaces.index(surface)])
        distance = s[k]
        lift = sine * (distance + width - np.hypot(distance, width))
        lift *= 1.0 - smooth(distance / (REACH * one.widths.max()))
        for j, other in enumerate(feet):
            if j != i:
                lift *= smooth(other[0][k] / (other[0][k] + distance))
        moved[k] += lift[:, None] * blend(one.bisector)
    return moved


def smooth(x: Floats) -> Floats:
    """From 0 at x <= 0 to 1 at x >= 1, with two continuous derivatives."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (x * (6.0 * x - 15.0) + 10.0)


#: crease: a sharp edge. round: a rounded one, the curve is its ridge. arch: the edge of a wheel
#: arch, sharp or rounded. profile: where the middle plane cuts the body; the surface is smooth
#: there. seam: a line of the network on a smooth surface. hidden: off the surface, where another
#: component hides what would be the edge.
Kind = Literal["crease", "round", "arch", "profile", "seam", "hidden"]

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
    component: str
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
    outline: Outline, name: str, component: str, sides: tuple[Side, Side], centre: bool
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
    spans: list[tuple[str, Kind, str, str, float, float]] = [
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
        component: str,
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


def _component(house: Wheelhouse) -> str:
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
