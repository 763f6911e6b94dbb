"""Knots that follow the parameters of samples, and whether samples determine a spline."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel
from patterndb_sketch.features.splines.parameters import distinct


def averaged_knots(
    parameters: Floats, degree: int, n_control: int, held: Floats | None = None
) -> Floats:
    """(n + degree + 1,) knots on [0, 1], as dense as the parameters (m,).

    n is n_control, or somewhat more if some parameters are held (q,): the spline can then
    interpolate whatever values there, however close together they are. Wanted: degree <
    n_control <= how many distinct parameters there are; held: some of the parameters.

    Every inner knot is the mean of ``degree`` successive ones of n sites, which lie at steps of
    number among the distinct parameters, equal ones unless some are held: these are sites.

    The samples determine every control point (Schoenberg and Whitney): the numbers x_i of sites
    ascend by 1 or more, so sites i - 1 and i + 1 enclose parameter floor(x_i), and knots i and
    i + degree + 1 enclose the sites. A held parameter is site i itself.

    Source: Piegl and Tiller 1995, "The NURBS Book", equation 9.8 for as many control points as
    samples. Differs from the paper's reference for fewer (equation 9.69, a knot at every d-th
    parameter): averaged sites are one rule for all numbers, and the condition holds for any
    spacing of the samples.
    """
    places = distinct(parameters)
    last = len(places) - 1
    if held is None:
        at = np.linspace(0.0, last, n_control)
    else:
        step = last / (n_control - 1)
        numbers = np.searchsorted(places, held, "right") - 1
        fixed = np.unique(np.r_[0, numbers, last])
        gaps = [
            np.linspace(a, b, min(math.ceil((b - a) / step), b - a), endpoint=False)
            for a, b in pairwise(fixed.tolist())
        ]
        at = np.concatenate([*gaps, [last]])
    sites = np.interp(at, np.arange(last + 1), places)
    sums = np.convolve(sites[1:-1], np.ones(degree), "valid") if len(at) > degree + 1 else []
    inner = np.asarray(sums, np.float64) / degree
    return np.r_[np.zeros(degree + 1), inner, np.ones(degree + 1)]


@kernel
def n_determined(parameters: Floats, knots: Floats, degree: int) -> int:
    """How many of the ascending parameters (m,) can have control points of their own.

    Parameter t can have control point i if basis function i is positive at t; greedily, each
    has the first that is free, which gives the most. As many as control points: the samples
    determine the spline. As many as parameters: values there can be interpolated.
    """
    n = len(knots) - degree - 1
    free = 0
    count = 0
    for k in range(len(parameters)):
        if k and parameters[k] == parameters[k - 1]:
            continue
        t = parameters[k]
        first = t == knots[0]
        last = t == knots[-1]
        while free < n and (knots[free + degree + 1] <= t and not last):
            free += 1
        if last:
            # Only the last function is positive at the end.
            if free < n:
                free = n
                count += 1
            continue
        if free < n and (knots[free] < t or (first and free == 0)):
            free += 1
            count += 1
    return count
