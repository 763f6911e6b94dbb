"""Candidate cycles: for each pair of curves at a node, the shortest paths that close them, and the
path that goes on in their plane."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import sample_polyline
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.network import CurveNetwork, Cycle

#: From the end of a path to be found, the lengths of the ways to this many nodes, the nearest, are
#: known exactly; others are at least as far as the last of these. All pairs of nodes would take
#: memory with the square of their number, and patches are local.
NEAR_NODES = 512

#: Paths that are begun, at most, to close one pair of curves. In all 28 CASSIE sketches with
#: patches together, 132 pairs would need more for 8 closings; that is reported.
MAX_PATHS = 3_000

#: A curve that leaves a node less than this off the plane of a pair, as a sine, goes on in it:
#: strokes drawn freehand in a plane do.
OFF_PLANE = 0.15

#: Two curves whose directions have a lesser sine lie in no plane of their own.
NO_PLANE = 0.2

#: A path in a plane turns at a corner by more than this, in radians: the 20 degrees of a drawn one.
PLANE_TURN = math.radians(20)

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
    parent = np.arange(len(network.nodes))

    def root(node: int) -> int:
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = int(parent[node])
        return node

    ends = curve_ends(network)
    for a, b in ends[alive].tolist():
        parent[root(b)] = root(a)
    groups: dict[int, list[int]] = {}
    for curve in np.flatnonzero(alive).tolist():
        groups.setdefault(root(int(ends[curve, 0])), []).append(curve)
    return [np.array(group, np.int64) for group in groups.values()]


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


@kernel
def measure_ways(
    end: Int64Array,
    length: NDArray[np.float64],
    first: Int64Array,
    leaving: Int64Array,
    target: int,
    distance: NDArray[np.float64],
    near: Int64Array,
) -> tuple[int, float]:
    """Write the lengths of the shortest ways to a node from the nodes near it, by Dijkstra.

    distance: (n,), inf on entry; written for the nodes that are met, which are listed in near (n,).
    Returns how many were met, and ``farther``: what is longer is not known to be the shortest,
    and no way that is not known is shorter; inf where all that can be reached are known.
    """
    distance[target] = 0.0
    near[0] = target
    met, settled = 1, 0
    waiting = [(0.0, target)]
    while len(waiting) > 0:
        so_far, at = heapq.heappop(waiting)
        if so_far > distance[at]:
            continue
        settled += 1
        if settled > NEAR_NODES:
            return met, so_far
        for k in range(first[at], first[at + 1]):
            half = leaving[k]
            to = int(end[half])
            longer = so_far + float(length[half])
            if longer < distance[to]:
                if distance[to] == np.inf:
                    near[met] = to
                    met += 1
                distance[to] = longer
                heapq.heappush(waiting, (longer, to))
    return met, np.inf


@kernel
def find_closing_paths(
    start: Int64Array,
    end: Int64Array,
    length: NDArray[np.float64],
    first: Int64Array,
    leaving: Int64Array,
    distance: NDArray[np.float64],
    farther: float,
    out: int,
    back: int,
    paths: Int64Array,
    sizes: Int64Array,
    most: int,
) -> tuple[int, bool]:
    """The shortest simple cycles that leave a node by ``out`` and come back along ``back``.

    Both half-curves leave the node, are of two curves and end at two other nodes. Half-curves
    of cycle i in order are written to paths[i, : sizes[i]], shortest first, as many as ``paths``
    has rows. distance, farther: as :func:`measure_ways` has them for the end of ``back``. Returns
    how many there are, and whether ``most`` paths were tried before.

    The remaining distance bounds a path's length from below (A*), so paths come out by length.
    """
    node, target = start[back], end[back]
    before = np.empty(most, np.int64)
    by = np.empty(most, np.int64)
    before[0], by[0] = -1, out
    made, found = 1, 0
    waiting = [(length[out] + min(distance[end[out]], farther), 0, length[out])]
    while len(waiting) > 0 and found < len(paths):
        _, path, so_far = heapq.heappop(waiting)
        at = end[by[path]]
        if at == target:
            steps = 0
            t = path
            while t >= 0:
                steps += 1
                t = before[t]
            paths[found, steps] = back ^ 1
            sizes[found] = steps + 1
            t = path
            while t >= 0:
                steps -= 1
                paths[found, steps] = by[t]
                t = before[t]
            found += 1
            continue
        for k in range(first[at], first[at + 1]):
            half = leaving[k]
            to = end[half]
            passed = to in (node, at) or half >> 1 == back >> 1
            t = path
            while t >= 0 and not passed:
                passed = end[by[t]] == to
                t = before[t]
            if passed:
                continue
            if made == most:
                return found, True
            before[made], by[made] = path, half
            longer = so_far + length[half]
            heapq.heappush(waiting, (longer + min(distance[to], farther), made, longer))
            made += 1
    return found, False


@kernel
def find_flat_polygon(
    start: Int64Array,
    end: Int64Array,
    first: Int64Array,
    leaving: Int64Array,
    tangents: Points,
    out: int,
    back: int,
    path: Int64Array,
) -> int:
    """The polygon in the plane of two half-curves that leave a node, of which ``back`` closes it.

    tangents: (2m, 3) unit vectors along which half-curves leave their nodes. At every node the
    path takes, of those that leave nearly in the plane, the one that turns most to the polygon's
    inside. Half-curves in order are written to path; returns how many there are, 0 if it does not
    close, passes a node twice, is longer than ``path`` or has corners at less than half of its
    nodes: where curves mostly go straight on past others that end there, it is as likely the rim
    of an opening as a lid, such as the ground of a car.
    """
    normal = np.cross(tangents[out], tangents[back])
    size = math.sqrt(normal @ normal)
    if size < NO_PLANE:
        return 0
    normal /= size
    node = start[back]
    path[0] = out
    n, corners = 1, 1
    while end[path[n - 1]] != node:
        half = path[n - 1]
        at = end[half]
        if n == len(path):
            return 0
        for k in range(n - 1):
            if end[path[k]] == at:
                return 0
        arriving = -tangents[half ^ 1]
        best, most = -1, -np.inf
        for k in range(first[at], first[at + 1]):
            other = leaving[k]
            if other >> 1 == half >> 1 or end[other] == at:
                continue
            if abs(tangents[other] @ normal) > OFF_PLANE:
                continue
            sine = np.cross(arriving, tangents[other]) @ normal
            turn = math.atan2(sine, arriving @ tangents[other])
            if turn > most:
                best, most = other, turn
        if best < 0:
            return 0
        corners += abs(most) > PLANE_TURN
        path[n] = best
        n += 1
    return n if path[n - 1] == back ^ 1 and 2 * corners >= n else 0


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
