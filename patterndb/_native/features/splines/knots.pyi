# Bound by rust/python/src/features.rs.
from patterndb.geometry.points import Floats

def count_determined(parameters: Floats, knots: Floats, degree: int) -> int:
    """How many of the ascending parameters (m,) can have control points of their own.

    Parameter t can have control point i if basis function i is positive at t; greedily, each
    has the first that is free, which gives the most. As many as control points: the samples
    determine the spline. As many as parameters: values there can be interpolated.
    """
