"""A B-spline curve in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from patterndb.geometry.points import Floats, Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError

#: The highest degree: beyond it a curve wiggles, and its basis loses digits.
MAX_DEGREE = 9

#: Parts of a knot span, and points of Gauss' rule on each, for arc length: on random control
#: points exact to seven digits as a rule, to four where the curve nearly stands still.
PARTS = 8
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(6)

#: Steps of Newton's method from an arc length to its parameter; the table's guess is off by
#: little, and each step doubles the digits.
NEWTON_STEPS = 4

#: A closed curve of fewer control points would be a segment there and back.
LEAST_CLOSED = 3


@dataclass(frozen=True, slots=True, eq=False)
class Spline:
    """c(t) = sum of control points times B-spline basis functions, t from knots[0] to knots[-1].

    degree:  at least 1.
    knots:   (n + degree + 1,) float64, ascending, the first and the last degree + 1 times: the
             curve begins and ends at its first and last control point.
    control: (n, 3) float64 control points.
    closed:  the curve is periodic: knots are the (n + 1,) of one period, of which the last is the
             first again, and control points come round, each once. It has no joint: where the
             period begins it is as smooth as at any other knot, degree - 1 times differentiable
             where knots are simple.

    Raises InvalidFeatureError for what is no such curve.

    Source for closed curves: Piegl and Tiller 1995, "The NURBS Book", section 12.2, unclamped.
    """

    degree: int
    knots: Floats
    control: Points
    closed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", np.array(self.knots, np.float64))
        object.__setattr__(
            self, "control", as_points(self.control, "control points", InvalidFeatureError)
        )
        n, p = len(self.control), self.degree
        if not 1 <= p <= MAX_DEGREE:
            raise InvalidFeatureError(f"a spline's degree is {p}; give one of 1 to {MAX_DEGREE}")
        if self.closed:
            self._check_period()
            return
        if n <= p:
            raise InvalidFeatureError(
                f"a spline of degree {p} has {n} control points; it needs at least {p + 1}"
            )
        if self.knots.shape != (n + p + 1,):
            raise InvalidFeatureError(
                f"a spline of degree {p} with {n} control points has knots of the shape "
                f"{self.knots.shape}; it needs {n + p + 1} knots"
            )
        if not np.isfinite(self.knots).all() or (np.diff(self.knots) < 0.0).any():
            raise InvalidFeatureError("a spline's knots must be finite and ascend")
        inner = self.knots[p : n + 1]
        if (self.knots[: p + 1] != inner[0]).any() or (self.knots[n:] != inner[-1]).any():
            raise InvalidFeatureError(f"a spline's first and last {p + 1} knots must be equal")
        if (self.knots[p + 1 : -1] <= self.knots[1 : -p - 1]).any():
            raise InvalidFeatureError(
                f"an inner knot of a spline of degree {p} is there more than {p} times: "
                "the curve would break apart"
            )

    def _check_period(self) -> None:
        n, p = len(self.control), self.degree
        if n < LEAST_CLOSED:
            raise InvalidFeatureError(
                f"a closed spline has {n} control points; it needs at least {LEAST_CLOSED}"
            )
        if self.knots.shape != (n + 1,):
            raise InvalidFeatureError(
                f"a closed spline with {n} control points has knots of the shape "
                f"{self.knots.shape}; it needs {n + 1} knots, of one period"
            )
        if not np.isfinite(self.knots).all() or (np.diff(self.knots) < 0.0).any():
            raise InvalidFeatureError("a spline's knots must be finite and ascend")
        if not self.knots[-1] > self.knots[0]:
            raise InvalidFeatureError("a closed spline's period has no length")
        around = unroll_knots(self.knots, p)
        if (around[p:] <= around[:-p]).any():
            raise InvalidFeatureError(
                f"a knot of a closed spline of degree {p} is there more than {p} times: "
                "the curve would break apart"
            )

    @property
    def domain(self) -> tuple[float, float]:
        """The first and the last parameter; of a closed curve both are the same place."""
        return float(self.knots[0]), float(self.knots[-1])

    def __call__(self, t: ArrayLike) -> Points:
        return self.evaluate(t)

    def evaluate(self, t: ArrayLike) -> Points:
        """(m, 3) points at parameters (m,), the ends beyond them; a closed curve goes round."""
        return self.derivative(t, 0)

    def derivative(self, t: ArrayLike, order: int = 1) -> Points:
        """(m, 3) derivatives by the parameter at parameters (m,), those of the ends beyond."""
        at = self._within(t)
        return self._curve()(at, nu=order) if order <= self.degree else np.zeros((len(at), 3))

    def tangent(self, t: ArrayLike) -> Points:
        """(m, 3) unit tangents; where the curve stands still, towards where it goes on."""
        at = self._within(t)
        result = self.derivative(at)
        size = np.linalg.norm(result, axis=1, keepdims=True)
        still = size[:, 0] <= 1e-12 * float(np.abs(np.ptp(self.control, axis=0)).max())
        if still.any():
            # A chord over a thousandth of the domain about the point.
            low, high = self.domain
            step = 5e-4 * (high - low)
            result[still] = self.evaluate(at[still] + step) - self.evaluate(at[still] - step)
            size = np.linalg.norm(result, axis=1, keepdims=True)
        return result / np.where(size > 0.0, size, 1.0)

    @property
    def length(self) -> float:
        """Arc length."""
        return float(self._lengths()[1][-1])

    def at_lengths(self, lengths: ArrayLike) -> Floats:
        """(m,) parameters at arc lengths (m,) from the beginning, the ends beyond them."""
        places, table = self._lengths()
        wanted = np.clip(np.asarray(lengths, np.float64), 0.0, table[-1])
        part = np.clip(np.searchsorted(table, wanted, "right") - 1, 0, len(table) - 2)
        low, high = places[part], places[part + 1]
        rise = table[part + 1] - table[part]
        t = low + (high - low) * (wanted - table[part]) / np.where(rise > 0.0, rise, 1.0)
        for _ in range(NEWTON_STEPS):
            speed = np.linalg.norm(self.derivative(t), axis=1)
            miss = table[part] + self._between(low, t) - wanted
            t = np.clip(t - miss / np.where(speed > 0.0, speed, np.inf), low, high)
        return t

    def sample(self, count: int) -> Points:
        """(count, 3) points at equal arc length from end to end, at least 2."""
        return self.evaluate(self.at_lengths(np.linspace(0.0, self.length, count)))

    def _within(self, t: ArrayLike) -> Floats:
        """(m,) parameters within the domain: the ends for those beyond, or a period's turn on."""
        given = np.atleast_1d(np.asarray(t, np.float64))
        low, high = self.domain
        return low + np.mod(given - low, high - low) if self.closed else np.clip(given, low, high)

    def _curve(self) -> BSpline:
        if not self.closed:
            return BSpline.construct_fast(self.knots, self.control, self.degree)
        around = np.arange(len(self.control) + self.degree) % len(self.control)
        return BSpline.construct_fast(
            unroll_knots(self.knots, self.degree), self.control[around], self.degree
        )

    def _lengths(self) -> tuple[Floats, Floats]:
        """Parameters, PARTS to a knot span, and the arc length up to each."""
        spans = np.unique(self.knots)
        count = PARTS * (len(spans) - 1) + 1
        places = np.interp(np.arange(count) / PARTS, np.arange(len(spans)), spans)
        return places, np.r_[0.0, np.cumsum(self._between(places[:-1], places[1:]))]

    def _between(self, low: Floats, high: Floats) -> Floats:
        """(m,) arc lengths from parameters (m,) to parameters (m,) of the same knot span."""
        half = (high - low) / 2.0
        t = (low + high)[:, None] / 2.0 + half[:, None] * GAUSS_X
        speed = np.linalg.norm(self.derivative(t.ravel()), axis=1).reshape(t.shape)
        return half * (speed @ GAUSS_W)


def unroll_knots(knots: Floats, degree: int) -> Floats:
    """(n + 2 degree + 1,) the knots (n + 1,) of one period, ``degree`` more to either side."""
    n = len(knots) - 1
    turns, number = np.divmod(np.arange(-degree, n + degree + 1), n)
    return knots[number] + turns * (knots[-1] - knots[0])
