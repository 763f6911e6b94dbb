"""Parameter correction: samples slide along the curve to where it is nearest to them."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.splines.spline import Spline

#: Of the gap to its neighbour a parameter may move this share: neighbours that move towards
#: each other do not pass.
LEEWAY = 0.49


def corrected(spline: Spline, samples: Points, parameters: Floats) -> Floats:
    """(m,) parameters after one step of Newton's method for the feet of (m, 3) samples.

    The ends keep theirs, and the parameters stay in order.

    Source: Hoschek 1988, "Intrinsic parametrization for approximation". Differs from it: where
    the curve is bent so much that Newton's step leads to the farthest point, the step of Gauss
    and Newton is taken, and steps are cut short where parameters would pass each other.
    """
    off = spline.evaluate(parameters) - samples
    velocity = spline.derivative(parameters, 1)
    slope = np.einsum("mc,mc->m", off, velocity)
    speed = np.einsum("mc,mc->m", velocity, velocity)
    bend = speed + np.einsum("mc,mc->m", off, spline.derivative(parameters, 2))
    # Below half of Gauss and Newton's the second derivative is no guide.
    bend = np.where(bend > 0.5 * speed, bend, speed)
    step = -slope / np.where(bend > 0.0, bend, np.inf)
    gap = LEEWAY * np.diff(parameters)
    step[1:-1] = np.clip(step[1:-1], -gap[:-1], gap[1:])
    step[0] = step[-1] = 0.0
    return parameters + step
