"""Shortest paths over the ground."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.ground.feet import Feet
from patterndb_sketch.retopo.ground.ground import Ground
from patterndb_sketch.retopo.ground.route import route
from patterndb_sketch.retopo.ground.shortening import crossed, shortened
from patterndb_sketch.retopo.ground.trace import Trace
from patterndb_sketch.retopo.ground.unfolding import laid_flat, pulled_tight


def geodesic(ground: Ground, start: Feet, end: Feet) -> Trace:
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
    out, into = route(vertices, topology, first[0], start.points[0], last[0], end.points[0])
    if len(out) == 0:
        raise RefusedError(
            "there is no path between the two points: they are on parts of the surface that "
            "do not hang together; join the parts, or choose points on one"
        )
    only, out, into, from_weights, to_weights = shortened(
        vertices, triangles, topology.across, out, into, start.weights[0], end.weights[0]
    )
    if len(out) == 0:
        return Trace(both, np.array([only], np.int32), False)
    gate, flat, ends = laid_flat(vertices, triangles, out, into, from_weights, to_weights)
    numbers, which, _ = pulled_tight(gate, flat, ends)
    points = crossed(vertices, gate, flat, ends, numbers, which)
    points = np.concatenate([both[:1], points, both[1:]])
    held = np.concatenate([out // 3, into[-1:] // 3]).astype(np.int32)
    moves = (points[1:] != points[:-1]).any(axis=1)
    return Trace(points[np.r_[True, moves]], held[moves], False)
