"""Drawn curve networks, and the curves that were recovered from strokes, as plain JSON.

    {"curves": {"roof_rail": [[1.28, -0.64, 1.06], [1.9, -0.65, 1.08], [2.45, -0.64, 1.05]],
                "a_pillar": {"degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1],
                             "control_points": [[0.55, -0.8, 0.63], ...]}},
     "meet": {"a_pillar_top": ["a_pillar", "roof_rail"]},
     "near": {"a_pillar_top": [1.28, -0.64, 1.06]},
     "tolerance": 0.05}

curves: by the names that a template has for them, each a polyline or a spline. A polyline whose
last point is its first is a closed curve; so is a spline with "closed": true, whose knots are those
of one period, see :class:`patterndb_sketch.features.splines.Spline`. Where they meet follows from
the template, whose corners meet and near are about: meet, which of a corner's curves define where
it is, all if it is left out; near, a point near a corner, where its curves meet more than once.
tolerance: how far curves may pass and still meet, in the unit of the points.

A file of recovered curves is a network too. It names the "model", and its curves have more entries:

    {"degree": 3, "knots": [...], "control_points": [...],
     "samples": [[...], ...], "parameters": [0, ...], "stroke": [[...], ...],
     "constraints": [{"sample": 4, "point": [1.3, -0.6, 1.1]}],
     "settings": {"alpha": 1, "beta": 90, ...},
     "mended": [], "failed": [3], "ended": [], "notes": ["..."],
     "figures": {"length": 1.2, "moved": {"mean": 0.01, "most": 0.03}, "fit": {...}, "off": {...}}}

samples: where the curve was found, on the model, of a closed curve the first not repeated;
parameters: theirs on the spline. mended, failed, ended: numbers of samples, see
:class:`patterndb_sketch.features.snap.FeatureCurve`. figures: see
:class:`patterndb_sketch.features.strokes.Figures`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import UNSET, Meta, UnsetType
from msgspec import field as entry
from scipy.spatial import KDTree

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Number,
    Point,
    Polyline,
    complete_points,
    encode_json,
    read_document,
)
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.strokesjson import (
    SettingsModel,
    model_of_settings,
    settings_of_model,
)
from patterndb_sketch.features.initial import interpolate_points, is_ring
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.snap import FeatureCurve, SnapSettings
from patterndb_sketch.features.splines import Constraint, Spline, fit_spline
from patterndb_sketch.features.strokes import Figures, RecoveredCurve

#: Bytes that a file may have: curves of a million points have some 40 million.
MAX_BYTES = 64_000_000

#: How far a spline may be from the polyline it stands for, as a share of its length: well below
#: what can be seen, and what a drawn curve is off.
FIT = 2e-4

#: A polyline is sampled so often before it is fitted, at least, and points to a control point.
SAMPLES = 100
POINTS_PER_CONTROL = 5

SampleNumbers = list[Annotated[int, Meta(description="the number of a sample")]]


class ConstraintModel(JsonModel):
    """A sample that is held at a point."""

    sample: Annotated[int, Meta(extra={"missing": "the number of a sample, and its point"})]
    point: Annotated[Point, Meta(extra={"missing": "the point where the sample is held"})]


class SplineModel(JsonModel, kw_only=True, omit_defaults=True):
    """A spline."""

    degree: int
    knots: list[Number]
    control_points: list[Point]
    closed: bool = False

    @classmethod
    def of(cls, spline: Spline) -> SplineModel:
        """Return the model of a spline."""
        return cls(**_spline_entries(spline))

    def spline(self) -> Spline:
        """Return the spline; raises InvalidFeatureError for one that cannot be."""
        control = np.array(complete_points(self.control_points)).reshape(-1, 3)
        return Spline(self.degree, np.array(self.knots), control, self.closed)


class FoundModel(SplineModel, kw_only=True):
    """A curve that was recovered from a stroke."""

    samples: Polyline
    parameters: list[Number]
    stroke: Polyline
    constraints: list[ConstraintModel]
    settings: SettingsModel
    mended: SampleNumbers
    failed: SampleNumbers
    ended: SampleNumbers
    notes: list[str]
    figures: Figures


class DrawnCurveModel(SplineModel, kw_only=True):
    """A spline, or a recovered curve whose other entries are passed over."""

    samples: Any = UNSET
    parameters: Any = UNSET
    stroke: Any = UNSET
    constraints: Any = UNSET
    settings: Any = UNSET
    mended: Any = UNSET
    failed: Any = UNSET
    ended: Any = UNSET
    notes: Any = UNSET
    figures: Any = UNSET


class NetworkModel(JsonModel, omit_defaults=True):
    """A network; meet, near, tolerance: as :class:`FeatureCurves` has them."""

    curves: Annotated[
        dict[str, Polyline | DrawnCurveModel],
        Meta(extra={"missing": "an object with the points of every curve"}),
    ]
    model: Any = UNSET
    meet: dict[str, list[Annotated[str, Meta(description="the name of a curve")]]] = entry(
        default_factory=dict
    )
    near: dict[str, Point] = entry(default_factory=dict)
    tolerance: Number | UnsetType = UNSET

    @classmethod
    def of(cls, network: FeatureCurves) -> NetworkModel:
        """Return the model of a network, its curves as splines."""
        return cls(
            {name: DrawnCurveModel(**_spline_entries(c)) for name, c in network.curves.items()},
            meet={corner: list(names) for corner, names in network.meet.items()},
            near={corner: at.tolist() for corner, at in network.near.items()},
            tolerance=UNSET if network.tolerance is None else network.tolerance,
        )

    def network(self, place: JsonValue) -> FeatureCurves:
        """Return the network; raises the error of its place."""
        curves: dict[str, Spline] = {}
        for name, one in self.curves.items():
            with place.at("curves", name).named():
                curves[name] = (
                    spline_through(np.array(complete_points(one)))
                    if isinstance(one, list)
                    else one.spline()
                )
        if not curves:
            place.at("curves").fail("there is no curve; give those that the template asks for")
        for corner, names in self.meet.items():
            for number, name in enumerate(names):
                if name not in curves:
                    place.at("meet", corner, number).fail(
                        f"there is no curve {name!r}; curves are {', '.join(curves)}"
                    )
        tolerance = None if self.tolerance is UNSET else self.tolerance
        if tolerance is not None and tolerance <= 0.0:
            place.at("tolerance").fail("give a tolerance above 0, or leave it out")
        return FeatureCurves(
            curves,
            {corner: tuple(names) for corner, names in self.meet.items()},
            {corner: np.array(complete_points([at])[0]) for corner, at in self.near.items()},
            tolerance,
        )


class CurvesModel(JsonModel):
    """Recovered curves; meet, near, tolerance: passed over."""

    curves: Annotated[
        dict[str, Annotated[FoundModel, Meta(description="a curve recovered from a stroke")]],
        Meta(extra={"missing": "an object with every curve"}),
    ]
    model: Any = UNSET
    meet: Any = UNSET
    near: Any = UNSET
    tolerance: Any = UNSET


def read_network(path: Path | str) -> FeatureCurves:
    """Return the network of curves in a JSON file.

    Raises InvalidFeatureError with the file, the place in it and what is wrong; OSError.
    """
    wanted = 'an object such as {"curves": {...}}'

    def read(document: JsonValue) -> FeatureCurves:
        return document.read(NetworkModel, wanted).network(document)

    return read_document(Path(path), MAX_BYTES, InvalidFeatureError, "a network of curves", read)


def write_network(path: Path | str, network: FeatureCurves) -> None:
    """Write a network; :func:`read_network` gives it back. Raises OSError."""
    replace_file(Path(path), encode_json(NetworkModel.of(network)))


def read_curves(path: Path | str) -> tuple[RecoveredCurve, ...]:
    """Return the curves in a file that :func:`write_curves` made, all their numbers as they were.

    Raises InvalidFeatureError with the file and the place in it; OSError.
    """

    def read(document: JsonValue) -> tuple[RecoveredCurve, ...]:
        found = document.read(CurvesModel, 'an object such as {"curves": {...}}')
        return tuple(
            _recovered(name, one, document.at("curves", name)) for name, one in found.curves.items()
        )

    return read_document(Path(path), MAX_BYTES, InvalidFeatureError, "a network of curves", read)


def write_curves(path: Path | str, curves: Sequence[RecoveredCurve], model: str = "") -> None:
    """Write curves; model: the name of the file that they are on. Raises OSError."""
    if len({one.name for one in curves}) < len(curves):
        raise InvalidFeatureError("two curves have one name; give each a name of its own")
    document: dict[str, object] = {"model": model} if model else {}
    document["curves"] = {one.name: model_of_curve(one) for one in curves}
    replace_file(Path(path), encode_json(document))


def model_of_curve(one: RecoveredCurve) -> FoundModel:
    """Return one curve with all that is known of it, as files have it."""
    curve = one.curve
    return FoundModel(
        **_spline_entries(curve.spline),
        samples=curve.samples.tolist(),
        parameters=curve.parameters.tolist(),
        stroke=one.stroke.tolist(),
        constraints=models_of_constraints(curve.constraints),
        settings=model_of_settings(curve.settings),
        mended=list(curve.repaired),
        failed=list(curve.failed),
        ended=list(curve.ended),
        notes=list(curve.notes),
        figures=one.figures,
    )


def models_of_constraints(constraints: Sequence[Constraint]) -> list[ConstraintModel]:
    """Return constraints as files have them."""
    return [
        ConstraintModel(int(number), np.asarray(point, np.float64).tolist())
        for number, point in constraints
    ]


def constraints_of_models(
    models: Sequence[ConstraintModel], m: int, place: JsonValue
) -> tuple[Constraint, ...]:
    """Return the constraints of a curve with m samples; raises the error of their place."""
    _check_samples([one.sample for one in models], m, place)
    return tuple((one.sample, np.array(complete_points([one.point])[0])) for one in models)


def _spline_entries(spline: Spline) -> Mapping[str, Any]:
    return {
        "degree": spline.degree,
        "knots": spline.knots.tolist(),
        "control_points": spline.control.tolist(),
        "closed": spline.closed,
    }


def _recovered(name: str, found: FoundModel, place: JsonValue) -> RecoveredCurve:
    with place.named():
        spline = found.spline()
    samples, parameters = np.array(complete_points(found.samples)), np.array(found.parameters)
    m = len(samples)
    if len(parameters) != m:
        place.at("parameters").fail(f"there are {len(parameters)}, and {m} samples")
    low, high = spline.domain
    if spline.closed:
        # A closed curve goes on beyond its period, wherever that begins.
        low, high = parameters[0], parameters[0] + (high - low)
    if (np.diff(parameters) < 0.0).any() or parameters[0] < low or parameters[-1] > high:
        place.at("parameters").fail(f"they must ascend within the curve's {low:g} to {high:g}")
    for key in ("mended", "failed", "ended"):
        _check_samples(getattr(found, key), m, place.at(key))
    curve = FeatureCurve(
        spline,
        samples,
        parameters,
        constraints_of_models(found.constraints, m, place.at("constraints")),
        settings_of_model(found.settings, SnapSettings(), place.at("settings")),
        tuple(found.mended),
        tuple(found.failed),
        tuple(found.ended),
        tuple(found.notes),
    )
    return RecoveredCurve(name, np.array(complete_points(found.stroke)), curve, found.figures)


def _check_samples(numbers: Sequence[int], m: int, place: JsonValue) -> None:
    for k, number in enumerate(numbers):
        if not 0 <= number < m:
            place.at(k).fail(f"there is no sample {number}; there are {m}, from 0")


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
