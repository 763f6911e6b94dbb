"""Strokes drawn along features, and the curves that are recovered from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.distance import cdist

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.snap import FeatureCurve, SnapSettings, snap
from patterndb_sketch.features.splines import Constraint, Spline

#: Samples of a curve, to each of those it was found by, that distances from it are measured to.
DENSITY = 4


@dataclass(frozen=True, slots=True, eq=False)
class FeatureStroke:
    """What a user has drawn along a feature.

    points: (k, 3) float64, near the model, in order. held: (c, 3) float64, where the curve shall
    pass exactly. closed: whether the curve goes on from the last point to the first; None: if that
    is the same place, see :func:`patterndb_sketch.features.initial.is_ring`.
    """

    name: str
    points: Points
    held: Points = field(default_factory=lambda: np.zeros((0, 3)))
    settings: SnapSettings = field(default_factory=SnapSettings)
    closed: bool | None = None


@dataclass(frozen=True, slots=True)
class Spread:
    """The mean and the greatest of some distances, in the model's unit."""

    mean: float
    most: float

    @classmethod
    def of(cls, distances: ArrayLike) -> Spread:
        values = np.asarray(distances, np.float64)
        return cls(float(values.mean()), float(values.max()))


@dataclass(frozen=True, slots=True)
class Figures:
    """How long a curve is, and how far off.

    moved: how far the stroke, laid onto the model, was from the curve.
    fit:   how far the samples that were found are from the curve.
    off:   how far the curve leaves the model: it is smooth, and its constraints may be anywhere.
    """

    length: float
    moved: Spread
    fit: Spread
    off: Spread


@dataclass(frozen=True, slots=True, eq=False)
class RecoveredCurve:
    """A stroke (k, 3) and the curve on the feature that it was drawn along."""

    name: str
    stroke: Points
    curve: FeatureCurve
    figures: Figures


def recover_curve(
    model: Surface, stroke: FeatureStroke, constraints: Sequence[Constraint] = ()
) -> RecoveredCurve:
    """The curve on the feature that a stroke was drawn along.

    constraints: more of them, as :func:`patterndb_sketch.features.snap.snap` takes them, beside
    those of the stroke's held points.

    Raises InvalidFeatureError that names the stroke, as
    :func:`patterndb_sketch.features.snap.snap` does, for two held points at one sample, for one
    that is off the model and where all of the stroke's points are, by more than ribs reach or the
    stroke is long.
    """
    try:
        _check_nearness(model, stroke)
        begun = find_initial_curve(model, stroke.points, closed=stroke.closed).samples
        held = (*find_held_samples(begun, stroke.held), *constraints)
        curve = snap(model, stroke.points, stroke.settings, held, closed=stroke.closed)
    except InvalidFeatureError as error:
        raise InvalidFeatureError(f"stroke {stroke.name!r}: {error}") from None
    return RecoveredCurve(stroke.name, stroke.points, curve, measure_curve(model, begun, curve))


def _check_nearness(model: Surface, stroke: FeatureStroke) -> None:
    """Refuse a stroke in another unit or frame than the model's, and held points off it."""
    reach = stroke.settings.radius * model.diagonal
    points = as_points(stroke.points, "points of a stroke", InvalidFeatureError)
    held = as_points(stroke.held, "points to hold", InvalidFeatureError)
    if len(points):
        why = model.explain_distance(points, "model", stroke.settings.radius)
        if why is not None:
            raise InvalidFeatureError(why)
    lengths = model.measure_distances(held) if len(held) else np.zeros(0)
    for number in np.flatnonzero(lengths > reach).tolist():
        x, y, z = held[number]
        raise InvalidFeatureError(
            f"constraint {number} at {x:.4g}, {y:.4g}, {z:.4g} is {lengths[number]:.4g} off the "
            f"model, and ribs reach {reach:.4g}; give a point on the feature"
        )


def find_held_samples(samples: Points, held: ArrayLike) -> tuple[Constraint, ...]:
    """Constraints: each of (c, 3) points at that of (m, 3) samples which is nearest to it."""
    points = as_points(held, "points to hold", InvalidFeatureError)
    if not len(points):
        return ()
    numbers = np.asarray(cdist(points, samples)).argmin(axis=1).tolist()
    taken: dict[int, int] = {}
    for k, number in enumerate(numbers):
        if number in taken:
            raise InvalidFeatureError(
                f"constraints {taken[number]} and {k} are at one sample of the curve, number "
                f"{number}; leave one of them out, or set them farther apart"
            )
        taken[number] = k
    return tuple((number, points[k]) for number, k in taken.items())


def measure_curve(model: Surface, stroke: Points, curve: FeatureCurve) -> Figures:
    """The figures of a curve whose stroke, laid onto the model, has the points (m, 3)."""
    spline = curve.spline
    at_samples = spline.evaluate(curve.parameters)
    along = spline.sample(DENSITY * len(curve.samples))
    return Figures(
        spline.length,
        Spread.of(measure_distances(stroke, spline, len(along))),
        Spread.of(np.linalg.norm(curve.samples - at_samples, axis=1)),
        Spread.of(model.measure_distances(along)),
    )


def measure_distances(points: Points, spline: Spline, count: int) -> NDArray[np.float64]:
    """(n,) distances of points (n, 3) from a curve, as a polyline of so many points."""
    along = spline.sample(count)
    start, step = along[:-1], np.diff(along, axis=0)
    size = np.maximum(np.einsum("kc,kc->k", step, step), np.finfo(np.float64).tiny)
    share = (points @ step.T - np.einsum("kc,kc->k", start, step)) / size
    feet = start + np.clip(share, 0.0, 1.0)[..., None] * step
    return np.linalg.norm(feet - points[:, None], axis=2).min(axis=1)
