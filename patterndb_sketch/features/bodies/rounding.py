"""Rounded edges whose ridge is a known curve.

Where two surfaces meet along a curve, their cross-section is a corner with legs of slope
sin(a) to both sides of the bisector. A usual fillet would cut the corner off and leave the
place of the ridge open. Here both surfaces are moved outwards along the bisector, by

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

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.bodies.coons import Coons, Curve, unit

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

    def foot(self, points: Points) -> tuple[Floats, NDArray[np.int64], Floats]:
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

        def blend(values: Floats, at: NDArray[np.int64] = at, share: Floats = share) -> Floats:
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
