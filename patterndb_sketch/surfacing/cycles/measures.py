"""What a candidate cycle looks like: its flatness, and the surface that it seems to span.

The surface is the triangulation of least area of a coarse sampling. It says where the surface
lies beside each of the cycle's curves, and whether another curve of the network runs into it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb._native.surfacing.cycles.measures import measure
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.curvenetwork.polylines import measure_turning
from patterndb_sketch.surfacing.cycles.closing import HalfCurves

#: A curve is sampled once per this much turning, in radians, from 1 to MOST_EDGES edges: enough
#: to tell surfaces apart, not to build them. A closed curve has at least CLOSED_EDGES.
TURNING_OF_EDGE = math.radians(25)
MOST_EDGES = 6

CLOSED_EDGES = 12


#: What a cycle earns per length. A cycle worse than this is left out even where nothing else
#: would bound its curves.
REWARD = 2.0

#: Badness per unit of flatness, sqrt(lambda3 / lambda1).
FLATNESS = 1.0

#: Badness per radian of bending; the bending of a patch that closes around a corner of the
#: shape, 0.6, is as bad as any: six-sided patches have more.
BENDING = 0.5
MOST_BENDING = 0.6

#: Badness if curves run into the surface at all of its nodes. One of four nodes outweighs what
#: flatness and bending say.
CUTS = 3.0

#: Badness of a cycle from which curves leave to both sides of its surface, at right angles, at
#: every node: a section of what they outline, such as a ring around a tube or a great circle.
SECTION = 1.0

#: Badness of a cycle that goes straight on at every node, where two other curves do so across it: a
#: section, too, whatever surface spans it. It grows from nothing as curves bend there.
CROSSED = 2.0

#: Badness per stroke of the cycle, and per corner beyond four.
STROKE = 0.05
CORNER = 0.15

USUAL_CORNERS = 4

#: A cycle that is flatter may have as many corners as it likes, such as the ground of a prism.
FLAT = 0.02

#: Badness of narrowness, length / (4 sqrt(area)) - 1, 0 for a square and below; at most
#: MOST_NARROWNESS counts.
NARROWNESS = 0.3
MOST_NARROWNESS = 5.0

#: An area below this part of the squared length encloses nothing: two curves drawn twice.
NO_AREA = 1e-9

#: Two cycles at a curve fold back on each other if their surfaces there are less than acos(0.9),
#: 26 degrees, apart. FOLD is the cost of lying on each other, per length.
FOLD_COSINE = 0.9
FOLD = 1.0


@dataclass(frozen=True, slots=True)
class CycleMeasures:
    """Measures of k candidate cycles with s steps in all.

    length:   (k,) arc length.
    flatness: (k,) sqrt(lambda3 / lambda1), lambda the eigenvalues of the points' covariance.
    area:     (k,) of the triangulation.
    bending:  (k,) radians, angles between neighbouring triangles, by the length of their edge
              over the cycle's length.
    corners:  (k,) nodes at which the cycle turns by more than TURN.
    cuts:     (k,) how many nodes have a curve that runs into the surface: 1 for each with one
              within the surface, falling to 0 at 45 degrees off it and at a side of the cycle.
    section:  (k,) how far curves leave to both sides of the surface, at the node where they do so
              least: 1 where all are at right angles to it, 0 at 30 degrees.
    crossed:  (k,) the mean, over its nodes, of how straight the cycle goes on there (the squared
              cosine of its turning), times how straight two others go on across it (likewise, times
              the least sine to the cycle).
    inward:   (s, 3) unit vectors: at each step, where the surface lies, across the curve.
    """

    length: Floats = field(repr=False)
    flatness: Floats = field(repr=False)
    area: Floats = field(repr=False)
    bending: Floats = field(repr=False)
    corners: Floats = field(repr=False)
    cuts: Floats = field(repr=False)
    section: Floats = field(repr=False)
    crossed: Floats = field(repr=False)
    inward: Points = field(repr=False)


def measure_cycles(
    network: CurveNetwork, halves: HalfCurves, cycles: Sequence[Cycle]
) -> CycleMeasures:
    """The measures of cycles of the network."""
    parts = [
        sample_polyline(curve.points, _edges(curve.points, curve.closed))
        for curve in network.curves
    ]
    offsets = np.r_[0, np.cumsum([len(part) for part in parts])]
    samples = np.concatenate(parts) if parts else np.zeros((0, 3))
    # By a power of two, which changes no digit: squares of areas are neither 0 nor infinite.
    size = int(np.frexp(np.abs(samples).max(initial=0.0))[1])
    samples, parts = np.ldexp(samples, -size), [np.ldexp(part, -size) for part in parts]
    leaving = np.concatenate([[part[1] - part[0], part[-2] - part[-1]] for part in parts])
    leaving = units(leaving)
    steps = np.array([2 * c + back for cycle in cycles for c, back in cycle.steps], np.int64)
    first = np.r_[0, np.cumsum([len(cycle.steps) for cycle in cycles])]
    values = np.zeros((len(cycles), 8))
    inward = np.zeros((len(steps), 3))
    for i, (a, b) in enumerate(pairwise(first.tolist())):
        measure(
            steps[a:b],
            samples,
            offsets,
            halves.start,
            halves.first,
            halves.leaving,
            leaving,
            values[i],
            inward[a:b],
        )
    length, flatness, area, bending, corners, cuts, section, crossed = np.ascontiguousarray(
        values.T
    )
    length, area = np.ldexp(length, size), np.ldexp(area, 2 * size)
    return CycleMeasures(length, flatness, area, bending, corners, cuts, section, crossed, inward)


def _edges(points: Points, closed: bool) -> int:
    turning = float(measure_turning(points).sum())
    if closed:
        return max(CLOSED_EDGES, min(4 * MOST_EDGES, 1 + int(turning / TURNING_OF_EDGE)))
    return min(MOST_EDGES, 1 + int(turning / TURNING_OF_EDGE))


def rate_badness(measures: CycleMeasures, n_curves: Floats, n_strokes: Floats) -> Floats:
    """(k,) the badness of cycles with so many curves and strokes (k,), inf if they enclose nothing.

    A plainer cost, length (1 + 6 sqrt(lambda3 / lambda1)) (1 + 0.1 strokes), does not know a patch
    that a curve runs into.
    """
    length, area = measures.length, measures.area
    enclosing = area > NO_AREA * length**2
    narrowness = length / (4.0 * np.sqrt(np.where(enclosing, area, 1.0))) - 1.0
    more_corners = np.maximum(measures.corners - USUAL_CORNERS, 0.0)
    bad = (
        FLATNESS * measures.flatness
        + BENDING * np.minimum(measures.bending, MOST_BENDING)
        + CUTS * measures.cuts / n_curves
        + SECTION * measures.section
        + CROSSED * measures.crossed
        + STROKE * n_strokes
        + CORNER * np.where(measures.flatness < FLAT, 0.0, more_corners)
        + NARROWNESS * np.clip(narrowness, 0.0, MOST_NARROWNESS)
    )
    return np.where(enclosing, bad, np.inf)


def price_folds(
    cycles: Sequence[Cycle], inward: Sequence[NDArray[np.float64]], length: Floats
) -> dict[tuple[int, int], float]:
    """What pairs of cycles cost because they fold back on each other at curves they share.

    inward: per cycle the directions (steps, 3) of :class:`CycleMeasures`. length: (m,) of the
    network's curves.
    """
    at: dict[int, list[tuple[int, NDArray[np.float64]]]] = {}
    for i, (cycle, directions) in enumerate(zip(cycles, inward, strict=True)):
        for curve, direction in zip(cycle.curves, directions, strict=True):
            at.setdefault(curve, []).append((i, direction))
    cost: dict[tuple[int, int], float] = {}
    for curve, meeting in sorted(at.items()):
        directions = np.array([direction for _, direction in meeting])
        fold = np.maximum(directions @ directions.T - FOLD_COSINE, 0.0) / (1.0 - FOLD_COSINE)
        for a, b in np.argwhere(np.triu(fold, 1) > 0.0).tolist():
            pair = meeting[a][0], meeting[b][0]
            cost[pair] = cost.get(pair, 0.0) + float(FOLD * length[curve] * fold[a, b])
    return cost
