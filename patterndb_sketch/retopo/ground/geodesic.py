"""Shortest paths over the ground."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.ground.curves import Trace
from patterndb_sketch.retopo.ground.ground import Ground, GroundPoints
from patterndb_sketch.retopo.ground.heap import grown, pop, push
from patterndb_sketch.retopo.ground.shortening import (
    cross_gates,
    pull_tight,
    shorten_strip,
    unfold_strip,
)
from patterndb_sketch.retopo.ground.topology import GroundTopology


def trace_geodesic(ground: Ground, start: GroundPoints, end: GroundPoints) -> Trace:
    """The locally shortest path over the ground from one point (one foot) to another.

    It is straight within triangles and, laid flat, across edges; at a vertex that it passes
    neither side is narrower than a straight angle, to 1e-8 radians. No path near it is
    shorter; one that goes round the other side of a hill may be. Edges of more than two
    triangles may be crossed from any to any, but paths do not slide round vertices over them.
    Raises InvalidRetopoError unless each is one foot; RefusedError if both are at one place,
    or on parts of the ground that do not hang together.

    Source: Xin and Wang 2007, "Efficiently Determining a Locally Exact Shortest Path on
    Polyhedral Surfaces". Differs from the paper: the first way is found over the middles of
    edges, and all turns are looked at in every round.
    """
    for name, foot in (("start", start), ("end", end)):
        if len(foot) != 1 or foot.triangles[0] < 0:
            raise InvalidRetopoError(
                f"a path's {name} is one point of the surface, not {len(foot)}"
            )
    if (start.points == end.points).all():
        raise RefusedError("a path needs two points at different places")
    vertices, triangles, topology = ground.vertices, ground.triangles, ground.topology
    first, last = start.triangles[:1], end.triangles[:1]
    both = np.concatenate([start.points, end.points])
    if first[0] == last[0]:
        return Trace(both, first.copy(), False)
    out, into = find_route(vertices, topology, first[0], start.points[0], last[0], end.points[0])
    if len(out) == 0:
        raise RefusedError(
            "there is no path between the two points: they are on parts of the surface that "
            "do not hang together; join the parts, or choose points on one"
        )
    only, out, into, from_weights, to_weights = shorten_strip(
        vertices, triangles, topology.across, out, into, start.weights[0], end.weights[0]
    )
    if len(out) == 0:
        return Trace(both, np.array([only], np.int32), False)
    gate, flat, ends = unfold_strip(vertices, triangles, out, into, from_weights, to_weights)
    numbers, which, _ = pull_tight(gate, flat, ends)
    points = cross_gates(vertices, gate, flat, ends, numbers, which)
    points = np.concatenate([both[:1], points, both[1:]])
    held = np.concatenate([out // 3, into[-1:] // 3]).astype(np.int32)
    moves = (points[1:] != points[:-1]).any(axis=1)
    return Trace(points[np.r_[True, moves]], held[moves], False)


def find_route(
    vertices: Points,
    topology: GroundTopology,
    first: Index,
    start: Floats,
    last: Index,
    end: Floats,
) -> tuple[Int32Array, Int32Array]:
    """The sides by which a way leaves one triangle (n,) and enters the next (n,).

    From ``start`` (3,) in triangle ``first`` to ``end`` (3,) in another, ``last``: the shortest
    by straight steps through one triangle, or two laid flat, between the middles of edges. Edges
    of more than two triangles lead to all of them. Empty if there is no way.
    """
    before, leaves, via = _search_route(
        vertices,
        topology.middles,
        topology.ends,
        topology.edges,
        topology.side_start,
        topology.sides,
        first,
        start,
        last,
        end,
    )
    sides: list[int] = []
    k = len(topology.middles)
    if before[k] < 0:
        return np.empty(0, np.int32), np.empty(0, np.int32)
    while k >= 0:
        sides.append(int(leaves[k]))
        if via[k] >= 0:
            sides.append(int(via[k]))
        k = int(before[k])
    sides.reverse()
    # The goal itself is no side that is left: what stands there is one of the last triangle.
    out = np.array(sides[:-1], np.int32)
    held = np.array(sides[1:], np.int32) // 3
    of = topology.edges.reshape(-1, 3)[held] == topology.edges[out][:, None]
    return out, (3 * held + of.argmax(axis=1)).astype(np.int32)


@kernel
def _apart(points: Points, i: Index, point: Floats) -> float:
    x, y, z = points[i, 0] - point[0], points[i, 1] - point[1], points[i, 2] - point[2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def _across(vertices: Points, a: Index, b: Index, one: Floats, two: Floats) -> float:
    """How far apart two points are in triangles on both sides of the edge from a to b, laid
    flat."""
    length, first, second, p, q = 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(3):
        u = vertices[b, c] - vertices[a, c]
        x, y = one[c] - vertices[a, c], two[c] - vertices[a, c]
        length += u * u
        first += u * x
        second += u * y
        p += x * x
        q += y * y
    high = math.sqrt(max(p - first * first / length, 0.0))
    high += math.sqrt(max(q - second * second / length, 0.0))
    return math.sqrt((second - first) ** 2 / length + high * high)


@kernel
def _search_route(
    vertices: Points,
    middles: Points,
    ends: Int32Array,
    edges: Int32Array,
    side_start: Int32Array,
    sides: Int32Array,
    first: Index,
    start: Floats,
    last: Index,
    end: Floats,
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """A* of :func:`find_route`: for every edge, and the goal behind them, the edge before it, the
    side that the way leaves its triangle by, and that of the triangle before or -1, if the step
    leads through two. -1 before an edge that is first, or was not reached."""
    goal = len(middles)
    far = np.full(goal + 1, np.inf)
    done = np.zeros(goal + 1, np.bool_)
    before = np.full(goal + 1, -1, np.int32)
    leaves = np.full(goal + 1, -1, np.int32)
    via = np.full(goal + 1, -1, np.int32)
    keys = np.empty(1024)
    items = np.empty(1024, np.int32)
    n = 0
    for e in range(3):
        k = edges[3 * first + e]
        far[k] = _apart(middles, k, start)
        leaves[k] = 3 * first + e
        n = push(keys, items, n, far[k] + _apart(middles, k, end), k)
    while n:
        k = items[0]
        n = pop(keys, items, n)
        if done[k]:
            continue
        done[k] = True
        if k == goal:
            break
        here = middles[k]
        for s in range(side_start[k], side_start[k + 1]):
            g = sides[s] // 3
            if g == leaves[k] // 3:
                continue
            if g == last:
                reached = far[k] + _apart(middles, k, end)
                if reached < far[goal]:
                    far[goal], before[goal], leaves[goal], via[goal] = reached, k, sides[s], -1
                    if n == len(keys):
                        keys, items = grown(keys, items)
                    n = push(keys, items, n, reached, goal)
                continue
            for e in range(3):
                out = 3 * g + e
                m = edges[out]
                if m == k:
                    continue
                if not done[m]:
                    reached = far[k] + _apart(middles, m, here)
                    if reached < far[m]:
                        far[m], before[m], leaves[m], via[m] = reached, k, out, -1
                        if n == len(keys):
                            keys, items = grown(keys, items)
                        n = push(keys, items, n, reached + _apart(middles, m, end), m)
                for t in range(side_start[m], side_start[m + 1]):
                    h = sides[t] // 3
                    if h == g:
                        continue
                    if h == last:
                        continue
                    for d in range(3):
                        o = edges[3 * h + d]
                        if o == m or done[o]:
                            continue
                        reached = far[k] + _across(
                            vertices, ends[m, 0], ends[m, 1], here, middles[o]
                        )
                        if reached < far[o]:
                            far[o], before[o], leaves[o], via[o] = reached, k, 3 * h + d, out
                            if n == len(keys):
                                keys, items = grown(keys, items)
                            n = push(keys, items, n, reached + _apart(middles, o, end), o)
    return before, leaves, via
