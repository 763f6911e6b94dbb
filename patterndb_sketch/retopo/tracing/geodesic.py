"""Shortest paths over the surface."""

from __future__ import annotations

import numpy as np

from patterndb._native.retopo.tracing.geodesic import search_route
from patterndb._native.retopo.tracing.shortening import (
    cross_gates,
    pull_tight,
    shorten_strip,
    unfold_strip,
)
from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.adjacency import Adjacency
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.tracing.curves import Trace


def trace_geodesic(surface: Surface, start: SurfacePoints, end: SurfacePoints) -> Trace:
    """The locally shortest path over the surface from one point (one foot) to another.

    It is straight within triangles and, laid flat, across edges; at a vertex that it passes
    neither side is narrower than a straight angle, to 1e-8 radians. No path near it is
    shorter; one that goes round the other side of a hill may be. Edges of more than two
    triangles may be crossed from any to any, but paths do not slide round vertices over them.
    Raises InvalidRetopoError unless each is one foot; RefusedError if both are at one place,
    or on parts of the surface that do not hang together.

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
    vertices, triangles, topology = surface.vertices, surface.triangles, surface.adjacency
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
    topology: Adjacency,
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
    before, leaves, via = search_route(
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
