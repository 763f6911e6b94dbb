"""Ribs across a curve, from a model of any quality."""

from __future__ import annotations

import math
from itertools import starmap

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.model import Model
from patterndb_sketch.features.ribs.outline import off_backbone, repaired, sliced
from patterndb_sketch.features.ribs.outward import signs
from patterndb_sketch.features.ribs.polygon import sampled
from patterndb_sketch.features.ribs.raster import MARGIN
from patterndb_sketch.features.ribs.rib import Rib
from patterndb_sketch.features.ribs.segments import STITCH
from patterndb_sketch.features.ribs.slicing import RADIUS, frame
from patterndb_sketch.features.ribs.walking import RIM_MET

#: Samples of a rib. Odd, so that one may lie in the middle.
SAMPLES = 201


def build_ribs(
    model: Model,
    origins: ArrayLike,
    tangents: ArrayLike,
    radius: float | None = None,
    samples: int = SAMPLES,
    rounds: int | None = None,
) -> tuple[Rib, ...]:
    """The ribs in the planes through (m, 3) origins across (m, 3) tangents of a curve.

    radius:  of the circles about the origins that ribs end at, in units of the model; RADIUS of
             its diagonal unless told.
    samples: of every rib.
    rounds:  of dilation and erosion where segments cross or leave gaps; unless told as many as
             the gaps between them need, at least one.

    Only segments that cross, touch or leave a gap to the one nearest to the origin, or to one of
    those, count: a lone one is taken as it is. Which side of the surface is outside is found
    for all ribs together, in the order given (outward.py).

    Source: feature curve recovery paper, sections 4.3.1 and 4.3.2. Differs from the paper:
    contours are followed to the circle or the end of a sheet, where it takes both sides of what
    is open.

    Raises InvalidFeatureError for tangents without length, a radius that is not above 0, fewer
    than 2 samples, and rounds that are not 1 to MARGIN - 1.
    """
    begin = as_points(origins, "origins of ribs", InvalidFeatureError)
    along = as_points(tangents, "tangents of ribs", InvalidFeatureError)
    if begin.shape != along.shape:
        raise InvalidFeatureError(
            f"there are {len(begin)} origins and {len(along)} tangents; give one for each"
        )
    reach = RADIUS * model.diagonal if radius is None else float(radius)
    if not (math.isfinite(reach) and reach > 0.0):
        raise InvalidFeatureError(f"the radius of ribs is {reach}; give a length above 0")
    if samples < 2:
        raise InvalidFeatureError(f"a rib has at least 2 samples, not {samples}")
    if rounds is not None and not 1 <= rounds < MARGIN:
        raise InvalidFeatureError(f"rounds are 1 to {MARGIN - 1}, not {rounds}")
    tolerance = STITCH * model.diagonal
    parts = (model.corners, model.triangles, model.components, *model.mesh.boxes)
    frames = list(starmap(frame, zip(begin, along, strict=True)))
    slices = [sliced(*parts, place, axes, reach, tolerance) for place, axes in frames]
    met = np.flatnonzero([len(one[0]) > 0 for one in slices])
    sides = np.ones(len(begin))
    if len(met):
        about = np.array([slices[i][5] for i in met])
        flat = np.array([frames[i][1][:2] for i in met])
        feet = begin[met] + np.einsum("mk,mkc->mc", about[:, 0], flat)
        sides[met] = signs(model, feet, np.einsum("mk,mkc->mc", about[:, 1], flat), reach)
    return tuple(
        _rib(place, axes, cut, side, reach, samples, rounds or 0, tolerance)
        for (place, axes), cut, side in zip(frames, slices, sides, strict=True)
    )


def build_rib(
    model: Model,
    origin: ArrayLike,
    tangent: ArrayLike,
    radius: float | None = None,
    samples: int = SAMPLES,
    rounds: int | None = None,
) -> Rib:
    """One rib, see :func:`build_ribs`."""
    one = np.asarray(origin, np.float64)[None]
    along = np.asarray(tangent, np.float64)[None]
    return build_ribs(model, one, along, radius, samples, rounds)[0]


def _rib(
    origin: Points,
    axes: Points,
    cut: tuple,
    side: float,
    radius: float,
    samples: int,
    rounds: int,
    tolerance: float,
) -> Rib:
    points, offsets, closed, rims, gap, about, nearest, mended = cut
    if not len(points):
        none = np.empty((0, 3))
        note = f"the model has nothing within {radius:g} of the backbone"
        return Rib(
            origin, axes, none, none, none, -1, math.inf, False, 0, False, (False, False), note
        )  # fmt: skip
    note = ""
    taken = 0
    polygon, around = points[:0], False
    reaches = False, False
    if gap >= 0.0:
        polygon, around, taken, ends = repaired(
            points, offsets, closed, rims, about, side, radius, rounds, gap, tolerance
        )
        reaches = ends[0] == RIM_MET, ends[1] == RIM_MET
        if len(polygon) < 2:
            note = "no contour passes the backbone: the nearest segment is taken as it is"
    if len(polygon) < 2:
        polygon = points[offsets[nearest] : offsets[nearest + 1]]
        around = bool(closed[nearest])
        reaches = bool(rims[nearest, 0]), bool(rims[nearest, 1])
        if side < 0.0:
            polygon, reaches = polygon[::-1].copy(), (reaches[1], reaches[0])
    flat, directions, backbone = sampled(polygon, around, samples)
    return Rib(
        origin,
        axes,
        origin + polygon @ axes[:2],
        origin + flat @ axes[:2],
        directions @ axes[:2],
        backbone,
        float(off_backbone(polygon)),
        around,
        taken,
        mended,
        reaches,
        note,
    )
