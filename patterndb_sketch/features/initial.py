"""The first curve of a sketch: through the clicked points, then onto the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, as_points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines import Spline, chordal_parameters, fit_spline
from patterndb_sketch.features.splines.spline import LEAST_CLOSED

#: Distance of samples, as a share of the model's diagonal.
SPACING = 0.005

#: The fewest and the most samples of a curve; the fewest of a closed one, which turns all round.
FEWEST, MOST = 20, 400

FEWEST_CLOSED = 40

#: Clicked points this close, as a share of the model's diagonal, are one: a double click. A
#: stroke's ends are one place if they are as close, as a share of its own extent.
SAME_CLICK = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class InitialCurve:
    """A sketched curve and its samples on the model.

    through:   the interpolating spline in space, off the model between the clicked points; closed
               if the stroke is.
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


def is_ring(points: ArrayLike) -> bool:
    """Does a stroke (k, 3) come back to its start: is its last point the first again?

    As polygons are written, up to rounding (SAME_CLICK of its extent): so no stroke is closed that
    nobody meant to close, however near its ends are to each other.
    """
    given = np.asarray(points, np.float64)
    if len(given) <= LEAST_CLOSED:
        return False
    extent = float(np.linalg.norm(np.ptp(given, axis=0)))
    return bool(np.linalg.norm(given[-1] - given[0]) <= SAME_CLICK * extent)


def find_initial_curve(
    model: Surface, clicked: ArrayLike, *, closed: bool | None = None
) -> InitialCurve:
    """The curve through (k, 3) clicked points, sampled, on the model.

    closed: whether it goes on from the last point to the first; by default if that is the same
            place, see :func:`is_ring`.

    Two points give a straight line, three a parabola, more a cubic spline, at chordal
    parameters; a closed curve has a closed spline. It is sampled at equal arc length, SPACING of
    the diagonal apart or, for FEWEST (of a closed one FEWEST_CLOSED) or MOST samples, closer or
    wider, and each sample goes to the nearest point of the model. A closed curve's first sample is
    not repeated.

    Source: feature curve recovery paper, section 4.1. Differs from the paper: its curves all have
    ends. Raises InvalidFeatureError for fewer than two distinct points, three of a closed curve.
    """
    points = as_points(clicked, "clicked points", InvalidFeatureError)
    if not len(points):
        raise InvalidFeatureError("no point was clicked; click at least two")
    around = is_ring(points) if closed is None else closed
    kept = [points[0]]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > SAME_CLICK * model.diagonal:
            kept.append(point)
    near = np.linalg.norm(kept[-1] - kept[0]) <= SAME_CLICK * model.diagonal
    if around and len(kept) > 1 and (near or is_ring(points)):
        kept.pop()
    if len(kept) < 2:
        raise InvalidFeatureError("all clicked points are at one place; click at least two places")
    if around and len(kept) < LEAST_CLOSED:
        raise InvalidFeatureError(
            f"a closed curve needs at least {LEAST_CLOSED} places, got {len(kept)}; click more, or "
            "leave it open"
        )
    through = interpolate_points(np.array(kept), closed=around)
    wanted = round(through.length / (SPACING * model.diagonal)) + (not around)
    count = min(max(wanted, FEWEST_CLOSED if around else FEWEST), MOST)
    sampled = through.sample(count + 1)[:-1] if around else through.sample(count)
    feet = model.nearest(sampled)
    lengths = np.linalg.norm(feet.points - sampled, axis=1)
    return InitialCurve(through, feet.points, feet.triangles, lengths, len(kept))


def interpolate_points(points: Points, *, closed: bool = False) -> Spline:
    """The spline through (k, 3) points, no two neighbours at one place, of degree 3 or k - 1."""
    degree = min(3, len(points) - 1)
    if closed:
        return fit_spline(
            points, degree=degree, n_control=len(points), rounds=0, closed=True
        ).spline
    curve = make_interp_spline(chordal_parameters(points), points, k=degree)
    return Spline(degree, curve.t, curve.c)
