"""B-spline curves: evaluation, arc length, and least squares through given points."""

from sketch.features.splines.fit import Constraint, Fit, fit_spline
from sketch.features.splines.parameters import chordal
from sketch.features.splines.spline import Spline

__all__ = ["Constraint", "Fit", "Spline", "chordal", "fit_spline"]
