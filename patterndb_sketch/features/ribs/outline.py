"""The outline of a slice near the backbone: one segment as it is, or several by a picture."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.features.ribs.bridges import bridged
from patterndb_sketch.features.ribs.contour import outer_contour, passing
from patterndb_sketch.features.ribs.crossings import foot, nearest_segment
from patterndb_sketch.features.ribs.drawing import begun, drawn, framing
from patterndb_sketch.features.ribs.overhangs import chosen, without_overhangs
from patterndb_sketch.features.ribs.polygon import along_runs, simple, thinned
from patterndb_sketch.features.ribs.raster import MARGIN, closed_gaps
from patterndb_sketch.features.ribs.related import related
from patterndb_sketch.features.ribs.segments import joined
from patterndb_sketch.features.ribs.slicing import cut_edges
from patterndb_sketch.features.ribs.walking import AROUND, walk

#: Ends this close to others, as a share of the radius, leave a gap that is to be closed: as much
#: as dilation may close within the picture's margin. At the usual radius 0.28 % of the diagonal,
#: or 13 mm of a car.
GAP = 0.055

#: Where two segments cross, both may hang over by this share of the radius: at the usual radius
#: 0.75 % of the diagonal, or 35 mm of a car.
OVERHANG = 0.15

#: How often overhangs are taken off, and ends joined: what one leaves may be for the next.
MENDS = 4

#: Edges this close touch, as a share of the tolerance for stitching: points are computed to some
#: 1e-15 of the diagonal.
TOUCH = 1e-3

#: Arc length to either side of the backbone, as a share of the radius, over which the side of a
#: surface is taken.
WINDOW = 0.2


@kernel
def chord_normal(
    points: Points, low: Index, high: Index, edge: int, share: float, reach: float
) -> tuple[float, float]:
    """The right normal of the polyline ``low:high`` about a place on an edge: of the chord from
    ``reach`` before to ``reach`` behind, or of the edge if that has no length."""
    x = points[edge, 0] + share * (points[edge + 1, 0] - points[edge, 0])
    y = points[edge, 1] + share * (points[edge + 1, 1] - points[edge, 1])
    ends = np.empty((2, 2))
    for side in range(2):
        at_x, at_y = x, y
        k = edge if side == 0 else edge + 1
        step = -1 if side == 0 else 1
        left = reach
        while low <= k < high and left > 0.0:
            size = math.hypot(points[k, 0] - at_x, points[k, 1] - at_y)
            part = 1.0 if size <= left else left / size
            at_x += part * (points[k, 0] - at_x)
            at_y += part * (points[k, 1] - at_y)
            left -= size
            k += step
        ends[side, 0], ends[side, 1] = at_x, at_y
    dx, dy = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
    size = math.hypot(dx, dy)
    if size <= 1e-6 * reach:
        dx, dy = points[edge + 1, 0] - points[edge, 0], points[edge + 1, 1] - points[edge, 1]
        size = math.hypot(dx, dy)
    return dy / size, -dx / size


@kernel
def _mended(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    radius: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, float, bool]:
    """The segments that belong to the one nearest to the origin, without what hangs over and
    joined where that leaves no choice; the widest gap to be closed, -1 if the nearest segment is
    alone and has none; and was anything taken off or joined?"""
    gap, touch = GAP * radius, TOUCH * tolerance
    changed = False
    widest = -1.0
    for step in range(MENDS + 1):
        label, touching, gaps, free = related(
            points, offsets, closed, rims, touch, gap, OVERHANG * radius
        )
        nearest = nearest_segment(points, offsets)[0]
        kept = np.flatnonzero(label == label[nearest])
        tangled = len(kept) > 1 or touching[nearest] or gaps[nearest] > 0.0
        widest = gaps[kept].max() if tangled else -1.0
        points, offsets, closed, rims, free = chosen(points, offsets, closed, rims, free, kept)
        if not tangled or step == MENDS:
            break
        points, offsets, closed, rims, trimmed = without_overhangs(
            points, offsets, closed, rims, free, touch, tolerance
        )
        if not trimmed:
            points, offsets, closed, rims, joins = bridged(
                points, offsets, closed, rims, free, gap, tolerance
            )
            if not joins:
                break
        changed = True
    return points, offsets, closed, rims, widest, changed


@kernel
def sliced(
    corners: Points,
    triangles: Int32Array,
    components: Int32Array,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origin: Points,
    axes: Points,
    radius: float,
    tolerance: float,
) -> tuple[Points, Int32Array, Bools, Bools, float, Points, int, bool]:
    """The segments that belong to the one nearest to the origin: points, offsets, closed and rims
    as of Segments, without overhangs where segments cross, and joined where ends face each other.

    Then the widest gap to be closed, -1 if the nearest segment is alone and has none; (2, 2) the
    foot of the origin and the unit normal of the nearest segment there; its number; and whether
    any was shortened or joined.
    """
    ends, keys, _ = cut_edges(
        corners, triangles, components, boxes, nodes, order, origin, axes, radius
    )
    points, offsets, closed, rims = joined(ends, keys, tolerance)
    about = np.zeros((2, 2))
    if not len(closed):
        return points, offsets, closed, rims, -1.0, about, -1, False
    points, offsets, closed, rims, gap, mended = _mended(
        points, offsets, closed, rims, radius, tolerance
    )
    nearest, edge, share, _ = nearest_segment(points, offsets)
    for c in range(2):
        about[0, c] = points[edge, c] + share * (points[edge + 1, c] - points[edge, c])
    about[1, 0], about[1, 1] = chord_normal(
        points, offsets[nearest], offsets[nearest + 1], edge, share, WINDOW * radius
    )
    return points, offsets, closed, rims, gap, about, nearest, mended


@kernel
def rounds_for(gap: float, scale: float) -> int:
    """How many dilations close a gap: the paper's one, or as many as the gap needs, so long as
    they stay within the margin. Two pixels meet after k if they are 2 k + 1 apart, and the pixels
    of two places are apart by less than one more than those."""
    needed = math.ceil(0.5 * gap * scale)
    return min(max(needed, 1), MARGIN - 1)


@kernel
def repaired(
    points: Points,
    offsets: Int32Array,
    closed: Bools,
    rims: Bools,
    about: Points,
    outward: float,
    radius: float,
    rounds: int,
    gap: float,
    tolerance: float,
) -> tuple[Points, bool, int, tuple[int, int]]:
    """The outer contour through the foot by way of a picture, the outside on its right.

    points to about: as of sliced(). outward: +1 or -1, the sign that makes the normal there point
    out. rounds: of dilation and erosion; below 1 they follow from the gap.

    (p, 2) the polygon, is it closed, how many rounds, and how both ends came about.
    """
    scale, low_x, low_y, rows, columns = framing(points, radius)
    pixels = np.empty_like(points)
    for k in range(len(points)):
        pixels[k, 0] = (points[k, 0] - low_x) * scale
        pixels[k, 1] = (points[k, 1] - low_y) * scale
    k = rounds if rounds > 0 else rounds_for(gap, scale)
    first, known = drawn(pixels, offsets, closed, rims, rows, columns)
    picture = closed_gaps(first, k)
    x, y = (about[0, 0] - low_x) * scale, (about[0, 1] - low_y) * scale
    border = outer_contour(picture, x, y)
    start = passing(border, first, x, y, outward * about[1, 0], outward * about[1, 1])
    if start < 0:
        return points[:0].copy(), False, k, (0, 0)
    s, t = begun(known, first, border, start, 1, min(400, len(border)), True)
    none = (np.empty(0, np.int32), np.empty(0), np.empty(0))
    one = walk(known, first, border, start, 1, s, t, none)
    ahead = along_runs(points, known, (one[0], one[1], one[2]), one[3] != AROUND)
    if one[3] == AROUND:
        if len(ahead) < 3:
            return ahead[:0], False, k, (0, 0)
        ring = thinned(np.concatenate((ahead, ahead[:1])), tolerance)
        ring[len(ring) - 1] = ring[0]
        return simple(ring, True, TOUCH * tolerance), True, k, (one[3], one[3])
    two = walk(known, first, border, start, -1, s, t, (one[0], one[1], one[2]))
    behind = along_runs(points, known, (two[0], two[1], two[2]), True)
    polygon = thinned(np.concatenate((behind[::-1].copy(), ahead)), tolerance)
    # Contours run counter-clockwise, background on their right, as polygons do.
    return simple(polygon, False, TOUCH * tolerance), False, k, (two[3], one[3])


@kernel
def off_backbone(points: Points) -> float:
    """Distance of the origin from a polygon."""
    best = np.inf
    for k in range(len(points) - 1):
        best = min(best, foot(points, k, 0.0, 0.0)[0])
    return best
