"""The first curve of a sketch: through the clicked points, then onto the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.model import Model
from patterndb_sketch.features.splines import Spline, chordal_parameters

#: Distance of samples, as a share of the model's diagonal.
SPACING = 0.005

#: The fewest and the most samples of a curve.
FEWEST, MOST = 20, 400

#: Clicked points this close, as a share of the model's diagonal, are one: a double click.
SAME_CLICK = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class InitialCurve:
    """A sketched curve and its samples on the model.

    through:   the interpolating spline in space, off the model between the clicked points.
    samples:   (m, 3) float64, the points of the model nearest to equal steps along it.
    triangles: (m,) int32, where they lie.
    lengths:   (m,) float64, how far each went: long ways mean that more points are wanted.
    n_clicked: points that count; fewer than given if some were clicked twice.
    """

    through: Spline
    samples: Points
    triangles: Int32Array
    lengths: NDArray[np.float64]
    n_clicked: int


def find_initial_curve(model: Model, clicked: ArrayLike) -> InitialCurve:
    """The curve through (k, 3) clicked points, sampled, on the model.

    Two points give a straight line, three a parabola, more a cubic spline, at chordal
    parameters. It is sampled at equal arc length, SPACING of the diagonal apart or, for FEWEST
    or MOST samples, closer or wider, and each sample goes to the nearest point of the model.

    Source: feature curve recovery paper, section 4.1. Raises InvalidFeatureError for fewer than
    two distinct points.
    """
    points = as_points(clicked, "clicked points", InvalidFeatureError)
    if not len(points):
        raise InvalidFeatureError("no point was clicked; click at least two")
    kept = [points[0]]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > SAME_CLICK * model.diagonal:
            kept.append(point)
    if len(kept) < 2:
        raise InvalidFeatureError("all clicked points are at one place; click at least two places")
    through = interpolate_points(np.array(kept))
    wanted = round(through.length / (SPACING * model.diagonal)) + 1
    feet = model.nearest(through.sample(min(max(wanted, FEWEST), MOST)))
    return InitialCurve(through, feet.points, feet.triangles, feet.lengths, len(kept))


def interpolate_points(points: Points) -> Spline:
    """The spline through (k, 3) points, no two neighbours at one place, of degree 3 or k - 1."""
    degree = min(3, len(points) - 1)
    curve = make_interp_spline(chordal_parameters(points), points, k=degree)
    return Spline(degree, curve.t, curve.c)
