"""Uniform Laplacian: every interior vertex at the mean of its neighbours.

Solved by conjugate gradients over the neighbours as they stand: for the few hundred vertices
of a fill that is some ten times faster than building and factoring a sparse matrix, and
several right sides go side by side.
"""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel
from query.placing.strands import SidedDisk

#: The residual is brought below this part of the right side: rounding, nearly.
PRECISION = 1e-13

#: The same for moves that are made again and again.
FEW_DIGITS = 1e-4

#: Steps per free vertex. In exact arithmetic one each would do; rounding costs a few more.
STEPS_EACH = 4


def lay_flat(fill: SidedDisk, points: Points) -> Points:
    """(v, 3) a fill's vertices over the boundary points (P, 3), for ranking many fills.

    Interior vertices at the means of their neighbours: what :func:`query.placing.place` begins
    with, without its checks, repairs and surface, in well under a millisecond.
    """
    return solve_harmonic(Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter), points)


def solve_harmonic(beside: Neighbours, points: Points) -> Points:
    """(v, d) values that are ``points`` (P, d) on the boundary, and uniform means inside."""
    fixed = np.ascontiguousarray(points, np.float64)
    values = np.empty((beside.n_vertices, fixed.shape[1]))
    values[: len(fixed)] = fixed
    values[len(fixed) :] = fixed.mean(axis=0)
    relax_inside(beside.start, beside.neighbour, len(fixed), values)
    return values


def solve_centred(quads: Int32Array, beside: Neighbours, points: Points) -> Points:
    """As :func:`solve_harmonic`, with a vertex amid every quad that its corners hang on.

    The quads become fans of triangles. Every map of a triangulated disk onto a convex outline
    that takes interior vertices to convex combinations of their neighbours is one to one, but
    for edges that join two vertices of one straight side (Tutte 1963, Floater 2003): no quad
    is flipped, whatever holds the disk together.
    """
    v = beside.n_vertices
    middle = v + np.repeat(np.arange(len(quads)), 4)
    tail = np.concatenate([np.repeat(np.arange(v), np.diff(beside.start)), quads.ravel(), middle])
    head = np.concatenate([beside.neighbour, middle, quads.ravel()])
    order = np.argsort(tail, kind="stable")
    start = np.r_[0, np.cumsum(np.bincount(tail))].astype(np.int32)
    fans = Neighbours(beside.twin, start, head[order].astype(np.int32), beside.border)
    return solve_harmonic(fans, points)[:v]


@kernel
def relax_inside(start: Int32Array, neighbour: Int32Array, fixed: int, values: Points) -> int:
    """Solve for the rows of ``values`` (v, d) from ``fixed`` on, in place; the steps taken.

    What stands in these rows is where the solution starts from.
    """
    v, d = values.shape
    n = v - fixed
    if n == 0:
        return 0
    residual = np.zeros((n, d))
    toward = np.zeros((n, d))
    product = np.zeros((n, d))
    scale = np.zeros(d)
    squared = np.zeros(d)
    for i in range(n):
        g = start[i + fixed + 1] - start[i + fixed]
        for c in range(d):
            total = 0.0
            right = 0.0
            for k in range(start[i + fixed], start[i + fixed + 1]):
                j = neighbour[k]
                total += values[j, c]
                if j < fixed:
                    right += values[j, c]
            r = total - g * values[i + fixed, c]
            residual[i, c] = r
            toward[i, c] = r / g
            squared[c] += r * r / g
            scale[c] += max(right * right, total * total) / g
    steps = 0
    while steps < STEPS_EACH * n + 10:
        busy = False
        for c in range(d):
            busy = busy or squared[c] > PRECISION * PRECISION * scale[c]
        if not busy:
            break
        steps += 1
        for c in range(d):
            curve = 0.0
            for i in range(n):
                s = start[i + fixed]
                e = start[i + fixed + 1]
                total = (e - s) * toward[i, c]
                for k in range(s, e):
                    j = neighbour[k] - fixed
                    if j >= 0:
                        total -= toward[j, c]
                product[i, c] = total
                curve += total * toward[i, c]
            if curve <= 0.0:
                squared[c] = 0.0
                continue
            alpha = squared[c] / curve
            after = 0.0
            for i in range(n):
                g = start[i + fixed + 1] - start[i + fixed]
                values[i + fixed, c] += alpha * toward[i, c]
                residual[i, c] -= alpha * product[i, c]
                after += residual[i, c] * residual[i, c] / g
            beta = after / squared[c]
            squared[c] = after
            for i in range(n):
                g = start[i + fixed + 1] - start[i + fixed]
                toward[i, c] = residual[i, c] / g + beta * toward[i, c]
    return steps


@kernel
def relax_within(
    start: Int32Array, neighbour: Int32Array, fixed: int, points: Points, frames: Points
) -> Points:
    """(v, 3) moves within the vertices' planes that bring the least sum of squared edges.

    points: (v, 3); frames: (v, 2, 3) orthonormal tangents. Vertices before ``fixed`` do not
    move. A few digits suffice: the planes turn from round to round.
    """
    v = len(points)
    n = v - fixed
    move = np.zeros((v, 3))
    if n == 0:
        return move
    at = np.zeros((n, 2))
    residual = np.zeros((n, 2))
    toward = np.zeros((n, 2))
    across = np.zeros((v, 3))
    squared = 0.0
    for i in range(n):
        s = start[i + fixed]
        e = start[i + fixed + 1]
        for f in range(2):
            r = 0.0
            for c in range(3):
                total = -(e - s) * points[i + fixed, c]
                for k in range(s, e):
                    total += points[neighbour[k], c]
                r += total * frames[i + fixed, f, c]
            residual[i, f] = r
            toward[i, f] = r / (e - s)
            squared += r * r / (e - s)
    target = FEW_DIGITS * FEW_DIGITS * squared
    for _ in range(STEPS_EACH * n + 10):
        if squared <= target:
            break
        for i in range(n):
            for c in range(3):
                across[i + fixed, c] = (
                    toward[i, 0] * frames[i + fixed, 0, c] + toward[i, 1] * frames[i + fixed, 1, c]
                )
        curve = 0.0
        product = np.zeros((n, 2))
        for i in range(n):
            s = start[i + fixed]
            e = start[i + fixed + 1]
            for c in range(3):
                total = (e - s) * across[i + fixed, c]
                for k in range(s, e):
                    total -= across[neighbour[k], c]
                product[i, 0] += total * frames[i + fixed, 0, c]
                product[i, 1] += total * frames[i + fixed, 1, c]
            curve += product[i, 0] * toward[i, 0] + product[i, 1] * toward[i, 1]
        if curve <= 0.0:
            break
        alpha = squared / curve
        after = 0.0
        for i in range(n):
            g = start[i + fixed + 1] - start[i + fixed]
            for f in range(2):
                at[i, f] += alpha * toward[i, f]
                residual[i, f] -= alpha * product[i, f]
                after += residual[i, f] * residual[i, f] / g
        beta = after / squared
        squared = after
        for i in range(n):
            g = start[i + fixed + 1] - start[i + fixed]
            for f in range(2):
                toward[i, f] = residual[i, f] / g + beta * toward[i, f]
    for i in range(n):
        for c in range(3):
            move[i + fixed, c] = (
                at[i, 0] * frames[i + fixed, 0, c] + at[i, 1] * frames[i + fixed, 1, c]
            )
    return move


@kernel
def measure_edge_energy(start: Int32Array, neighbour: Int32Array, points: Points) -> float:
    """Sum of the squared lengths of all edges of the vertices (v, 3)."""
    total = 0.0
    for i in range(len(points)):
        for k in range(start[i], start[i + 1]):
            j = neighbour[k]
            if j > i:
                for c in range(3):
                    total += (points[i, c] - points[j, c]) ** 2
    return total
