"""Least squares splines through samples, some of which are met exactly.

That is min |N C - A|^2 subject to M C = B, N and M being rows of a B-spline basis: those of a curve
with ends (:class:`OpenRows`) or of a closed one (:class:`PeriodRows`). Parameters are then
corrected: samples slide along the curve to where it is nearest to them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BSpline
from scipy.linalg import lapack, pinvh
from scipy.sparse import csr_array

from patterndb._native.features.splines.fit import normal_bands, times, transposed
from patterndb._native.features.splines.knots import count_determined
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines.knots import (
    SAME,
    as_parameters,
    average_knots,
    average_period,
    chordal_parameters,
    chordal_period,
    count_interpolated,
    evaluate_period,
    find_distinct,
    least_control,
)
from patterndb_sketch.features.splines.spline import LEAST_CLOSED, MAX_DEGREE, Spline

#: The libraries' routines are known at run time only.
_lapack: Any = lapack

#: A squared pivot below this share of the largest: the matrix is taken as rank-deficient.
SINGULAR = 1e-12

#: Eigenvalues below this share of the largest count as 0 where a matrix is rank-deficient.
CUTOFF = 1e-13

#: Of the gap to its neighbour a parameter may move this share: neighbours that move towards
#: each other do not pass.
LEEWAY = 0.49

#: A sample's number, and the point where the curve must be at its parameter.
Constraint = tuple[int, ArrayLike]

#: Samples to a control point.
SAMPLES_PER_CONTROL = 5

#: Rounds of parameter correction, at most.
ROUNDS = 3

#: How far the curve may be from a constraint, as a share of the samples' diagonal.
EXACT = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class SplineFit:
    """A spline through samples.

    parameters:  (m,) float64, those of the samples.
    error:       root of the mean squared distance of the samples from the curve at their
                 parameters; a constrained sample counts as being at its constraint.
    errors:      (r + 1,) the error at first and after every round of parameter correction.
    residual:    the greatest distance of the curve from a constraint.
    note:        what is not as asked for, "" if all is.
    """

    spline: Spline
    parameters: Floats
    error: float
    errors: tuple[float, ...]
    residual: float
    note: str

    @property
    def rounds(self) -> int:
        """Rounds of parameter correction that lowered the error."""
        return len(self.errors) - 1


def fit_spline(
    samples: ArrayLike,
    *,
    degree: int = 3,
    n_control: int | None = None,
    parameters: ArrayLike | None = None,
    constraints: Sequence[Constraint] = (),
    rounds: int = ROUNDS,
    closed: bool = False,
) -> SplineFit:
    """The spline with the least sum of squared distances to (m, 3) samples, m >= 2.

    degree:      a lower one is taken, and noted, where there are too few distinct samples.
    n_control:   control points, by default a fifth of the samples, at least degree + 1; more
                 where the constraints need them, which is noted.
    parameters:  (m,) of the samples, ascending from 0 to 1, by default chordal.
    constraints: (number of a sample, point (3,)): the curve passes through the point at the
                 sample's parameter, and the point takes the sample's place. The same
                 constraint twice is one.
    rounds:      of parameter correction at most, 0 for none.
    closed:      a closed spline, m >= 3: it goes on from the last sample to the first, which
                 is not repeated. Parameters are then of a period of 1: they ascend, and the
                 last is less than 1 above the first.

    Source: feature curve recovery paper, section 4.1; Piegl and Tiller 1995, "The NURBS Book",
    section 9.4.2. Raises InvalidFeatureError for samples at one place, for constraints of one
    parameter at different points, and for constraints that n_control, if given, is too few for.
    """
    given = as_points(samples, "samples of a curve", InvalidFeatureError)
    least = LEAST_CLOSED if closed else 2
    if len(given) < least:
        what = "closed curve" if closed else "curve"
        raise InvalidFeatureError(f"a {what} needs at least {least} samples, got {len(given)}")
    if parameters is None:
        chosen = chordal_period(given) if closed else chordal_parameters(given)
    else:
        chosen = as_parameters(parameters, len(given), closed=closed)
    numbers, targets = _constraints(constraints, given, chosen)
    notes: list[str] = []
    places = find_distinct(chosen)
    if closed:
        places = places[places - places[0] < 1.0 - SAME]
    n_distinct = len(places)
    if n_distinct < least:
        raise InvalidFeatureError(
            f"the samples of a closed curve are at {n_distinct} places; give at least {least}"
        )
    if not 1 <= degree <= MAX_DEGREE:
        raise InvalidFeatureError(f"a spline's degree is {degree}; give one of 1 to {MAX_DEGREE}")
    if degree >= n_distinct:
        notes.append(f"degree {n_distinct - 1} instead of {degree}: {n_distinct} distinct samples")
        degree = n_distinct - 1
    if closed:
        knots = _find_period(degree, n_control, len(given), places, chosen[numbers], notes)
        n = len(knots) - 1
    else:
        knots = _knots(degree, n_control, chosen, numbers, notes)
        n = len(knots) - degree - 1
    # Numbers near 1 keep the digits.
    centre = given.mean(axis=0)
    scale = float(np.linalg.norm(np.ptp(np.concatenate([given, targets]), axis=0)))
    scale = scale if scale > 0.0 else 1.0
    wanted = (given - centre) / scale
    wanted[numbers] = (targets - centre) / scale
    rows_of = PeriodRows.of if closed else OpenRows.of
    control, error, residual = _solve(rows_of(chosen, knots, degree), wanted, numbers)
    if residual > EXACT:
        raise InvalidFeatureError(
            f"{len(numbers)} constraints cannot all be met by {n} control points: one is missed "
            f"by {scale * residual:.3g}; take constraints away or ask for more control points"
        )
    errors = [scale * error]
    for _ in range(rounds):
        moved = correct_parameters(Spline(degree, knots, control, closed), wanted, chosen)
        if not closed and count_determined(moved, knots, degree) < n:
            break
        rows = rows_of(moved, knots, degree)
        trial, trial_error, trial_residual = _solve(rows, wanted, numbers)
        if not (trial_error < error and trial_residual <= EXACT):
            break
        control, chosen, error, residual = trial, moved, trial_error, trial_residual
        errors.append(scale * error)
    spline = Spline(degree, knots, centre + scale * control, closed)
    return SplineFit(spline, chosen, errors[-1], tuple(errors), scale * residual, "; ".join(notes))


def _constraints(
    constraints: Sequence[Constraint], samples: Points, parameters: Floats
) -> tuple[NDArray[np.int64], Points]:
    """(q,) samples' numbers, ascending, no two with one parameter, and (q, 3) points."""
    reach = EXACT * float(np.linalg.norm(np.ptp(samples, axis=0)))
    met: dict[float, tuple[int, Points]] = {}
    for number, place in constraints:
        if not 0 <= number < len(samples):
            raise InvalidFeatureError(
                f"a constraint names sample {number}; there are 0..{len(samples) - 1}"
            )
        point = as_points(
            np.asarray(place)[None], f"the point of sample {number}", InvalidFeatureError
        )[0]
        other = met.setdefault(float(parameters[number]), (number, point))
        if np.linalg.norm(other[1] - point) > reach:
            raise InvalidFeatureError(
                f"samples {other[0]} and {number} have one parameter and are to be at two points, "
                f"{other[1].tolist()} and {point.tolist()}; take one of the constraints away"
            )
    ordered = sorted(met.values(), key=lambda entry: entry[0])
    numbers = np.array([number for number, _ in ordered], np.int64)
    return numbers, np.array([point for _, point in ordered]).reshape(-1, 3)


def _knots(
    degree: int,
    asked: int | None,
    parameters: Floats,
    numbers: NDArray[np.int64],
    notes: list[str],
) -> Floats:
    """Knots for as many control points as asked for, or enough for the constraints."""
    most = len(find_distinct(parameters))
    if asked is not None:
        if asked <= degree:
            raise InvalidFeatureError(
                f"a spline of degree {degree} needs at least {degree + 1} control points, "
                f"not {asked}"
            )
        if asked > most:
            notes.append(f"{most} control points instead of {asked}: no more samples")
        return average_knots(parameters, degree, min(asked, most))
    n = min(max(len(parameters) // SAMPLES_PER_CONTROL, degree + 1), most)
    knots = average_knots(parameters, degree, n)
    held = parameters[numbers]
    if count_determined(held, knots, degree) == len(held):
        return knots
    knots = average_knots(parameters, degree, n, held)
    more = len(knots) - degree - 1
    notes.append(f"{more} control points instead of {n}: constraints close together")
    return knots


def _find_period(
    degree: int,
    asked: int | None,
    n_samples: int,
    places: Floats,
    held: Floats,
    notes: list[str],
) -> Floats:
    """Knots of a period, for as many control points as asked for, or enough for the constraints.

    places: (d,) the distinct parameters. held: (q,) those of constraints.
    """
    least, most = least_control(degree), len(places)
    n = n_samples // SAMPLES_PER_CONTROL if asked is None else asked
    if asked is not None and asked < least:
        raise InvalidFeatureError(
            f"a closed spline of degree {degree} needs at least {least} control points, not {asked}"
        )
    if asked is not None and asked > most:
        notes.append(f"{most} control points instead of {asked}: no more samples")
    n = min(max(n, least), most)
    # Sites are between 0 and 1, wherever the period begins.
    begin = places[0]
    knots = begin + average_period(places - begin, degree, n)
    if asked is not None or count_interpolated(held, knots, degree) == len(held):
        return knots
    sites = np.unique(np.searchsorted(places, held, "right") - 1)
    knots = begin + average_period(places - begin, degree, n, sites)
    notes.append(f"{len(knots) - 1} control points instead of {n}: constraints close together")
    return knots


def _solve(
    rows: OpenRows | PeriodRows, wanted: Points, numbers: NDArray[np.int64]
) -> tuple[Points, float, float]:
    """(n, 3) control points, error and greatest residual of the constraints."""
    control = solve_constrained(rows, wanted, numbers)
    off = np.linalg.norm(rows.times(control) - wanted, axis=1)
    return control, float(np.sqrt((off**2).mean())), float(off[numbers].max(initial=0.0))


def correct_parameters(spline: Spline, samples: Points, parameters: Floats) -> Floats:
    """(m,) parameters after one step of Newton's method for the feet of (m, 3) samples.

    The ends of a curve that has any keep theirs, and the parameters stay in order.

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
    if spline.closed:
        period = spline.domain[1] - spline.domain[0]
        gap = LEEWAY * np.diff(parameters, append=parameters[0] + period)
        return parameters + np.clip(step, -np.roll(gap, 1), gap)
    gap = LEEWAY * np.diff(parameters)
    step[1:-1] = np.clip(step[1:-1], -gap[:-1], gap[1:])
    step[0] = step[-1] = 0.0
    return parameters + step


#: Solves a system for right sides (n, k).
SystemSolver = Callable[[Floats], Floats]


@dataclass(frozen=True, slots=True, eq=False)
class OpenRows:
    """Rows N (m, n) of the basis of a curve with ends: degree + 1 entries next to each other.

    So N'N is banded: no product of full matrices, which would also wake up the threads of a
    numerical library for nothing.

    values: (m, degree + 1), what is not 0. first: (m,) int32, the column of the first of these.
    n: columns.
    """

    values: Floats
    first: Int32Array
    n: int

    @classmethod
    def of(cls, parameters: Floats, knots: Floats, degree: int) -> OpenRows:
        """Evaluate the basis at parameters (m,)."""
        matrix = BSpline.design_matrix(parameters, knots, degree)
        width = degree + 1
        values = np.asarray(matrix.data, np.float64).reshape(-1, width)
        return cls(values, matrix.indices[::width].astype(np.int32), len(knots) - width)

    def times(self, control: Points) -> Points:
        """(m, 3) N C."""
        return times(self.values, self.first, control)

    def transposed_times(self, points: Points) -> Points:
        """(n, 3) N'A."""
        return transposed(self.values, self.first, self.n, points)

    def select(self, held: NDArray[np.int64]) -> Floats:
        """(q, n) some of the rows, in full."""
        result = np.zeros((len(held), self.n))
        for k in range(self.values.shape[1]):
            result[np.arange(len(held)), self.first[held] + k] = self.values[held, k]
        return result

    def make_normal_matrix(self) -> Floats:
        """(n, n) N'N in full."""
        bands = normal_bands(self.values, self.first, self.n)
        result = np.zeros((self.n, self.n))
        for k in range(len(bands)):
            at = np.arange(self.n - k)
            result[at + k, at] = result[at, at + k] = bands[k, : self.n - k]
        return result

    def factor(self) -> SystemSolver | None:
        """Factor N'N; None where it is rank-deficient."""
        bands = normal_bands(self.values, self.first, self.n)
        factor, failed = _lapack.dpbtrf(bands, lower=1)
        if failed or _is_singular(factor[0]):
            return None
        return lambda right: _lapack.dpbtrs(factor, right, lower=1)[0]


@dataclass(frozen=True, slots=True, eq=False)
class PeriodRows:
    """Rows N (m, n) of the basis of a closed curve: they go round, so that N'N is no band."""

    matrix: csr_array

    @classmethod
    def of(cls, parameters: Floats, knots: Floats, degree: int) -> PeriodRows:
        """Evaluate the basis at parameters (m,)."""
        return cls(evaluate_period(parameters, knots, degree))

    def times(self, control: Points) -> Points:
        """(m, 3) N C."""
        return self.matrix @ control

    def transposed_times(self, points: Points) -> Points:
        """(n, 3) N'A."""
        return self.matrix.T @ points

    def select(self, held: NDArray[np.int64]) -> Floats:
        """(q, n) some of the rows, in full."""
        rows: Any = self.matrix
        return rows[held].toarray() if len(held) else np.zeros((0, rows.shape[1]))

    def make_normal_matrix(self) -> Floats:
        """(n, n) N'N in full."""
        return np.asarray((self.matrix.T @ self.matrix).todense())

    def factor(self) -> SystemSolver | None:
        """Factor N'N; None where it is rank-deficient."""
        return _factor_full(self.make_normal_matrix())


def solve_constrained(
    rows: OpenRows | PeriodRows, wanted: Points, held: NDArray[np.int64]
) -> Points:
    """(n, 3) the control points C with the least |N C - A|^2 that meet the held rows exactly.

    rows: N. wanted: (m, 3) A. held: (q,) the numbers of the rows that are constraints: M and B are
    those rows of N and A.

    With multipliers L: N'N C + M'L = N'A and M C = B. C is taken out of the second by the
    first. Refined once: the residual is taken from A, not from N'N, which has half the digits.
    Where a matrix is rank-deficient, least squares and the smallest solution of the whole.
    """
    exact = rows.select(held)
    solve = rows.factor()
    if solve is None:
        return _solve_deficient(rows, exact, wanted, held)
    lifted = solve(exact.T) if len(held) else exact.T
    meet = _factor_full(exact @ lifted) if len(held) else None
    if meet is None and len(held):
        return _solve_deficient(rows, exact, wanted, held)
    control = np.zeros((exact.shape[1], wanted.shape[1]))
    multipliers = np.zeros((len(held), wanted.shape[1]))
    for _ in range(2):
        off = wanted - rows.times(control)
        free = solve(rows.transposed_times(off) - exact.T @ multipliers)
        if meet is not None:
            more = meet(exact @ free - off[held])
            multipliers += more
            free -= lifted @ more
        control += free
    return control


def _factor_full(matrix: Floats) -> SystemSolver | None:
    """Factor a full positive definite matrix; None where it is rank-deficient."""
    factor, failed = _lapack.dpotrf(matrix, lower=1)
    if failed or _is_singular(np.diag(factor)):
        return None
    return lambda right: _lapack.dpotrs(factor, right, lower=1)[0]


def _is_singular(pivots: Floats) -> bool:
    return bool(pivots.min() ** 2 < SINGULAR * pivots.max() ** 2)


def _solve_deficient(
    rows: OpenRows | PeriodRows, exact: Floats, wanted: Points, held: NDArray[np.int64]
) -> Points:
    """Solve the same by the full matrix of the system and its pseudo-inverse."""
    q, n = exact.shape
    system = np.block([[rows.make_normal_matrix(), exact.T], [exact, np.zeros((q, q))]])
    inverse = pinvh(system, rtol=CUTOFF)
    result = np.zeros((n + q, wanted.shape[1]))
    for _ in range(2):
        off = wanted - rows.times(result[:n])
        right = rows.transposed_times(off) - exact.T @ result[n:]
        result += inverse @ np.concatenate([right, off[held]])
    return result[:n]
