"""Cycles with the surface that they were drawn for: what a method of surfacing ought to find.

Every cycle is the outline of a surface given by a formula, chosen for what the shape means and
not for how a method answers: a designer who draws the outline of a bumper means the bumper.
Four of them (ribbon, bumper, the patches of cup and horse) are after the figures of
Abbasinejad et al. 2013. Only the outline is given to a method, so what bulges between the curves
cannot be known to any: the same share of every method's distance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.curvenetwork.polylines import drop_repeats
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)

#: Vertices around a cycle, about, unless told otherwise.
VERTICES = 120

#: Rows and columns of a surface's net: its chords are then within 1e-4 of the formula.
ALONG, ACROSS = 256, 48


@dataclass(frozen=True, slots=True)
class Intended:
    """A cycle and the surface that it means.

    name:      what it is. means: the designer's intention, in words.
    loop:      the cycle as closed polyline of samples; every one is on the surface's boundary.
    vertices:  (v, 3) float64 and triangles: (t, 3) int64, the surface: a disk.
    """

    name: str
    means: str
    loop: Loop = field(repr=False)
    vertices: Points = field(repr=False)
    triangles: NDArray[np.int64] = field(repr=False)

    @property
    def diagonal(self) -> float:
        """The diagonal of the box around the cycle."""
        return float(np.linalg.norm(np.ptp(self.loop.points, axis=0)))


def of_net(name: str, means: str, net: Points, vertices: int = VERTICES) -> Intended:
    """The surface through a net of points (m, n, 3), outlined by its four edges.

    An edge of no length is a tip. vertices: how many the cycle is to have, about.
    """
    edges = [net[:, 0], net[-1], net[::-1, -1], net[0, ::-1]]
    sides = [side for side in edges if arc_length(side)[-1] > 0.0]
    return Intended(name, means, _loop(sides, vertices), *_triangulated(net))


def of_fan(
    name: str,
    means: str,
    outline: Points,
    lifted: Callable[[Points], Points],
    vertices: int = VERTICES,
) -> Intended:
    """The surface ``lifted`` over a region of the plane that can be seen whole from the origin.

    outline: (k, 2) counter-clockwise, the first point again at the end.
    """
    shares = np.linspace(0.0, 1.0, ACROSS + 1)
    net = lifted((outline[:, None] * shares[:, None]).reshape(-1, 2))
    net = net.reshape(len(outline), len(shares), 3)
    net[-1], net[:, 0] = net[0], net[0, 0]
    return Intended(name, means, _loop([net[:, -1]], vertices), *_triangulated(net))


def _loop(sides: Sequence[Points], vertices: int) -> Loop:
    """The samples around sides that join; corners are found as in any drawn network."""
    n = len(sides)
    curves = tuple(
        Curve(drop_repeats(side), (i, (i + 1) % n), i, i) for i, side in enumerate(sides)
    )
    network = CurveNetwork(curves, np.array([side[0] for side in sides]))
    spacing = sum(curve.length for curve in curves) / vertices
    return loop_of(network, sample(network, spacing), Cycle(tuple((i, False) for i in range(n))))


def _triangulated(net: Points) -> tuple[Points, NDArray[np.int64]]:
    """A net's squares in two triangles each, points at one place made one."""
    m, n = net.shape[:2]
    vertices, name = np.unique(net.reshape(-1, 3), axis=0, return_inverse=True)
    at = name.reshape(m, n)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    halves = [np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]
    triangles = np.concatenate([half.reshape(-1, 3) for half in halves])
    ahead = np.roll(triangles, -1, axis=1)
    return vertices, triangles[(triangles != ahead).all(axis=1)].astype(np.int64)


def _grid(along: int = ALONG, across: int = ACROSS) -> tuple[Points, Points]:
    """(along + 1, across + 1) parameters from 0 to 1 along and across."""
    u, v = np.meshgrid(np.linspace(0, 1, along + 1), np.linspace(0, 1, across + 1), indexing="ij")
    return u, v


def _at(x: Points, y: Points, z: Points) -> Points:
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)


def _polygon(corners: Sequence[tuple[float, float]], edges: int = 24) -> Points:
    """The closed outline of a polygon in the plane, so many points on every side."""
    solid = [np.array([x, y, 0.0]) for x, y in (*corners, corners[0])]
    sides = [sample_polyline(np.stack(side), edges)[:-1, :2] for side in pairwise(solid)]
    return np.concatenate([*sides, solid[:1][0][None, :2]])


def ribbon(turn: float) -> Intended:
    """A long strip, six times as long as wide, twisted about its middle by ``turn`` degrees."""
    u, v = _grid()
    across, angle = v - 0.5, np.radians(turn) * u
    net = _at(6.0 * u, across * np.cos(angle), across * np.sin(angle))
    return of_net(f"ribbon {turn:.0f}°", "a strip that stays as wide as it is and twists", net)


def helix(turns: int) -> Intended:
    """A spiral ramp, its rail twice as far out as its inner edge."""
    u, v = _grid()
    angle, radius = 2.0 * np.pi * turns * u, 0.5 + 0.5 * v
    net = _at(radius * np.cos(angle), radius * np.sin(angle), 0.6 * turns * u)
    return of_net(f"helix {turns}", "a ramp, level from its inner to its outer rail", net, 150)


def bumper() -> Intended:
    """A band around a car's front: U-shaped in plan, bulging between its two edges."""
    u, v = _grid()
    angle = np.pi * u
    flat = 2.0 / 3.0  # of a superellipse: rounded corners between the front and the flanks
    bulge = 1.0 + 0.06 * np.sin(np.pi * v) - 0.05 * v
    x = -np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** flat * bulge
    y = np.abs(np.sin(angle)) ** flat * (0.25 + 0.55 * bulge)
    z = 0.35 * v + 0.06 * np.sin(angle) * (1.0 - v)
    return of_net(
        "bumper", "a band of even height around the front, bulging outwards", _at(x, y, z)
    )


def wheel_arch() -> Intended:
    """A car's side: bowed in plan and section, with half a circle cut out for the wheel."""
    half = np.linspace(np.pi, 0.0, 97)
    wheel = np.stack([0.55 * np.cos(half), 0.0 * half, 0.55 * np.sin(half)], axis=1)
    ends = np.array([[-1.6, 0.0, 0.0], [-0.55, 0.0, 0.0], [0.55, 0.0, 0.0], [1.2, 0.0, 0.0]])
    lower = np.concatenate(
        [sample_polyline(ends[:2], 40)[:-1], wheel, sample_polyline(ends[2:], 40)[1:]]
    )
    upper = sample_polyline(np.array([[-1.6, 0.0, 0.9], [1.2, 0.0, 0.9]]), len(lower) - 1)
    v = np.linspace(0.0, 1.0, ACROSS + 1)[:, None]
    net = lower[:, None] * (1.0 - v) + upper[:, None] * v
    net[..., 1] = -0.12 * net[..., 0] ** 2 - 0.15 * net[..., 2] ** 2
    return of_net("wheel arch", "one smooth body side around the cut-out", net)


def cup_quarter() -> Intended:
    """A quarter of a tea cup, from the foot to the rim."""
    u, v = _grid()
    radius = 0.35 + 0.25 * np.sin(0.5 * np.pi * u) ** 0.8
    angle = 0.5 * np.pi * v
    net = _at(radius * np.cos(angle), radius * np.sin(angle), 0.7 * u)
    return of_net("cup quarter", "a quarter of a surface of revolution", net)


def cup_handle() -> Intended:
    """A cup's handle: a flat band of even width, bent in the shape of a C."""
    u, v = _grid()
    angle = np.radians(-110.0 + 220.0 * u)
    net = _at(0.3 * np.cos(angle), 0.14 * (v - 0.5), 0.4 * np.sin(angle))
    return of_net("cup handle", "a band of even width along a C", net)


def saddle() -> Intended:
    """A round saddle: smooth all around, without a corner."""
    turn = np.linspace(0.0, 2.0 * np.pi, ALONG + 1)

    def lifted(p: Points) -> Points:
        return np.c_[p, 0.35 * (p[:, 0] ** 2 - p[:, 1] ** 2)]

    outline = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return of_fan("saddle", "a hyperbolic paraboloid over a disk", outline, lifted)


def roof() -> Intended:
    """A gable roof: its two slopes meet in a ridge that was not drawn."""
    u, v = _grid()
    net = _at(2.4 * u, 1.6 * v, 0.7 * (1.0 - np.abs(2.0 * v - 1.0)))
    return of_net("gable roof", "two planes that meet in a straight ridge", net)


def horse_leg() -> Intended:
    """The front half of a leg: two long profiles, half a ring at the hip and at the hoof."""
    u, v = _grid()
    radius = 0.12 + 0.2 * (1.0 - u) ** 2 + 0.05 * np.exp(-(((u - 0.55) / 0.08) ** 2))
    forward = 0.12 * np.sin(2.2 * np.pi * u)
    angle = np.pi * (v - 0.5)
    net = _at(forward + radius * np.cos(angle), radius * np.sin(angle), -1.8 * u)
    return of_net("horse leg", "half a round limb between its two profiles", net)


def dolphin_side() -> Intended:
    """A quarter of a body that tapers to a point at both ends: two curves, two tips."""
    u, v = _grid()
    u = 0.5 - 0.5 * np.cos(np.pi * u)
    radius = 1.5 * u**0.75 * (1.0 - u)
    radius[[0, -1]] = 0.0
    angle = 0.5 * np.pi * v
    net = _at(2.6 * u, 0.8 * radius * np.cos(angle), radius * np.sin(angle) + 0.3 * u**2)
    net[0], net[-1] = net[0, 0], net[-1, 0]
    return of_net("dolphin side", "a quarter of a round body", net)


def wavy() -> Intended:
    """Four wavy sides and what Coons (1967) spans between them, blended bilinearly."""
    t = np.linspace(0.0, 1.0, 97)
    wave = np.sin(np.pi * t)
    south = _at(2.0 * t, -0.2 * wave, 0.3 * np.sin(2.0 * np.pi * t))
    north = _at(2.0 * t, 1.4 + 0.25 * wave, 0.35 * wave)
    west = _at(-0.25 * wave, 1.4 * t, -0.3 * wave)
    east = _at(2.0 + 0.2 * np.sin(2.0 * np.pi * t), 1.4 * t, 0.25 * np.sin(3.0 * np.pi * t))
    u, v = t[:, None, None], t[None, :, None]
    lofted = (1 - v) * south[:, None] + v * north[:, None]
    lofted += (1 - u) * west[None] + u * east[None]
    bilinear = (1 - u) * ((1 - v) * south[0] + v * north[0])
    bilinear += u * ((1 - v) * south[-1] + v * north[-1])
    net = lofted - bilinear
    net[:, 0], net[:, -1], net[0], net[-1] = south, north, west, east
    net[0, 0], net[-1, 0], net[0, -1], net[-1, -1] = south[0], south[-1], north[0], north[-1]
    return of_net("wavy Coons", "the bilinearly blended Coons patch of its sides", net)


def planar(name: str, corners: Sequence[tuple[float, float]], edges: int = 24) -> Intended:
    """A polygon in a tilted plane; the whole of it is seen from the origin."""
    frame = np.linalg.qr(np.array([[3.0, 1.0], [-1.0, 2.0], [1.0, 2.0]]))[0]

    def lifted(p: Points) -> Points:
        return p @ frame.T

    return of_fan(name, "a flat face", _polygon(corners, edges), lifted)


def planar_l() -> Intended:
    """A flat L."""
    corners = [(-0.4, -0.4), (1.6, -0.4), (1.6, 0.3), (0.3, 0.3), (0.3, 1.2), (-0.4, 1.2)]
    return planar("planar L", corners)


def planar_star() -> Intended:
    """A flat star of five points."""
    angle = np.pi * np.arange(10) / 5.0
    radius = np.where(np.arange(10) % 2 == 0, 1.0, 0.42)
    corners = [(r * np.cos(a), r * np.sin(a)) for r, a in zip(radius, angle, strict=True)]
    return planar("planar star", [(float(x), float(y)) for x, y in corners])


def list_intended() -> Iterator[Intended]:
    """All of them."""
    for turn in (90.0, 180.0, 360.0):
        yield ribbon(turn)
    yield from (bumper(), wheel_arch(), helix(1), helix(2), cup_quarter(), cup_handle())
    yield from (saddle(), roof(), horse_leg(), dolphin_side(), wavy(), planar_l(), planar_star())
