"""Moves the vertices of a flat disk until every quad is well shaped and none is flipped.

Every corner of every quad is a triangle with a wanted angle and size. Its energy blows up
as its area falls to zero; while some triangle is still flipped the blow-up is smoothed, and
sharpened step by step as the drawing untangles, so that no valid start is needed.

Source: Garanzha et al. 2021, "Foldover-free maps in 50 lines of code", for the energy and
its smoothing. Differs from the paper: L-BFGS runs in one kernel, and the outline may move
by its handles (see :mod:`patterndb.geometry.embedding`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.buffers import copy_items
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel

Complex = NDArray[np.complex128]

#: Part of a triangle's energy that is about size, the rest is about shape.
SIZE_WEIGHT = 0.2

#: Steps that L-BFGS remembers.
MEMORY = 10


@kernel
def measure_energy(
    y: Complex,
    handles: int,
    moving: bool,
    ends: Int32Array,
    weights: Floats,
    quads: Int32Array,
    angle: Floats,
    size: float,
    epsilon: float,
    points: Complex,
    force: Complex,
    gradient: Complex,
) -> tuple[float, float]:
    """Measure the energy of the drawing; also its smallest relative triangle area.

    y: (handles + interior,) complex128 handles, then interior vertices; points and force:
    (v,) complex128 output and scratch; gradient: as y, output. quads: (q, 4) int32; angle:
    (q, 4) wanted angles, 0 for a triangle that is left alone; size: wanted edge length.
    """
    p = len(ends)
    for j in range(p):
        points[j] = 0.0
        for e in range(3):
            points[j] += weights[j, e] * y[ends[j, e]]
    for j in range(p, len(points)):
        points[j] = y[handles + j - p]
    force[:] = 0.0
    total = 0.0
    smallest = np.inf
    for f in range(len(quads)):
        for c in range(4):
            if angle[f, c] <= 0.0:
                continue
            i = quads[f, c]
            j = quads[f, (c + 1) & 3]
            k = quads[f, (c + 3) & 3]
            # The map from the wanted triangle to this one takes (1, 0) to u, (0, 1) to w.
            sine = np.sin(angle[f, c])
            cotangent = np.cos(angle[f, c]) / sine
            u = (points[j] - points[i]) / size
            v = (points[k] - points[i]) / size
            w = v / sine - u * cotangent
            norm = 0.5 * (u.real**2 + u.imag**2 + w.real**2 + w.imag**2)
            area = u.real * w.imag - u.imag * w.real
            smallest = min(smallest, area)
            root = np.sqrt(area * area + epsilon * epsilon)
            smooth = 0.5 * (area + root)
            if area < 0.0:
                smooth = 0.5 * epsilon * epsilon / (root - area)
            slope = smooth / root
            shape = norm / smooth
            bulk = (area * area + 1.0) / (2.0 * smooth)
            total += (1.0 - SIZE_WEIGHT) * shape + SIZE_WEIGHT * bulk
            d_area = -(1.0 - SIZE_WEIGHT) * shape * slope / smooth
            d_area += SIZE_WEIGHT * (area - bulk * slope) / smooth
            d_norm = (1.0 - SIZE_WEIGHT) / smooth
            d_u = d_norm * u - 1j * w * d_area
            d_w = d_norm * w + 1j * u * d_area
            d_u = (d_u - d_w * cotangent) / size
            d_v = d_w / (sine * size)
            force[j] += d_u
            force[k] += d_v
            force[i] -= d_u + d_v
    gradient[:] = 0.0
    if moving:
        for j in range(p):
            for e in range(3):
                gradient[ends[j, e]] += weights[j, e] * force[j]
    for j in range(p, len(points)):
        gradient[handles + j - p] = force[j]
    return total, smallest


@kernel
def multiply_dot(a: Complex, b: Complex) -> float:
    """Multiply two vectors of points: their real inner product."""
    total = 0.0
    for i in range(len(a)):
        total += a[i].real * b[i].real + a[i].imag * b[i].imag
    return total


@kernel
def relax_points(
    y: Complex,
    handles: int,
    moving: bool,
    ends: Int32Array,
    weights: Floats,
    quads: Int32Array,
    angle: Floats,
    size: float,
    rounds: int,
    steps: int,
    points: Complex,
) -> float:
    """Minimise :func:`measure_energy` over y, in place; return the smallest triangle area.

    Each of at most ``rounds`` rounds takes at most ``steps`` L-BFGS steps with one
    smoothing; once a round begins with no triangle flipped it is the last. points: (v,)
    complex128 output.
    """
    n = len(y)
    force = np.empty(len(points), np.complex128)
    gradient = np.empty(n, np.complex128)
    trial_gradient = np.empty(n, np.complex128)
    trial = np.empty(n, np.complex128)
    move = np.empty((MEMORY, n), np.complex128)
    change = np.empty((MEMORY, n), np.complex128)
    curvature = np.empty(MEMORY)
    alpha = np.empty(MEMORY)
    args = (handles, moving, ends, weights, quads, angle, size)
    _, smallest = measure_energy(y, *args, 1.0, points, force, gradient)
    for _ in range(rounds):
        sound = smallest > 0.0
        epsilon = 1e-4 if sound else np.sqrt(1e-8 + 0.04 * smallest * smallest)
        value, smallest = measure_energy(y, *args, epsilon, points, force, gradient)
        kept = 0
        for _ in range(steps):
            direction = -gradient
            for m in range(kept - 1, max(kept - MEMORY, 0) - 1, -1):
                s = m % MEMORY
                alpha[s] = multiply_dot(move[s], direction) / curvature[s]
                direction -= alpha[s] * change[s]
            if kept:
                s = (kept - 1) % MEMORY
                direction *= curvature[s] / multiply_dot(change[s], change[s])
            else:
                steepest = 0.0
                for h in range(n):
                    steepest = max(steepest, abs(gradient[h]))
                direction *= 0.1 * size / (1e-30 + steepest)
            for m in range(max(kept - MEMORY, 0), kept):
                s = m % MEMORY
                direction += (alpha[s] - multiply_dot(change[s], direction) / curvature[s]) * move[
                    s
                ]
            descent = multiply_dot(gradient, direction)
            if descent >= 0.0:
                if kept == 0:
                    break
                kept = 0
                continue
            step = 1.0
            found, area = value, smallest
            accepted = False
            for _ in range(30):
                for h in range(n):
                    trial[h] = y[h] + step * direction[h]
                found, area = measure_energy(trial, *args, epsilon, points, force, trial_gradient)
                # Once sound, always sound: a step that flips a triangle is cut back.
                if found <= value + 1e-4 * step * descent and (area > 0.0 or not sound):
                    accepted = True
                    break
                step *= 0.5
            if not accepted:
                break
            s = kept % MEMORY
            move[s] = trial - y
            change[s] = trial_gradient - gradient
            curvature[s] = multiply_dot(move[s], change[s])
            if curvature[s] > 1e-14 * multiply_dot(change[s], change[s]) * size * size:
                kept += 1
            copy_items(trial, n, y, 0)
            copy_items(trial_gradient, n, gradient, 0)
            settled = value - found <= 1e-6 * found
            value, smallest = found, area
            if settled:
                break
        if sound:
            break
    _, smallest = measure_energy(y, *args, 1e-4, points, force, gradient)
    return smallest
