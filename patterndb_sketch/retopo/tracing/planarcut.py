"""Cuts of the surface by a plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.retopo.tracing.planarcut import find_cut_sides, follow_cut, place_crossing
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.tracing.curves import Trace

#: Vertices this near to the plane, as a part of the diagonal, are on it: what is lost of a
#: coordinate in a dot product.
ON_PLANE = 1e-14

TOUCHES = "the plane only touches the surface there; turn it a little"


def cut_by_plane(
    surface: Surface, start: SurfacePoints, normal: ArrayLike, limit: float | None = None
) -> Trace:
    """The curve in which a plane cuts the surface, followed from one of its points.

    start: one foot, which the plane goes through; normal: (3,) the plane's, of any length. The
    curve is followed both ways: it closes, or ends at the borders of the surface on both sides.
    The half of the surface that the normal points to lies on its left, seen from outside.
    limit: length at which it is given up (the released program of Takayama et al. 2013 takes
    10 times the user's line).

    A vertex on the plane counts as on the normal's side, so that the curve never branches; a
    facet in the plane is passed along its rim, on the side away from the normal.
    Raises InvalidRetopoError for no foot or no direction; RefusedError if it gets longer than
    the limit, or if the plane only touches the surface there.

    Differs from the program: exact from side to side of the triangles;
    :meth:`Trace.sample` has it at even steps, not at 9 points from crossing to crossing.
    """
    across = np.asarray(normal, np.float64)
    if across.shape != (3,) or not np.isfinite(across).all() or not across.any():
        raise InvalidRetopoError(
            f"the normal of a cut is {normal!r}; give a direction [x, y, z] other than 0"
        )
    if len(start) != 1 or start.triangles[0] < 0:
        raise InvalidRetopoError(f"a cut starts at one point of the surface, not {len(start)}")
    height = (surface.vertices - start.points[0]) @ (across / np.linalg.norm(across))
    height[np.abs(height) < ON_PLANE * surface.diagonal] = 0.0
    first = _find_first_cut(surface, height, start)
    if first < 0:
        raise RefusedError(TOUCHES)
    most = np.inf if limit is None else float(limit)
    vertices, triangles, across = surface.vertices, surface.triangles, surface.adjacency.across
    out, into = find_cut_sides(triangles, height, first)
    ahead, length, closed = follow_cut(vertices, triangles, across, height, out, most)
    held = np.roll(ahead // 3, -1)
    if not closed and length <= most:
        ends = [place_crossing(vertices, triangles, height, side) for side in (into, out)]
        length += float(np.linalg.norm(ends[1] - ends[0]))
        back, further, _ = follow_cut(vertices, triangles, across, height, into, most - length)
        length += further
        # Every side stands for the triangle that the curve leaves by it; the first triangle's
        # own segment joins both ways.
        held = np.concatenate([back[:0:-1], ahead]) // 3
        ahead = np.concatenate([back[::-1], ahead])
    if length > most:
        raise RefusedError(
            f"the cut is longer than its limit, {limit:.4g}; raise the limit, or turn the plane"
        )
    points = np.array([place_crossing(vertices, triangles, height, side) for side in ahead])
    trace = _drop_still_segments(points, held.astype(np.int32), bool(closed))
    if len(trace.triangles) < (3 if closed else 1):
        raise RefusedError(TOUCHES)
    return trace


def _drop_still_segments(points: Points, held: Int32Array, closed: bool) -> Trace:
    """The trace without segments of no length, where the cut turns about a vertex."""
    follower = np.roll(points, -1, axis=0) if closed else points[1:]
    moves = (points[: len(follower)] != follower).any(axis=1)
    kept = moves if closed else np.r_[moves, True]
    return Trace(points[kept], held[moves], closed)


def _find_first_cut(surface: Surface, height: NDArray[np.float64], start: SurfacePoints) -> int:
    """The start's triangle, if the plane passes through it; else the nearest that it does among
    those joined to it by vertices on the plane; -1 without."""
    triangles = surface.triangles
    sign = height >= 0.0
    own = int(start.triangles[0])
    if sign[triangles[own]].any() and not sign[triangles[own]].all():
        return own
    level = height == 0.0
    reached = np.zeros(len(height), np.bool_)
    reached[triangles[own]] = level[triangles[own]]
    while True:
        touched = reached[triangles].any(axis=1)
        grown = reached.copy()
        grown[triangles[touched]] = True
        grown &= level
        if (grown == reached).all():
            break
        reached = grown
    count = sign[triangles].sum(axis=1)
    mixed = np.flatnonzero(touched & (count > 0) & (count < 3))
    if len(mixed) == 0:
        return -1
    middle = np.zeros((len(mixed), 3))
    for i, f in enumerate(mixed):
        for side in find_cut_sides(triangles, height, f):
            middle[i] += 0.5 * place_crossing(surface.vertices, triangles, height, side)
    off = np.linalg.norm(middle - start.points[0], axis=1)
    return int(mixed[np.argmin(off)])
