"""Bending: how many edges a curve needs at least to keep its shape.

An edge of length e cuts a sagitta of e^2 kappa / 8 off a curve of curvature kappa. Counts are
chosen near length / target edge, but strips tie opposite sides of patches together, and a round
end may get half of that, which flattens it.
"""

from __future__ import annotations

import math

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.network import Chain

#: An edge may cut so much off a curve, in target edges. A ring of four edges of the target length
#: around a limb cuts off 0.21, one of six 0.13.
SAGITTA = 0.125

#: No edge is longer than so many target edges: then the surface between curves leaves the quads,
#: however straight the curves are. Below 1.5 irregular vertices multiply.
STRETCH = 1.6

#: Steps in which curvature is measured, to a target edge: finer ones measure the ground's
#: triangles.
STEPS = 4

#: Steps of a short curve, at least.
FEWEST_STEPS = 8


def fewest_edges(chain: Chain, edge: float) -> int:
    """The fewest edges, 1 or more, with which a chain keeps its shape.

    edge: target length. Where curvature is even, every edge then cuts off SAGITTA at most; where it
    is not, edges are as dense as each part asks for, on the average: e = sqrt(8 SAGITTA edge /
    kappa). A sharp corner asks for none, as no number of edges cuts little off it.
    """
    in_edges = chain.length / edge
    steps = max(FEWEST_STEPS, math.ceil(STEPS * in_edges))
    bends = edges_for_bends(np.ascontiguousarray(chain.round), chain.loose, steps, edge)
    # A full circle's edges are a whole number but for rounding.
    return max(1, math.ceil(max(bends, in_edges / STRETCH) - 1e-9))


@kernel
def edges_for_bends(line: Points, closed: bool, steps: int, edge: float) -> float:
    """The integral of sqrt(curvature / (8 SAGITTA edge)) along a polyline (n, 3), in equal steps.

    closed: does the line, whose last point is its first, turn there, too?
    """
    length = 0.0
    for i in range(1, len(line)):
        length += math.sqrt(_squared(line[i - 1], line[i]))
    if length == 0.0:
        return 0.0
    points = np.empty((steps + 1, 3))
    points[0] = line[0]
    points[steps] = line[-1]
    before, at = 0.0, 0
    for k in range(1, steps):
        wanted = length * k / steps
        while True:
            here = math.sqrt(_squared(line[at], line[at + 1]))
            if before + here >= wanted or at + 2 == len(line):
                break
            before += here
            at += 1
        t = (wanted - before) / here if here > 0.0 else 0.0
        for c in range(3):
            points[k, c] = (1.0 - t) * line[at, c] + t * line[at + 1, c]
    share = length / steps / (8.0 * SAGITTA * edge)
    total = 0.0
    for k in range(0 if closed else 1, steps):
        back = steps - 1 if k == 0 else k - 1
        along = 0.0
        for c in range(3):
            along += (points[back + 1, c] - points[back, c]) * (points[k + 1, c] - points[k, c])
        size = math.sqrt(
            _squared(points[back], points[back + 1]) * _squared(points[k], points[k + 1])
        )
        if size > 0.0:
            total += math.sqrt(math.acos(min(max(along / size, -1.0), 1.0)) * share)
    # The turns of an open line lie at one place fewer than it has steps.
    return total if closed else total * steps / (steps - 1)


@kernel(inline="always")
def _squared(a: Points, b: Points) -> float:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2
