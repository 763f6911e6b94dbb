"""Slices: the edges that a plane cuts out of a model's triangles near a point, and the segments
that they join to along the surface patches, then end to end."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from patterndb._native.features.ribs.slicing import cut_edges, join_edges, set_axes
from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools, Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.errors import InvalidFeatureError

#: Ends this close, as a share of the model's diagonal, are stitched, and points of a segment this
#: close are one. Coordinates in files have some seven digits.
STITCH = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """Cut edges in the frame of a plane.

    origin: (3,) the origin of the frame. axes: (3, 3) its x, its y and the plane's unit normal.
    ends:   (e, 2, 2) float64, the ends of the edges in the frame; all within the radius.
    keys:   (e, 2) int64, the mesh edge that each end lies on; ends of equal keys are one point,
            and equal bit for bit. RIM where the circle cuts an edge off.
    parts:  (e,) int32, the surface patch that the edge was cut from.
    """

    origin: Points
    axes: Points
    ends: Points
    keys: Int64Array
    parts: Int32Array

    def in_space(self, flat: Points) -> Points:
        """(n, 3) the points that have the coordinates (n, 2) in the frame."""
        return self.origin + flat @ self.axes[:2]


def slice_model(
    model: Surface, origin: ArrayLike, normal: ArrayLike, radius: float | None = None
) -> Slice:
    """The edges in which a plane through ``origin`` (3,) across ``normal`` (3,) meets the model.

    radius: what lies farther from the origin is cut off, in units of the model; RADIUS of the
            diagonal unless told. The frame's axes depend on the normal alone.

    A vertex on the plane counts as being above it: every triangle has two cut edges or none,
    and cuts of closed meshes are closed. Source: feature curve recovery paper, section 4.3.1.
    Raises InvalidFeatureError for a normal without length and a radius that is not above 0.
    """
    place, axes = find_plane(origin, normal)
    reach = RADIUS * model.diagonal if radius is None else float(radius)
    if not (math.isfinite(reach) and reach > 0.0):
        raise InvalidFeatureError(f"the radius of a rib is {reach}; give a length above 0")
    ends, keys, parts = cut_edges(
        model.corners, model.triangles, model.components, *model.boxes, place, axes, reach
    )
    return Slice(place, axes, ends, keys, parts)


def find_plane(origin: ArrayLike, normal: ArrayLike) -> tuple[Points, Points]:
    """(3,) the origin and (3, 3) the axes of a plane: x, y and the unit normal, right-handed."""
    place = np.array(origin, np.float64)
    across = np.array(normal, np.float64)
    if place.shape != (3,) or across.shape != (3,):
        raise InvalidFeatureError("a plane has one origin (3,) and one normal (3,)")
    size = math.hypot(*across)
    if not (np.isfinite(place).all() and math.isfinite(size) and size > 0.0):
        raise InvalidFeatureError(
            f"the plane at {place.tolist()} across {across.tolist()} is none: numbers must be "
            "finite, and the normal must have a length"
        )
    axes = np.empty((3, 3))
    set_axes(across / size, axes)
    return place, axes


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Polylines in the plane of a slice, none of a single point.

    points:  (p, 2) float64. offsets: (s + 1,) int32: segment i has the points
             ``offsets[i]:offsets[i + 1]``; a closed one ends with its first point.
    closed:  (s,) bool. rims: (s, 2) bool, is the first, the last point on the circle?
    """

    points: Points
    offsets: Int32Array
    closed: Bools
    rims: Bools

    def __len__(self) -> int:
        return len(self.closed)

    def __getitem__(self, i: int) -> Points:
        """(k, 2) the points of segment i."""
        return self.points[self.offsets[i] : self.offsets[i + 1]]


def segments_of(cut: Slice, tolerance: float) -> Segments:
    """The segments of a slice.

    Cut edges join where they cut the same mesh edge, so long as no third one does; then ends
    join that lie within ``tolerance`` of each other, so long as no third one does.
    Source: feature curve recovery paper, section 4.3.2.
    """
    return Segments(*join_edges(cut.ends, cut.keys, tolerance))
