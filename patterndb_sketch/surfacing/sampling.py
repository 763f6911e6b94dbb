"""Sampling a network: every curve in equal steps, corners kept, patches sharing the samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from patterndb.geometry.quadshape import PLANAR, plane_normal
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import CORNER_ANGLE, measure_angles, measure_turning

#: Without another spacing, the median curve is sampled in this many edges: a quarter circle
#: then turns by 7.5 degrees from edge to edge, well below a corner.
EDGES_OF_MEDIAN_CURVE = 12

#: With quads the median curve has this many: artists' quads are as coarse as the shape allows.
EDGES_OF_MEDIAN_QUADS = 4

#: However short it is, a stretch turns by no more than this from edge to edge, in radians: a
#: small half circle is not to become its own diameter.
MOST_TURNING_OF_EDGE = math.radians(30)

#: A stretch is straight if none of its points is further from the line between its ends than this
#: part of its length, and a cycle is flat if its curves are as near to one plane: half of what
#: makes a loop of samples planar, so that rounding does not part the two.
STRAIGHT = PLANAR / 2.0

#: The most samples of a network. A patch of b boundary vertices has up to b**2 / 8 inside.
MAX_SAMPLES = 1_000_000


@dataclass(frozen=True, slots=True)
class Sampling:
    """The vertices that the patches of a network share.

    points:  (v, 3) float64: the network's nodes in their order, then inner samples.
    along:   for every curve the vertices along it, int64, from its first node to its second.
    corners: (v,) bool: is there a corner within a curve? At nodes False; there it depends on
             the cycle, see :func:`loop_of`.
    spacing: about how far vertices are apart, in the units of the points.
    """

    points: Points = field(repr=False)
    along: tuple[NDArray[np.int64], ...] = field(repr=False)
    corners: NDArray[np.bool_] = field(repr=False)
    spacing: float


@dataclass(frozen=True, slots=True)
class Loop:
    """A cycle as a closed polyline of shared vertices.

    points:   (n, 3) float64, n >= 3, the first not repeated at the end.
    corners:  (n,) bool: does the cycle, as drawn, turn there by more than CORNER_ANGLE?
    vertices: (n,) int64, which vertices of the sampling they are; no two are the same.
    """

    points: Points = field(repr=False)
    corners: NDArray[np.bool_] = field(repr=False)
    vertices: NDArray[np.int64] = field(repr=False)


def default_spacing(network: CurveNetwork, edges: int = EDGES_OF_MEDIAN_CURVE) -> float:
    """The spacing at which the median curve has so many edges; a closed one counts as quarters.

    Raises InvalidNetworkError for a network without curves.
    """
    if not network.curves:
        raise InvalidNetworkError("the network has no curves; there is nothing to sample")
    # The number of edges is one for a quarter circle.
    lengths = [curve.length / (4 if curve.closed else 1) for curve in network.curves]
    return float(np.median(lengths)) / edges


def stretches(curve: Curve) -> list[Points]:
    """The parts of a curve between its corners, in order, each a polyline (k, 3).

    Corners are judged on the curve as drawn. A closed curve's stretches begin at its node,
    corner or not.
    """
    corners = 1 + np.flatnonzero(measure_turning(curve.points) > CORNER_ANGLE)
    cuts = [0, *corners.tolist(), len(curve.points) - 1]
    return [curve.points[a : b + 1] for a, b in pairwise(cuts)]


def edges_at(curve: Curve, spacing: float) -> list[int]:
    """Edges of every stretch of the curve, each about ``spacing`` long, turning little enough."""
    counts: list[int] = []
    for part in stretches(curve):
        turning = float(measure_turning(part).sum())
        fewest = 1 + int(turning / MOST_TURNING_OF_EDGE)
        counts.append(max(fewest, round(float(arc_length(part)[-1]) / spacing)))
    # A loop needs three edges to enclose anything.
    if curve.closed and sum(counts) < 3:
        counts[0] += 3 - sum(counts)
    return counts


def count_coarse_edges(
    network: CurveNetwork, cycles: Sequence[Cycle], coarse: Sequence[bool], spacing: float
) -> list[list[int]]:
    """Count the edges of every stretch of every curve, straight ones between flat faces as one.

    coarse: for every cycle, whether its patch needs no vertices within straight stretches where it
    is flat. All others, and curves of no cycle, have the edges that :func:`edges_at` gives them.
    """
    check_spacing(spacing)
    bare = [False] * len(network.curves)
    needed = set[int]()
    for cycle, may in zip(cycles, coarse, strict=True):
        network.walk(cycle)
        flat = may and plane_normal(network.polyline(cycle), STRAIGHT) is not None
        for curve in cycle.curves:
            bare[curve] = True
            if not flat:
                needed.add(curve)
    counts = [edges_at(curve, spacing) for curve in network.curves]
    for number, curve in enumerate(network.curves):
        if bare[number] and number not in needed:
            parts = stretches(curve)
            counts[number] = [
                1 if _is_straight(part) else count
                for part, count in zip(parts, counts[number], strict=True)
            ]
    return counts


def check_spacing(spacing: float) -> None:
    """Raise InvalidNetworkError for a spacing that is not above 0."""
    if not (math.isfinite(spacing) and spacing > 0):
        raise InvalidNetworkError(f"the spacing is {spacing}; give a length above 0")


def _is_straight(part: Points) -> bool:
    along = part[-1] - part[0]
    length = float(np.linalg.norm(along))
    if length == 0.0:
        return False
    across = np.cross(part - part[0], along / length)
    return float(np.linalg.norm(across, axis=1).max()) <= STRAIGHT * length


def sample(
    network: CurveNetwork,
    spacing: float | None = None,
    edges: Sequence[Sequence[int]] | None = None,
) -> Sampling:
    """The network's vertices: every stretch of every curve in edges of equal arc length.

    spacing: about how long an edge is, by default :func:`default_spacing`. edges: the number
    of edges of every stretch of every curve, by default as :func:`edges_at` has them.
    Raises InvalidNetworkError for a spacing that is not above 0 or makes more than
    MAX_SAMPLES vertices, and for edges that do not go with the stretches.
    """
    spacing = default_spacing(network) if spacing is None else spacing
    check_spacing(spacing)
    wanted = sum(curve.length for curve in network.curves) / spacing
    if wanted > MAX_SAMPLES:
        raise InvalidNetworkError(
            f"a spacing of {spacing:g} would make {wanted:.3g} vertices on the curves; the limit "
            f"is {MAX_SAMPLES:,}, so make it longer"
        )
    counts = [edges_at(curve, spacing) for curve in network.curves] if edges is None else edges
    points = [network.nodes]
    corners = [np.zeros(len(network.nodes), bool)]
    along: list[NDArray[np.int64]] = []
    n_vertices = len(network.nodes)
    for curve, of_stretches in zip(network.curves, counts, strict=True):
        inner, is_corner = _inside(curve, of_stretches)
        first, last = curve.nodes
        along.append(np.r_[first, n_vertices + np.arange(len(inner)), last].astype(np.int64))
        n_vertices += len(inner)
        points.append(inner)
        corners.append(is_corner)
    return Sampling(np.concatenate(points), tuple(along), np.concatenate(corners), spacing)


def loop_of(network: CurveNetwork, sampling: Sampling, cycle: Cycle) -> Loop:
    """The cycle's closed polyline of samples.

    At nodes, whether there is a corner is judged on the curves as drawn. Raises
    InvalidNetworkError as :meth:`CurveNetwork.walk` does, and for a cycle with fewer than three
    vertices.
    """
    network.walk(cycle)
    parts: list[NDArray[np.int64]] = []
    corners: list[NDArray[np.bool_]] = []
    for before, step in zip((cycle.steps[-1], *cycle.steps), cycle.steps, strict=False):
        curve, backward = step
        vertices = sampling.along[curve]
        part = vertices[:0:-1] if backward else vertices[:-1]
        is_corner = sampling.corners[part]
        is_corner[0] = _turning_between(network, before, step) > CORNER_ANGLE
        parts.append(part)
        corners.append(is_corner)
    vertices = np.concatenate(parts)
    if len(vertices) < 3:
        raise InvalidNetworkError(
            f"the cycle {network.names(cycle)} has {len(vertices)} vertices and encloses "
            "nothing; make the spacing shorter"
        )
    return Loop(sampling.points[vertices], np.concatenate(corners), vertices)


def _inside(curve: Curve, counts: Sequence[int]) -> tuple[Points, NDArray[np.bool_]]:
    """The samples between the curve's nodes, and which of them are corners."""
    parts = stretches(curve)
    if len(parts) != len(counts) or min(counts) < 1:
        raise InvalidNetworkError(
            f"curve {curve.id!r} has {len(parts)} stretches between corners, and {list(counts)} "
            "as their edges; give one number >= 1 for each"
        )
    pieces = [_sampled(part, count)[:-1] for part, count in zip(parts, counts, strict=True)]
    points = np.concatenate(pieces)
    is_corner = np.zeros(len(points), bool)
    is_corner[np.cumsum([0, *counts[:-1]])] = True
    return points[1:], is_corner[1:]


def _sampled(part: Points, count: int) -> Points:
    """The stretch in ``count`` edges, the same to the last bit whichever way it was drawn."""
    if part.tolist() <= part[::-1].tolist():
        return sample_polyline(part, count)
    return sample_polyline(part[::-1], count)[::-1]


def _turning_between(
    network: CurveNetwork, before: tuple[int, bool], step: tuple[int, bool]
) -> float:
    arriving = network.along(before)
    leaving = network.along(step)
    return float(
        measure_angles((arriving[-1] - arriving[-2])[None], (leaving[1] - leaving[0])[None])[0]
    )
