"""Half of the ground: what lies on one side of the plane of symmetry."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.borders import border_loops
from patterndb_sketch.retopo.symmetry.plane import Plane

#: What is this near to the plane, as a part of the surface's diagonal, is on it. Source: the
#: released program of Takayama et al. 2013, which welds what is so near.
ON_PLANE = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Half:
    """The ground on the side of a plane that its normal points to, cut along it.

    ground:  triangles above the plane; the cut has vertices exactly on it, as near as floating
             point gets, and there normals of the surface and its image together.
    whole:   the ground that was cut.
    on:      (v,) bool, vertices of ``ground`` that are on the plane.
    near:    height below which points are on the plane.
    in_plane: how many triangles lie in the plane, and are left out.
    """

    plane: Plane
    ground: Ground
    whole: Ground
    on: NDArray[np.bool_]
    near: float
    in_plane: int

    def seams(self) -> list[Run]:
        """The curves in which the plane cuts the ground."""
        found: list[Run] = []
        for loop in border_loops(self.ground):
            level = self.on[loop] & self.on[np.roll(loop, -1)]
            if level.all():
                found.append(Run(loop, True))
                continue
            # Begin where the border comes to the plane.
            starts = np.flatnonzero(level & ~np.roll(level, 1))
            for first in starts.tolist():
                around = np.roll(loop, -first)
                length = int(np.argmin(np.roll(level, -first)))
                found.append(Run(around[: length + 1], False))
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Vertices (k,) along the cut, the half ground on the left; a closed one does not repeat
    its first."""

    vertices: Int32Array
    closed: bool


def half_of(ground: Ground, plane: Plane) -> Half:
    """Cut the ground by a plane, and keep the side that the plane's normal points to.

    Vertices within ON_PLANE of the plane are moved onto it. Triangles that the plane passes are
    cut at exactly the same points as their neighbours. Raises RefusedError if nothing is on
    that side.
    """
    near = ON_PLANE * ground.diagonal
    vertices, triangles = ground.vertices.copy(), ground.triangles
    height = plane.heights(vertices)
    level = np.abs(height) <= near
    vertices[level] = plane.flattened(vertices[level])
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
    vertices = np.concatenate([vertices, plane.flattened(points)])
    kept = np.concatenate([triangles[above], cut])
    used = np.unique(kept)
    name = np.full(len(vertices), -1, np.int32)
    name[used] = np.arange(len(used), dtype=np.int32)
    found = Ground.of(vertices[used], name[kept])
    flags = np.zeros(len(found.vertices), np.bool_)
    flags[found.vertex] = on[used]
    normals = found.normals.copy()
    normals[flags] = plane.flattened_normals(normals[flags])
    found = replace(found, surface=replace(found.surface, normals=normals))
    return Half(plane, found, ground, flags, near, int((sign == 0.0).all(axis=1).sum()))


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
    t, m = _turned(triangles[tip], middle[tip], sign[tip] > 0.0)
    made.append(np.stack([t[:, 0], m[:, 0], m[:, 2]], axis=1))
    # Two above, one below: a quad, along its shorter diagonal.
    lost = (sign > 0.0).sum(axis=1) == 2
    t, m = _turned(triangles[lost], middle[lost], sign[lost] < 0.0)
    quad = np.stack([m[:, 0], t[:, 1], t[:, 2], m[:, 2]], axis=1)
    one = np.linalg.norm(everything[quad[:, 0]] - everything[quad[:, 2]], axis=1)
    two = np.linalg.norm(everything[quad[:, 1]] - everything[quad[:, 3]], axis=1)
    turned = np.where((one <= two)[:, None], quad, np.roll(quad, -1, axis=1))
    made += [turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]
    # One above, one on the plane, one below.
    through = (sign == 0.0).any(axis=1)
    t, m = _turned(triangles[through], middle[through], sign[through] > 0.0)
    second = np.where(m[:, 0] >= 0, m[:, 0], t[:, 1])
    third = np.where(m[:, 2] >= 0, m[:, 2], t[:, 2])
    made.append(np.stack([t[:, 0], second, third], axis=1))
    return points, np.concatenate(made).astype(np.int32)


def _turned(
    triangles: Int32Array, middle: NDArray[np.int64], first: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles and what belongs to their sides, begun at the one corner that ``first`` marks."""
    k = (np.argmax(first, axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles.astype(np.int64), k, 1), np.take_along_axis(middle, k, 1)
