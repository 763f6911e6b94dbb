"""Mirror in a plane, and cut in half by it: planes, the half of the surface, parts of strokes.

Read :class:`Plane`, :func:`cut_half` (the surface on one side, all that tools work on while
symmetry is on) and :func:`split_stroke` (strokes are drawn on the whole surface, and what is on the
half is kept).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network.edits import trace_borders
from patterndb_sketch.retopo.network.samples import interpolate_places
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tracing import SurfaceCurve

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane that mirrors; what is drawn lies on the side that its normal points to.

    point: on it. normal: of unit length. By default x = 0, and drawn is where x > 0.
    Raises InvalidRetopoError for what is not finite, and for a normal of another length.
    """

    point: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not (_is_vector(self.point) and _is_vector(self.normal)):
            raise InvalidRetopoError(
                f"the plane has the point {self.point} and the normal {self.normal}; "
                "give three finite numbers for each"
            )
        if abs(math.hypot(*self.normal) - 1.0) > 1e-9:
            raise InvalidRetopoError(
                f"the plane's normal {self.normal} is not of length 1; Plane.of takes any"
            )

    @classmethod
    def of(cls, point: ArrayLike, normal: ArrayLike) -> Plane:
        """Through a point (3,), at right angles to a direction (3,) of any length but 0."""
        at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
        size = float(np.linalg.norm(up)) if up.shape == (3,) else 0.0
        if at.shape != (3,) or not (math.isfinite(size) and size > 0.0):
            raise InvalidRetopoError(
                f"the plane has the point {point!r} and the normal {normal!r}; "
                "give [x, y, z] for each, the normal not 0"
            )
        # Adding 0 makes 0 of -0.
        x, y, z = (at + 0.0).tolist()
        u, v, w = (up / size + 0.0).tolist()
        return cls((x, y, z), (u, v, w))

    @property
    def reversed(self) -> Plane:
        """The same plane, drawn on its other side."""
        u, v, w = self.normal
        return replace(self, normal=(0.0 - u, 0.0 - v, 0.0 - w))

    def heights(self, points: Points) -> NDArray[np.float64]:
        """(n,) how far (n, 3) points are from it, positive on the side that is drawn on."""
        return (points - np.array(self.point)) @ np.array(self.normal)

    def mirror(self, points: Points) -> Points:
        """(n, 3) the images of points."""
        return points - (2.0 * self.heights(points))[:, None] * np.array(self.normal)

    def mirror_directions(self, directions: Points) -> Points:
        """(n, 3) the images of directions."""
        up = np.array(self.normal)
        return directions - (2.0 * (directions @ up))[:, None] * up

    def flatten(self, points: Points) -> Points:
        """(n, 3) the points of the plane nearest to points."""
        return points - self.heights(points)[:, None] * np.array(self.normal)

    def flatten_normals(self, normals: Points) -> Points:
        """(n, 3) unit normals turned into the plane; those at right angles to it stay.

        Half of a surface and its image have together these normals at the seam.
        """
        up = np.array(self.normal)
        flat = normals - (normals @ up)[:, None] * up
        level = np.linalg.norm(flat, axis=1) > 1e-6
        return np.where(level[:, None], units(flat), normals)


def _is_vector(vector: Vector) -> bool:
    return len(vector) == 3 and all(math.isfinite(x) for x in vector)


#: What is this near to the plane, as a part of the surface's diagonal, is on it. Source: the
#: released program of Takayama et al. 2013, which welds what is so near.
ON_PLANE = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Half:
    """The surface on the side of a plane that its normal points to, cut along it.

    surface:  triangles above the plane; the cut has vertices exactly on it, as near as floating
             point gets, and there normals of the surface and its image together.
    whole:   the surface that was cut.
    on:      (v,) bool, vertices of ``surface`` that are on the plane.
    near:    height below which points are on the plane.
    in_plane: how many triangles lie in the plane, and are left out.
    """

    plane: Plane
    surface: Surface
    whole: Surface
    on: NDArray[np.bool_]
    near: float
    in_plane: int

    def seams(self) -> list[SeamRun]:
        """The curves in which the plane cuts the surface."""
        found: list[SeamRun] = []
        for loop in trace_borders(self.surface):
            level = self.on[loop] & self.on[np.roll(loop, -1)]
            if level.all():
                found.append(SeamRun(loop, True))
                continue
            # Begin where the border comes to the plane.
            starts = np.flatnonzero(level & ~np.roll(level, 1))
            for first in starts.tolist():
                around = np.roll(loop, -first)
                length = int(np.argmin(np.roll(level, -first)))
                found.append(SeamRun(around[: length + 1], False))
        return found


@dataclass(frozen=True, slots=True, eq=False)
class SeamRun:
    """Vertices (k,) along the cut, the half surface on the left; a closed one does not repeat
    its first."""

    vertices: Int32Array
    closed: bool


def cut_half(surface: Surface, plane: Plane) -> Half:
    """Cut the surface by a plane, and keep the side that the plane's normal points to.

    Vertices within ON_PLANE of the plane are moved onto it. Triangles that the plane passes are
    cut at exactly the same points as their neighbours. Raises RefusedError if nothing is on
    that side.
    """
    near = ON_PLANE * surface.diagonal
    vertices, triangles = surface.vertices.copy(), surface.triangles
    height = plane.heights(vertices)
    level = np.abs(height) <= near
    vertices[level] = plane.flatten(vertices[level])
    height[level] = 0.0
    sign = np.sign(height)[triangles]
    above = (sign >= 0.0).all(axis=1) & (sign > 0.0).any(axis=1)
    passed = (sign > 0.0).any(axis=1) & (sign < 0.0).any(axis=1)
    if not (above.any() or passed.any()):
        raise RefusedError(
            "no part of the surface is on the side of the plane that its normal points to; "
            "turn the normal round, or move the plane"
        )
    points, cut = _cut(vertices, height, triangles[passed])
    on = np.concatenate([level, np.ones(len(points), np.bool_)])
    vertices = np.concatenate([vertices, plane.flatten(points)])
    kept = np.concatenate([triangles[above], cut])
    used = np.unique(kept)
    name = np.full(len(vertices), -1, np.int32)
    name[used] = np.arange(len(used), dtype=np.int32)
    found = Surface.from_arrays(vertices[used], name[kept]).orient()
    flags = np.zeros(len(found.vertices), np.bool_)
    flags[found.repairs.vertex] = on[used]
    normals = found.normals.copy()
    normals[flags] = plane.flatten_normals(normals[flags])
    found = found.inherit(normals)
    return Half(plane, found, surface, flags, near, int((sign == 0.0).all(axis=1).sum()))


def _cut(
    vertices: Points, height: NDArray[np.float64], triangles: Int32Array
) -> tuple[Points, Int32Array]:
    """(k, 3) new points where the plane passes triangles, and (t, 3) what is above of these; the
    new points are numbered after the vertices."""
    tail, head = triangles, np.roll(triangles, -1, axis=1)
    crossed = height[tail] * height[head] < 0.0
    low, high = np.minimum(tail, head).astype(np.int64), np.maximum(tail, head)
    keys, which = np.unique(((low << 32) | high)[crossed], return_inverse=True)
    a, b = keys >> 32, keys & 0xFFFFFFFF
    share = (height[a] / (height[a] - height[b]))[:, None]
    points = (1.0 - share) * vertices[a] + share * vertices[b]
    middle = np.full(triangles.shape, -1, np.int64)
    middle[crossed] = len(vertices) + which.reshape(-1)
    everything = np.concatenate([vertices, points])
    sign = np.sign(height)[triangles]
    made: list[NDArray[np.int64]] = []
    # One corner above, two below: its tip.
    tip = ((sign > 0.0).sum(axis=1) == 1) & ((sign < 0.0).sum(axis=1) == 2)
    t, m = _turn_to(triangles[tip], middle[tip], sign[tip] > 0.0)
    made.append(np.stack([t[:, 0], m[:, 0], m[:, 2]], axis=1))
    # Two above, one below: a quad, along its shorter diagonal.
    lost = (sign > 0.0).sum(axis=1) == 2
    t, m = _turn_to(triangles[lost], middle[lost], sign[lost] < 0.0)
    quad = np.stack([m[:, 0], t[:, 1], t[:, 2], m[:, 2]], axis=1)
    one = np.linalg.norm(everything[quad[:, 0]] - everything[quad[:, 2]], axis=1)
    two = np.linalg.norm(everything[quad[:, 1]] - everything[quad[:, 3]], axis=1)
    turned = np.where((one <= two)[:, None], quad, np.roll(quad, -1, axis=1))
    made += [turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]
    # One above, one on the plane, one below.
    through = (sign == 0.0).any(axis=1)
    t, m = _turn_to(triangles[through], middle[through], sign[through] > 0.0)
    second = np.where(m[:, 0] >= 0, m[:, 0], t[:, 1])
    third = np.where(m[:, 2] >= 0, m[:, 2], t[:, 2])
    made.append(np.stack([t[:, 0], second, third], axis=1))
    return points, np.concatenate(made).astype(np.int32)


def _turn_to(
    triangles: Int32Array, middle: NDArray[np.int64], first: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles and what belongs to their sides, begun at the one corner that ``first`` marks."""
    k = (np.argmax(first, axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles.astype(np.int64), k, 1), np.take_along_axis(middle, k, 1)


def measure_heights(half: Half, points: Points) -> NDArray[np.float64]:
    """(n,) heights of (n, 3) points above the plane, 0 for those on it."""
    height = half.plane.heights(points)
    height[np.abs(height) <= half.near] = 0.0
    return height


def find_plane_crossings(height: NDArray[np.float64], closed: bool) -> list[float]:
    """Where a polyline with these heights (n,) crosses the plane or comes to run in it, or leaves
    it: places in samples, ascending. One that only touches it with a sample goes on."""
    off = np.flatnonzero(height)
    n = len(height)
    if not len(off):
        return []
    found: list[float] = []
    if not closed and off[0] > 1:
        found.append(float(off[0] - 1))
    follower = np.r_[off[1:], off[0] + n] if closed else off[1:]
    for i, j in zip(off[: len(follower)].tolist(), follower.tolist(), strict=True):
        one, two = float(height[i]), float(height[j % n])
        if j == i + 1:
            if (one > 0.0) != (two > 0.0):
                found.append(i + one / (one - two))
        elif j > i + 2:
            found += [float((i + 1) % n), float((j - 1) % n)]
        elif (one > 0.0) != (two > 0.0):
            found.append(float((i + 1) % n))
    if not closed and off[-1] < n - 2:
        found.append(float(off[-1] + 1))
    return sorted(set(found))


#: A part of a stroke that begins and ends on the plane is drawn along it, not across the half, if
#: it never is further from it than this part of the snap radius.
ALONG = 0.5


#: A part shorter than this many samplings is what is left of an end on the plane.
SHORTEST = 2.0


def split_stroke(stroke: SurfaceCurve, half: Half, sizes: Sizes) -> tuple[list[SurfaceCurve], int]:
    """Split a stroke, cleaned on the whole surface, at the plane: its parts on the half, in order,
    and how many parts beyond the plane are left out.

    A closed stroke that crosses the plane becomes open parts. Where it was cut it is exactly on the
    plane, as near as floating point gets, and points nearer to it than ``half.near`` are moved
    there. Parts along the plane are left out.
    """
    line, up = stroke.points.copy(), stroke.normals
    height = measure_heights(half, line)
    line[height == 0.0] = half.plane.flatten(line[height == 0.0])
    places = find_plane_crossings(height, stroke.closed)
    n = len(line)
    if stroke.closed and places:
        bounds = [*places, places[0] + n]
    elif stroke.closed:
        parts = [replace(stroke, points=line)] if (height > 0.0).any() else []
        return parts, int((height < 0.0).any())
    else:
        bounds = sorted({0.0, *places, float(n - 1)})
    parts: list[SurfaceCurve] = []
    beyond = 0
    for begin, finish in pairwise(bounds):
        inner = np.arange(int(np.floor(begin)) + 1, int(np.ceil(finish)))
        points, normals = interpolate_places(line, up, np.concatenate([[begin], inner, [finish]]))
        for k, place in ((0, begin), (-1, finish)):
            if stroke.closed or place in places:
                points[k] = half.plane.flatten(points[k][None])[0]
        there = measure_heights(half, points)
        if there.min() < 0.0:
            beyond += 1
        elif not _is_along_plane(points, there, sizes):
            parts.append(SurfaceCurve(points, normals, False, stroke.missed))
    return parts, beyond


def _is_along_plane(points: Points, height: NDArray[np.float64], sizes: Sizes) -> bool:
    """Is a part along the plane, or what is left of an end that touched it?"""
    on = height[[0, -1]] == 0.0
    if on.all() and height.max() <= ALONG * sizes.snap:
        return True
    return bool(on.any()) and float(arc_length(points)[-1]) < SHORTEST * sizes.sampling


def refuse_beyond(stroke: SurfaceCurve, half: Half, what: str) -> None:
    """Raise RefusedError if a stroke is partly beyond the plane; ``what`` is drawn, in words."""
    if (measure_heights(half, stroke.points) < 0.0).any():
        raise RefusedError(
            f"{what} crosses the plane of symmetry, or is beyond it; draw it on the side that is "
            "worked on"
        )
