"""Least squares splines through samples, some of which are met exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Floats, Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines.correction import corrected
from patterndb_sketch.features.splines.knots import averaged_knots, n_determined
from patterndb_sketch.features.splines.leastsquares import (
    basis_rows,
    constrained_least_squares,
    distances,
)
from patterndb_sketch.features.splines.parameters import as_parameters, chordal, distinct
from patterndb_sketch.features.splines.spline import MAX_DEGREE, Spline

#: A sample's number, and the point where the curve must be at its parameter.
Constraint = tuple[int, ArrayLike]

#: Samples to a control point.
SAMPLES_PER_CONTROL = 5

#: Rounds of parameter correction, at most.
ROUNDS = 3

#: How far the curve may be from a constraint, as a share of the samples' diagonal.
EXACT = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
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
) -> Fit:
    """The spline with the least sum of squared distances to (m, 3) samples, m >= 2.

    degree:      a lower one is taken, and noted, where there are too few distinct samples.
    n_control:   control points, by default a fifth of the samples, at least degree + 1; more
                 where the constraints need them, which is noted.
    parameters:  (m,) of the samples, ascending from 0 to 1, by default chordal.
    constraints: (number of a sample, point (3,)): the curve passes through the point at the
                 sample's parameter, and the point takes the sample's place. The same
                 constraint twice is one.
    rounds:      of parameter correction at most, 0 for none.

    Source: feature curve recovery paper, section 4.1; Piegl and Tiller 1995, "The NURBS Book",
    section 9.4.2. Raises InvalidFeatureError for samples at one place, for constraints of one
    parameter at different points, and for constraints that n_control, if given, is too few for.
    """
    given = as_points(samples, "samples of a curve", InvalidFeatureError)
    if len(given) < 2:
        raise InvalidFeatureError(f"a curve needs at least 2 samples, got {len(given)}")
    chosen = chordal(given) if parameters is None else as_parameters(parameters, len(given))
    numbers, targets = _constraints(constraints, given, chosen)
    notes: list[str] = []
    n_distinct = len(distinct(chosen))
    if not 1 <= degree <= MAX_DEGREE:
        raise InvalidFeatureError(f"a spline's degree is {degree}; give one of 1 to {MAX_DEGREE}")
    if degree >= n_distinct:
        notes.append(f"degree {n_distinct - 1} instead of {degree}: {n_distinct} distinct samples")
        degree = n_distinct - 1
    knots = _knots(degree, n_control, chosen, numbers, notes)
    n = len(knots) - degree - 1
    # Numbers near 1 keep the digits.
    centre = given.mean(axis=0)
    scale = float(np.linalg.norm(np.ptp(np.concatenate([given, targets]), axis=0)))
    scale = scale if scale > 0.0 else 1.0
    wanted = (given - centre) / scale
    wanted[numbers] = (targets - centre) / scale
    control, error, residual = _solved(wanted, chosen, numbers, knots, degree)
    if residual > EXACT:
        raise InvalidFeatureError(
            f"{len(numbers)} constraints cannot all be met by {n} control points: one is missed "
            f"by {scale * residual:.3g}; take constraints away or ask for more control points"
        )
    errors = [scale * error]
    for _ in range(rounds):
        moved = corrected(Spline(degree, knots, control), wanted, chosen)
        if n_determined(moved, knots, degree) < n:
            break
        trial, trial_error, trial_residual = _solved(wanted, moved, numbers, knots, degree)
        if not (trial_error < error and trial_residual <= EXACT):
            break
        control, chosen, error, residual = trial, moved, trial_error, trial_residual
        errors.append(scale * error)
    spline = Spline(degree, knots, centre + scale * control)
    return Fit(spline, chosen, errors[-1], tuple(errors), scale * residual, "; ".join(notes))


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
    most = len(distinct(parameters))
    if asked is not None:
        if asked <= degree:
            raise InvalidFeatureError(
                f"a spline of degree {degree} needs at least {degree + 1} control points, "
                f"not {asked}"
            )
        if asked > most:
            notes.append(f"{most} control points instead of {asked}: no more samples")
        return averaged_knots(parameters, degree, min(asked, most))
    n = min(max(len(parameters) // SAMPLES_PER_CONTROL, degree + 1), most)
    knots = averaged_knots(parameters, degree, n)
    held = parameters[numbers]
    if n_determined(held, knots, degree) == len(held):
        return knots
    knots = averaged_knots(parameters, degree, n, held)
    more = len(knots) - degree - 1
    notes.append(f"{more} control points instead of {n}: constraints close together")
    return knots


def _solved(
    wanted: Points, parameters: Floats, numbers: NDArray[np.int64], knots: Floats, degree: int
) -> tuple[Points, float, float]:
    """(n, 3) control points, error and greatest residual of the constraints."""
    values, first = basis_rows(parameters, knots, degree)
    n = len(knots) - degree - 1
    control = constrained_least_squares(values, first, n, wanted, numbers)
    off = distances(values, first, control, wanted)
    return control, float(np.sqrt((off**2).mean())), float(off[numbers].max(initial=0.0))
