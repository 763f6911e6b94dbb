"""B-spline curves: evaluation, arc length, and least squares through given points.

Read spline (the curve), knots (parameters and knots), fit; each is for closed curves, too.
"""

from patterndb_sketch.features.splines.fit import Constraint, SplineFit, fit_spline
from patterndb_sketch.features.splines.knots import chordal_parameters
from patterndb_sketch.features.splines.spline import Spline

__all__ = ["Constraint", "Spline", "SplineFit", "chordal_parameters", "fit_spline"]
