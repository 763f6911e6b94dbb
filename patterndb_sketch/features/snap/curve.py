"""The curve on a feature that a sketched one moved to."""

from __future__ import annotations

from dataclasses import dataclass

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.snap.settings import SnapSettings
from patterndb_sketch.features.splines import Constraint, Spline


@dataclass(frozen=True, slots=True, eq=False)
class FeatureCurve:
    """A curve on a feature of a model.

    samples:     (m, 3) float64, where it was found: on the model, or where a rib bridges a gap on
                 that rib, off the model by less than 1.2 times the gap; its constraints at theirs.
    parameters:  (m,) float64, of the samples on the spline.
    constraints: numbers of samples and the points that the spline meets exactly there.
    repaired:    numbers of ribs that were put together from several segments.
    failed:      numbers of ribs without a contour, or with one of another surface alone: samples
                 there moved as those of their neighbours.
    ended:       numbers of ribs that were cut at an end: the feature may be farther off.
    notes:       what else is not as asked for.
    """

    spline: Spline
    samples: Points
    parameters: Floats
    constraints: tuple[Constraint, ...]
    settings: SnapSettings
    repaired: tuple[int, ...]
    failed: tuple[int, ...]
    ended: tuple[int, ...]
    notes: tuple[str, ...]
