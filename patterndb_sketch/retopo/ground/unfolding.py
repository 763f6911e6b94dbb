"""A strip of triangles laid flat, and the shortest path within it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.surface import Points
from patterndb.system.kernels import kernel

Floats = NDArray[np.float64]


@kernel
def laid_flat(
    vertices: Points,
    triangles: Int32Array,
    out: Int32Array,
    into: Int32Array,
    start: Floats,
    end: Floats,
) -> tuple[Int32Array, Points, Points]:
    """The gates between the triangles of a strip, in one plane.

    out, into (n,): the sides by which one triangle is left and the next entered, n >= 1;
    start, end: (3,) barycentric weights of points in the first and last triangle.

    Returns the vertices at the left and right of the gates (n + 2, 2), their places
    (n + 2, 2, 2), and those of start and end (2, 2). Rows 0 and n + 1 are no gates: both sides
    are the corner of the first and last triangle that is at none.
    """
    n = len(out)
    gate = np.empty((n + 2, 2), np.int32)
    flat = np.empty((n + 2, 2, 2))
    ends = np.zeros((2, 2))
    f, e = out[0] // 3, out[0] % 3
    right, left, third = triangles[f, e], triangles[f, (e + 1) % 3], triangles[f, (e + 2) % 3]
    length = _apart(vertices, right, left)
    x, y = _beyond(vertices, right, left, third)
    gate[1, 0], gate[1, 1] = left, right
    flat[1, 0, 0], flat[1, 0, 1] = length, 0.0
    flat[1, 1, 0], flat[1, 1, 1] = 0.0, 0.0
    # What is ahead lies at negative heights.
    gate[0, 0] = gate[0, 1] = third
    flat[0, :, 0], flat[0, :, 1] = x, y
    ends[0, 0] = start[(e + 1) % 3] * length + start[(e + 2) % 3] * x
    ends[0, 1] = start[(e + 2) % 3] * y
    for i in range(n):
        f, e = into[i] // 3, into[i] % 3
        third = triangles[f, (e + 2) % 3]
        left, right = gate[i + 1, 0], gate[i + 1, 1]
        x, y = _beyond(vertices, right, left, third)
        px, py = flat[i + 1, 1, 0], flat[i + 1, 1, 1]
        ux, uy = flat[i + 1, 0, 0] - px, flat[i + 1, 0, 1] - py
        size = math.sqrt(ux * ux + uy * uy)
        ux, uy = ux / size, uy / size
        sx, sy = px + x * ux + y * uy, py + x * uy - y * ux
        if i + 1 == n:
            gate[n + 1, 0] = gate[n + 1, 1] = third
            flat[n + 1, :, 0], flat[n + 1, :, 1] = sx, sy
            for c in range(3):
                v = triangles[f, c]
                if v == third:
                    tx, ty = sx, sy
                elif v == left:
                    tx, ty = flat[n, 0, 0], flat[n, 0, 1]
                else:
                    tx, ty = flat[n, 1, 0], flat[n, 1, 1]
                ends[1, 0] += end[c] * tx
                ends[1, 1] += end[c] * ty
            break
        e = out[i + 1] % 3
        keeps_left = triangles[f, e] == left or triangles[f, (e + 1) % 3] == left
        changed = 1 if keeps_left else 0
        gate[i + 2] = gate[i + 1]
        flat[i + 2] = flat[i + 1]
        gate[i + 2, changed] = third
        flat[i + 2, changed, 0], flat[i + 2, changed, 1] = sx, sy
    return gate, flat, ends


@kernel
def _apart(vertices: Points, a: Index, b: Index) -> float:
    total = 0.0
    for c in range(3):
        total += (vertices[b, c] - vertices[a, c]) ** 2
    return math.sqrt(total)


@kernel
def _beyond(vertices: Points, a: Index, b: Index, c: Index) -> tuple[float, float]:
    """How far c lies along the edge from a to b, and how far beside it."""
    length = _apart(vertices, a, b)
    ux, uy, uz = (
        (vertices[b, 0] - vertices[a, 0]) / length,
        (vertices[b, 1] - vertices[a, 1]) / length,
        (vertices[b, 2] - vertices[a, 2]) / length,
    )
    x = vertices[c, 0] - vertices[a, 0]
    y = vertices[c, 1] - vertices[a, 1]
    z = vertices[c, 2] - vertices[a, 2]
    along = x * ux + y * uy + z * uz
    x, y, z = x - along * ux, y - along * uy, z - along * uz
    return along, math.sqrt(x * x + y * y + z * z)


@kernel
def _turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the area of a, b, c: above 0 if c is left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@kernel
def pulled_tight(
    gate: Int32Array, flat: Points, ends: Points
) -> tuple[Int32Array, Int32Array, float]:
    """Where the shortest path through the gates of :func:`laid_flat` turns: (m,) numbers of
    gates, counted from 0, and (m,) their sides, 0 left and 1 right; and the path's length.

    Source: Lee and Preparata 1984; the funnel is opened anew behind every turn.
    """
    n = len(gate) - 2
    numbers = np.empty(n, np.int32)
    which = np.empty(n, np.int32)
    m = 0
    length = 0.0
    apex = ends[0].copy()
    first = 0
    while first < n:
        bounds = flat[first + 1].copy()
        at = np.array([first, first])
        turned = -1
        for j in range(first + 1, n + 1):
            for s in range(2):
                sign = 1.0 if s == 0 else -1.0
                target = flat[j + 1, s] if j < n else ends[1]
                if sign * _turn(apex, bounds[s], target) > 0.0:
                    continue
                if sign * _turn(apex, bounds[1 - s], target) < 0.0:
                    turned = 1 - s
                    break
                bounds[s] = target
                at[s] = j
            if turned >= 0:
                break
        if turned < 0:
            break
        length += math.hypot(bounds[turned, 0] - apex[0], bounds[turned, 1] - apex[1])
        apex[:] = bounds[turned]
        numbers[m] = at[turned]
        which[m] = turned
        # The gates that end in the turn are over with it.
        first = at[turned] + 1
        while first < n and gate[first + 1, turned] == gate[at[turned] + 1, turned]:
            first += 1
        m += 1
    length += math.hypot(ends[1, 0] - apex[0], ends[1, 1] - apex[1])
    return numbers[:m].copy(), which[:m].copy(), length
