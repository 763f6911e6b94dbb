"""Candidate cycles: for each pair of curves at a node, the shortest paths that close them, and the
path that goes on in their plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb._native.surfacing.cycles.closing import (
    find_closing_paths,
    find_flat_polygon,
    measure_ways,
)
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import units
from patterndb.geometry.polyline import sample_polyline
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.curvenetwork.polylines import Groups

#: Paths that are begun, at most, to close one pair of curves. In all 28 CASSIE sketches with
#: patches together, 132 pairs would need more for 8 closings; that is reported.
MAX_PATHS = 3_000

#: A curve that leaves a node less than this off the plane of a pair, as a sine, goes on in it:
#: strokes drawn freehand in a plane do.
OFF_PLANE = 0.15

#: Two curves whose directions have a lesser sine lie in no plane of their own.
NO_PLANE = 0.2


#: Nodes of a path in a plane, at most: of those in the sketches at hand the longest has 12.
MOST_IN_PLANE = 128


def curve_ends(network: CurveNetwork) -> NDArray[np.int64]:
    """(m, 2) the nodes where every curve begins and ends."""
    return np.array([curve.nodes for curve in network.curves], np.int64).reshape(-1, 2)


def find_dangling(network: CurveNetwork) -> NDArray[np.bool_]:
    """(m,) bool: which curves dangle, also after others that dangle are gone.

    A closed curve never does.
    """
    ends = curve_ends(network)
    gone = np.zeros(len(ends), bool)
    while True:
        degree = np.bincount(ends[~gone].ravel(), minlength=len(network.nodes))
        more = ~gone & (degree[ends] == 1).any(axis=1)
        if not more.any():
            return gone
        gone |= more


def group_components(network: CurveNetwork, alive: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The curves (m,) bool that are alive, in groups that hang together by nodes."""
    ends = curve_ends(network)
    nodes = Groups(len(network.nodes))
    for a, b in ends[alive].tolist():
        nodes.unite(a, b)
    found: dict[int, list[int]] = {}
    for curve in np.flatnonzero(alive).tolist():
        found.setdefault(nodes.find(int(ends[curve, 0])), []).append(curve)
    return [np.array(group, np.int64) for group in found.values()]


#: A loop whose points lie this near to a line, as a share of its extent, encloses nothing.
NARROWEST = 1e-6


def find_lone_loops(network: CurveNetwork, alive: NDArray[np.bool_]) -> list[tuple[int, ...]]:
    """The sorted curves of every closed loop that no other living curve touches.

    Curves that lie on a line, or on one another, enclose nothing.
    """
    ends = curve_ends(network)
    degree = np.bincount(ends[alive].ravel(), minlength=len(network.nodes))
    return [
        tuple(sorted(curves.tolist()))
        for curves in group_components(network, alive)
        if (degree[ends[curves]] == 2).all() and _encloses_something(network, curves)
    ]


def _encloses_something(network: CurveNetwork, curves: NDArray[np.int64]) -> bool:
    points = np.concatenate([network.curves[c].points for c in curves.tolist()])
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[1] <= NARROWEST * extents[0]:
        return False
    if len(curves) != 2:
        return True
    one, other = (sample_polyline(network.curves[c].points, SAMPLES) for c in curves.tolist())
    gap = min(float(np.abs(one - way).max()) for way in (other, other[::-1]))
    return gap > NARROWEST * float(np.ptp(points, axis=0).max())


#: Points of two curves that are compared.
SAMPLES = 33


@dataclass(frozen=True, slots=True)
class HalfCurves:
    """A network's curves in both senses: 2 c is curve c from its first node, 2 c + 1 back.

    start, end: (2m,) int64, their nodes. length: (2m,), arc length.
    first:      (n + 1,) int64; half-curves leaving[first[v]:first[v + 1]] leave node v. Curves
                that dangle do not count.
    """

    start: Int64Array = field(repr=False)
    end: Int64Array = field(repr=False)
    length: NDArray[np.float64] = field(repr=False)
    first: Int64Array = field(repr=False)
    leaving: Int64Array = field(repr=False)


def list_half_curves(network: CurveNetwork, alive: NDArray[np.bool_]) -> HalfCurves:
    """The curves (m,) bool that are alive, as half-curves."""
    ends = curve_ends(network)
    n = len(network.nodes)
    length = np.array([curve.length for curve in network.curves])
    start, end = ends.ravel(), ends[:, ::-1].ravel()
    living = np.flatnonzero(np.repeat(alive, 2))
    leaving = living[np.argsort(start[living], kind="stable")]
    first = np.r_[0, np.cumsum(np.bincount(start[living], minlength=n))]
    return HalfCurves(start, end, np.repeat(length, 2), first, leaving)


def find_candidate_cycles(
    network: CurveNetwork, halves: HalfCurves, closings: int
) -> tuple[dict[tuple[int, ...], Cycle], int]:
    """The shortest cycles through each pair of curves at a node, ``closings`` of each pair.

    So is the polygon in the plane of the pair, if there is one (:func:`find_flat_polygon`): the lid
    of a prism of twelve sides is longer than the shortest ways around over its sides.

    Returns them by their sorted curves, which no two simple cycles share, and the number of
    pairs for which MAX_PATHS paths did not suffice.

    One closing path per pair, the cheapest, is not enough: of the patches recorded in CASSIE
    sketches whose strokes still close, 0.82 are among the candidates with one closing, the
    shortest, 0.93 with 3, 0.95 with 8 and 0.96 with 20 (means over the sketches, counted as
    benchmarks/cycles.py does).
    """
    found: dict[tuple[int, ...], Cycle] = {}
    paths = np.empty((closings, len(network.nodes) + 1), np.int64)
    sizes = np.empty(closings, np.int64)
    stopped = 0

    def keep(halves: list[int]) -> None:
        steps = tuple((half >> 1, bool(half & 1)) for half in halves)
        found.setdefault(tuple(sorted(half >> 1 for half in halves)), Cycle(steps))

    lines = [curve.points for curve in network.curves]
    steps = [end for line in lines for end in (line[1] - line[0], line[-2] - line[-1])]
    tangents = units(np.array(steps).reshape(-1, 3))
    flat = np.empty(MOST_IN_PLANE, np.int64)
    distance = np.full(len(network.nodes), np.inf)
    near = np.empty(len(network.nodes), np.int64)
    measured, met, farther = -1, 0, math.inf

    for node in range(len(network.nodes)):
        at = halves.leaving[halves.first[node] : halves.first[node + 1]].tolist()
        for back, out in ((b, a) for i, b in enumerate(at) for a in at[:i]):
            if out >> 1 == back >> 1:
                keep([out])
            elif node in (halves.end[out], halves.end[back]):
                continue  # a closed curve is a cycle of its own, and part of no other
            elif halves.end[out] == halves.end[back]:
                keep([out, back ^ 1])
            else:
                if halves.end[back] != measured:
                    distance[near[:met]] = np.inf
                    measured = int(halves.end[back])
                    met, farther = measure_ways(
                        halves.end,
                        halves.length,
                        halves.first,
                        halves.leaving,
                        measured,
                        distance,
                        near,
                    )
                n, cut_short = find_closing_paths(
                    halves.start,
                    halves.end,
                    halves.length,
                    halves.first,
                    halves.leaving,
                    distance,
                    farther,
                    out,
                    back,
                    paths,
                    sizes,
                    MAX_PATHS,
                )
                stopped += cut_short
                for i in range(n):
                    keep(paths[i, : sizes[i]].tolist())
                size = find_flat_polygon(
                    halves.start,
                    halves.end,
                    halves.first,
                    halves.leaving,
                    tangents,
                    out,
                    back,
                    flat,
                )
                if size:
                    keep(flat[:size].tolist())
    return found, stopped
