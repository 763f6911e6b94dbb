"""B-spline curves: evaluation, arc length, and least squares through given points."""

from patterndb_sketch.features.splines.fit import Constraint, Fit, fit_spline
from patterndb_sketch.features.splines.parameters import chordal
from patterndb_sketch.features.splines.spline import Spline

__all__ = ["Constraint", "Fit", "Spline", "chordal", "fit_spline"]
