"""Drawn curve networks as plain JSON.

    {"curves": {"roof_rail": [[1.28, -0.64, 1.06], [1.9, -0.65, 1.08], [2.45, -0.64, 1.05]],
                "a_pillar": {"degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1],
                             "control_points": [[0.55, -0.8, 0.63], ...]}},
     "meet": {"a_pillar_top": ["a_pillar", "roof_rail"]},
     "near": {"a_pillar_top": [1.28, -0.64, 1.06]},
     "tolerance": 0.05}

curves: by the names that a template has for them, each a polyline or a spline. A polyline whose
last point is its first is a closed curve; so is a spline with "closed": true, whose knots are those
of one period, see :class:`patterndb_sketch.features.splines.Spline`. Where they meet follows from
the template, whose corners meet and near are about: meet, which of a corner's curves say where it
is, all if it is left out; near, a point near a corner, where its curves meet more than once.
tolerance: how far curves may pass and still meet, in the unit of the points.

What :mod:`patterndb_sketch.features.files.curvesjson` writes is a network too: the model's name,
and how each curve was found, are passed over.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb.system.documents import JsonModel, JsonValue, Number, Point, complete_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.initial import interpolate_points, is_ring
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.splines import Spline, fit_spline

KEYS = ("model", "curves", "meet", "near", "tolerance")
SPLINE_KEYS = ("degree", "knots", "control_points", "closed")

#: What curves that were recovered from strokes have beside.
FOUND_KEYS = (
    "samples", "parameters", "stroke", "constraints", "settings", "mended", "failed", "ended",
    "notes", "figures",
)  # fmt: skip

#: How far a spline may be from the polyline it stands for, as a share of its length: well below
#: what can be seen, and what a drawn curve is off.
FIT = 2e-4

#: A polyline is sampled so often before it is fitted, at least, and points to a control point.
SAMPLES = 100
POINTS_PER_CONTROL = 5


def drawn_network(document: JsonValue) -> FeatureCurves:
    """The network in a document. Raises InvalidFeatureError that names the place in it."""
    entries = document.entries(KEYS, 'an object such as {"curves": {...}}')
    if "curves" not in entries:
        document.fail('"curves" is missing: an object with the points of every curve')
    curves = {name: curve_of(one) for name, one in entries["curves"].entries().items()}
    if not curves:
        entries["curves"].fail("there is no curve; give those that the template asks for")
    meet: dict[str, tuple[str, ...]] = {}
    if "meet" in entries:
        for corner, names in entries["meet"].entries().items():
            listed = names.items("a list of the names of curves")
            meet[corner] = tuple(_known(one, curves) for one in listed)
    near: dict[str, Points] = {}
    if "near" in entries:
        near = {name: np.array(at.point()) for name, at in entries["near"].entries().items()}
    tolerance: float | None = None
    if "tolerance" in entries:
        tolerance = entries["tolerance"].number()
        if tolerance <= 0.0:
            entries["tolerance"].fail("give a tolerance above 0, or leave it out")
    return FeatureCurves(curves, meet, near, tolerance)


def network_document(network: FeatureCurves) -> dict[str, object]:
    """The network as plain JSON has it, its curves as splines; reading gives them back."""
    document: dict[str, object] = {
        "curves": {name: curve.as_document() for name, curve in network.curves.items()}
    }
    if network.meet:
        document["meet"] = {corner: list(names) for corner, names in network.meet.items()}
    if network.near:
        document["near"] = {corner: at.tolist() for corner, at in network.near.items()}
    if network.tolerance is not None:
        document["tolerance"] = network.tolerance
    return document


class SplineEntries(JsonModel):
    degree: int
    knots: list[Number]
    control_points: list[Point]
    closed: bool = False


def curve_of(value: JsonValue) -> Spline:
    """Return the spline of a polyline or of a spline's document."""
    with value.named():
        if not value.is_object:
            return spline_through(np.array(value.polyline()))
        entries = value.entries((*SPLINE_KEYS, *FOUND_KEYS))
        spline = {name: one.value for name, one in entries.items() if name in SPLINE_KEYS}
        found = JsonValue(spline, value.where, value.error).read(SplineEntries)
        control = np.array(complete_points(found.control_points)).reshape(-1, 3)
        return Spline(found.degree, np.array(found.knots), control, found.closed)


def spline_through(points: Points) -> Spline:
    """A spline along a polyline (k, 3), k >= 2, off it by no more than FIT of its length.

    A closed one along a polyline that ends where it begins. As smooth as that allows: control
    points are doubled until it does; a spline through every point is the last resort.
    """
    given = as_points(points, "points of a curve", InvalidFeatureError)
    steps = np.linalg.norm(np.diff(given, axis=0), axis=1)
    length = float(steps.sum())
    if not length > 0.0:
        raise InvalidFeatureError("all points of a curve are one; give two places or more")
    given = given[np.r_[True, steps > 1e-12 * length]]
    closed = is_ring(given)
    if closed:
        given = given[:-1]
    if len(given) <= 2 * POINTS_PER_CONTROL:
        return interpolate_points(given, closed=closed)
    # Between the points a polyline is straight: only they count, but more help the fit.
    dense = given
    if len(given) < SAMPLES:
        dense = interpolate_points(given, closed=closed).sample(SAMPLES + closed)
        dense = dense[:-1] if closed else dense
    ends = () if closed else ((0, given[0]), (len(dense) - 1, given[-1]))
    n = max(4, len(given) // POINTS_PER_CONTROL)
    while n < len(given):
        curve = fit_spline(dense, n_control=n, constraints=ends, closed=closed).spline
        if _off(curve, given) <= FIT * length:
            return curve
        n *= 2
    return interpolate_points(given, closed=closed)


def _off(curve: Spline, points: Points) -> float:
    """The greatest distance of points from a curve, at most: from a dense polyline along it."""
    along = curve.sample(8 * len(points))
    if curve.closed:
        # The curve may begin anywhere.
        return float(np.asarray(KDTree(along).query(points)[0]).max())
    # The points are in order along the curve: the nearest in a window about equal arc length.
    share = arc_length(points)
    centre = np.round(share / share[-1] * (len(along) - 1)).astype(int)
    window = np.arange(-24, 25)
    near = np.clip(centre[:, None] + window, 0, len(along) - 1)
    return float(np.linalg.norm(along[near] - points[:, None], axis=2).min(axis=1).max())


def _known(name: JsonValue, curves: dict[str, Spline]) -> str:
    text = name.text("the name of a curve")
    if text not in curves:
        name.fail(f"there is no curve {text!r}; curves are {', '.join(curves)}")
    return text
