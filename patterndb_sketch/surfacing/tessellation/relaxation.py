"""Relaxing a planar mesh in space: the linearised Laplacian, with the boundary fixed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.tessellation.delaunay import following, preceding
from patterndb_sketch.surfacing.tessellation.polygon import turn

#: The residual is brought below this part of its scale: rounding, nearly.
PRECISION = 1e-13

#: Steps per inner vertex. In exact arithmetic one each would do; rounding costs a few more.
STEPS_EACH = 4


@kernel
def harmonic_heights(
    at: Int64Array, tail: Int64Array, twin: Int64Array, boundary: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(v,) heights above the plane that solve Laplace's equation on a planar mesh.

    at: (v, 2); tail, twin: half-edges of its constrained Delaunay triangulation; boundary:
    (m,) heights of the first m vertices, which are kept. By conjugate gradients.

    The weights are the cotangents of the angles in the plane. On a constrained Delaunay
    triangulation none is negative, so that every height is a mean of its neighbours' heights:
    none is above the highest or below the lowest of the boundary. With them, a vertex in its
    place in the plane is at rest too; therefore only the heights are solved for, the surface
    is a graph over the plane, and no piece crosses itself. (Uniform weights would pull vertices
    across the boundary at concave corners.)

    Source: Pinkall and Polthier 1993, "Computing discrete minimal surfaces and their
    conjugates": the membrane's energy on the planar mesh, which for small heights is the area.
    """
    m, v = len(boundary), len(at)
    heights = np.empty(v)
    heights[:m] = boundary
    heights[m:] = boundary.mean()
    if v == m:
        return heights
    first, second, weights = _inner_edges(at, tail, twin)
    diagonal = np.zeros(v)
    for e in range(len(weights)):
        diagonal[first[e]] += weights[e]
        diagonal[second[e]] += weights[e]
    residual = np.zeros(v)
    product = np.zeros(v)
    toward = np.zeros(v)
    _apply(first, second, weights, m, heights, product)
    squared = 0.0
    extent = boundary.max() - boundary.min()
    scale = 0.0
    for i in range(m, v):
        residual[i] = -product[i]
        toward[i] = residual[i] / diagonal[i]
        squared += residual[i] * toward[i]
        scale += diagonal[i] * extent * extent
    steps = 0
    while squared > PRECISION * PRECISION * scale and steps < STEPS_EACH * (v - m) + 10:
        steps += 1
        _apply(first, second, weights, m, toward, product)
        curve = 0.0
        for i in range(m, v):
            curve += product[i] * toward[i]
        if curve <= 0.0:
            break
        alpha = squared / curve
        after = 0.0
        for i in range(m, v):
            heights[i] += alpha * toward[i]
            residual[i] -= alpha * product[i]
            after += residual[i] * residual[i] / diagonal[i]
        beta = after / squared
        squared = after
        for i in range(m, v):
            toward[i] = residual[i] / diagonal[i] + beta * toward[i]
    return heights


@kernel
def _inner_edges(
    at: Int64Array, tail: Int64Array, twin: Int64Array
) -> tuple[Int64Array, Int64Array, NDArray[np.float64]]:
    """The ends of every inner edge, and the sum of the cotangents opposite to it."""
    first = np.empty(len(tail) // 2, np.int64)
    second = np.empty(len(tail) // 2, np.int64)
    weights = np.empty(len(tail) // 2)
    count = 0
    for h in range(len(tail)):
        if twin[h] > h:
            first[count] = tail[h]
            second[count] = tail[following(h)]
            # Below 0 by rounding only.
            weights[count] = max(_cotangent(at, tail, h) + _cotangent(at, tail, twin[h]), 0.0)
            count += 1
    return first[:count], second[:count], weights[:count]


@kernel
def _cotangent(at: Int64Array, tail: Int64Array, h: int) -> float:
    """Of the angle opposite half-edge h in its triangle."""
    a, b, c = tail[h], tail[following(h)], tail[preceding(h)]
    along = 0.0
    for d in range(2):
        along += float(at[a, d] - at[c, d]) * float(at[b, d] - at[c, d])
    return along / float(turn(at, a, b, c))


@kernel
def _apply(
    first: Int64Array,
    second: Int64Array,
    weights: NDArray[np.float64],
    m: int,
    values: NDArray[np.float64],
    product: NDArray[np.float64],
) -> None:
    """The Laplacian of the values (v,) in the product's rows from m on."""
    product[:] = 0.0
    for e in range(len(weights)):
        a, b = first[e], second[e]
        flow = weights[e] * (values[a] - values[b])
        product[a] += flow
        product[b] -= flow


@kernel
def stretch(at: Int64Array, tail: Int64Array, heights: NDArray[np.float64], step: float) -> float:
    """How many times as large as in the plane a mesh is at these heights: the root of areas."""
    flat, real = 0.0, 0.0
    for h in range(0, len(tail), 3):
        a, b, c = tail[h], tail[h + 1], tail[h + 2]
        area = float(turn(at, a, b, c)) * step * step
        ux, uy = (at[b, 0] - at[a, 0]) * step, (at[b, 1] - at[a, 1]) * step
        vx, vy = (at[c, 0] - at[a, 0]) * step, (at[c, 1] - at[a, 1]) * step
        uz, vz = heights[b] - heights[a], heights[c] - heights[a]
        x, y = uy * vz - uz * vy, uz * vx - ux * vz
        flat += area
        real += math.sqrt(area * area + x * x + y * y)
    return math.sqrt(real / flat)
