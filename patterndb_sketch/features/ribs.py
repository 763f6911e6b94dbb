"""Ribs: the outlines of a model in planes across a curve, near the curve, with their outside.

A plane cuts edges out of the model's triangles (:func:`slice_model`), which join to segments along
the surface patches, then end to end (:func:`segments_of`). The segments of a slice that belong to
the nearest one (slice_segments) are the rib as they are if they are one, else a picture of them is
(trace_outline). Which side of a surface is outside, where triangles do not show it, is found for
all ribs together (find_signs).

The compiled core has the rest, in rust/features/src/ribs: crossings (how segments cross and touch),
repair (overhangs and gaps), raster and walking (what is still tangled, by way of a picture),
polygon (the outline, simple and sampled).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise, starmap

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.features.ribs.polygon import sample_polygon
from patterndb._native.features.ribs.rib import measure_off_backbone, slice_segments, trace_outline
from patterndb._native.features.ribs.slicing import cut_edges, join_edges, set_axes
from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools, Points, as_points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.errors import InvalidFeatureError

#: Ends this close, as a share of the model's diagonal, are stitched, and points of a segment this
#: close are one. Coordinates in files have some seven digits.
STITCH = 1e-6

#: Pixels left free at every side of a picture, so that dilation never meets the border. MARGIN of
#: rust/features/src/ribs/walking.rs is the same.
MARGIN = 12

#: How a walk along an outline ends at the circle: ``Ended`` in rust/features/src/ribs/walking.rs.
RIM_MET = 1

#: Arc length to either side of the backbone, as a share of the radius, over which the side of a
#: surface is taken.
WINDOW = 0.2

#: Directions that are looked along from a point, and points looked from for all ribs at once.
DIRECTIONS, PROBES = 32, 24

#: How far a point may lie below what is seen, as a share of the ribs' radius: sheets lie doubled.
SUNK = 0.02

#: Cosine between the normals of neighbouring ribs from which they tell which sides correspond.
SURE = 0.3

#: Samples of a rib. Odd, so that one may lie in the middle.
SAMPLES = 201


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
    reach = _choose_radius(model, radius)
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


def _choose_radius(model: Surface, radius: float | None) -> float:
    """Return the radius of ribs in units of the model, by default RADIUS of its diagonal."""
    reach = RADIUS * model.diagonal if radius is None else float(radius)
    if not (math.isfinite(reach) and reach > 0.0):
        raise InvalidFeatureError(f"the radius of ribs is {reach}; give a length above 0")
    return reach


@dataclass(frozen=True, slots=True, eq=False)
class Rib:
    """Where a sample of the curve may move to.

    origin:   (3,) float64, the point of the backbone. axes: (3, 3) x, y and the unit normal of
              the rib's plane.
    polygon:  (p, 3) float64, points of cut edges and of changes between them; the last is the
              first again if ``closed``. It does not cross itself.
    points:   (n, 3) float64, samples of the polygon at equal arc length.
    normals:  (n, 3) float64 unit vectors in the plane, outward. Ribs run so that the cross
              product of their direction and the plane's normal is outward.
    backbone: the sample nearest to the origin; -1 if there is none.
    away:     how far the polygon is from the origin; inf without one.
    closed:   the whole outline lies within the radius; it is cut open opposite the origin.
    rounds:   of dilation and erosion, 0 if no picture was needed.
    joined:   did segments lose what hangs over at crossings, or were gaps between them bridged?
    reaches:  does the first, the last sample lie on the circle? If not, a sheet ends there, or
              the outline meets itself.
    note:     what is not as it should be, "" if all is.

    A rib without samples: the model has nothing within the radius.
    """

    origin: Points
    axes: Points
    polygon: Points
    points: Points
    normals: Points
    backbone: int
    away: float
    closed: bool
    rounds: int
    joined: bool
    reaches: tuple[bool, bool]
    note: str

    @property
    def repaired(self) -> bool:
        """Do segments cross or leave gaps, so that the rib is put together from several?"""
        return self.joined or self.rounds > 0

    def __len__(self) -> int:
        return len(self.points)


def build_ribs(
    model: Surface,
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
    for all ribs together, in the order given.

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
    reach = _choose_radius(model, radius)
    if samples < 2:
        raise InvalidFeatureError(f"a rib has at least 2 samples, not {samples}")
    if rounds is not None and not 1 <= rounds < MARGIN:
        raise InvalidFeatureError(f"rounds are 1 to {MARGIN - 1}, not {rounds}")
    sizes = _Sizes(reach, samples, rounds or 0, STITCH * model.diagonal)
    parts = (model.corners, model.triangles, model.components, *model.boxes)
    frames = list(starmap(find_plane, zip(begin, along, strict=True)))
    slices = [slice_segments(*parts, place, axes, reach, sizes.tolerance) for place, axes in frames]
    met = np.flatnonzero([len(one[0]) > 0 for one in slices])
    sides = np.ones(len(begin))
    if len(met):
        about = np.array([slices[i][5] for i in met])
        flat = np.array([frames[i][1][:2] for i in met])
        feet = begin[met] + np.einsum("mk,mkc->mc", about[:, 0], flat)
        sides[met] = find_signs(model, feet, np.einsum("mk,mkc->mc", about[:, 1], flat), reach)
    return tuple(
        _build_rib(place, axes, cut, side, sizes)
        for (place, axes), cut, side in zip(frames, slices, sides, strict=True)
    )


def build_rib(
    model: Surface,
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


@dataclass(frozen=True, slots=True)
class _Sizes:
    """The sizes that all ribs have.

    radius: how far they reach. samples: of each. rounds: of dilation, 0 for as many as gaps need.
    tolerance: points that are nearer to each other are one.
    """

    radius: float
    samples: int
    rounds: int
    tolerance: float


def _build_rib(origin: Points, axes: Points, cut: tuple, side: float, sizes: _Sizes) -> Rib:
    radius = sizes.radius
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
        polygon, around, taken, ends = trace_outline(
            points, offsets, closed, rims, about, side, radius, sizes.rounds, gap, sizes.tolerance
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
    flat, directions, backbone = sample_polygon(polygon, around, sizes.samples)
    return Rib(
        origin,
        axes,
        origin + polygon @ axes[:2],
        origin + flat @ axes[:2],
        directions @ axes[:2],
        backbone,
        float(measure_off_backbone(polygon)),
        around,
        taken,
        mended,
        reaches,
        note,
    )


def find_signs(model: Surface, feet: Points, normals: Points, radius: float) -> NDArray[np.float64]:
    """(m,) +1 or -1: the signs that make normals (m, 3) at feet (m, 3), on the surface and in the
    order of a curve, point out.

    Outside is where more of the world is seen: lines are drawn to a point from afar, from
    DIRECTIONS sides, and those count that meet nothing before it. Neighbours within the radius
    whose normals are nearly parallel share their votes, so that a curve has one outside even
    where clutter misleads the votes of some points. Where nothing is seen, or as much on both
    sides, outside is away from the middle of the model's box.
    """
    m = len(feet)
    relative = np.ones(m)
    cosine = np.einsum("ij,ij->i", normals[1:], normals[:-1])
    apart = np.linalg.norm(np.diff(feet, axis=0), axis=1) > radius
    breaks = np.r_[True, apart | (np.abs(cosine) < SURE)]
    relative[1:] = np.sign(cosine)
    run = np.cumsum(breaks) - 1
    for first, last in pairwise([*np.flatnonzero(breaks), m]):
        relative[first:last] = np.cumprod(np.r_[1.0, relative[first + 1 : last]])
    asked = _probes(run, m)
    seen = _seen(model, feet[asked], radius)
    ways = spread_directions(DIRECTIONS)
    votes = np.einsum("pd,dc,pc->p", seen.astype(np.float64), ways, normals[asked])
    total = np.bincount(run[asked], votes * relative[asked], run[-1] + 1)
    middle = 0.5 * (model.vertices.min(axis=0) + model.vertices.max(axis=0))
    away = np.einsum("ij,ij->i", feet - middle, normals) * relative
    fallback = np.bincount(run, weights=away)
    count = np.bincount(run[asked], minlength=len(total))
    tie = np.abs(total) < 1e-6 * np.maximum(count, 1)
    total = np.where(tie, fallback, total)
    return relative * np.where(total < 0.0, -1.0, 1.0)[run]


def _probes(run: NDArray[np.int64], m: int) -> NDArray[np.int64]:
    """The points to look from: spread over all, and at least one of every run."""
    even = np.unique(np.linspace(0, m - 1, min(m, PROBES)).round().astype(np.int64))
    first = np.searchsorted(run, np.arange(run[-1] + 1))
    last = np.searchsorted(run, np.arange(run[-1] + 1), side="right")
    return np.unique(np.r_[even, (first + last - 1) // 2])


def _seen(model: Surface, feet: Points, radius: float) -> NDArray[np.bool_]:
    """(p, DIRECTIONS) are points seen from afar?"""
    ways = spread_directions(DIRECTIONS)
    far = 2.0 * model.diagonal
    origins = (feet[:, None] + far * ways).reshape(-1, 3)
    rays = np.tile(-ways, (len(feet), 1))
    lengths = model.cast_rays(origins, rays).distances
    return (lengths > far - SUNK * radius).reshape(len(feet), DIRECTIONS)


def spread_directions(count: int) -> Points:
    """(count, 3) unit vectors, spread evenly: a spiral with the golden angle."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
