"""What the user has asked for: curves, each with its clicks, its pins and its settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.session import FeatureSession, SessionCurve
from patterndb_sketch.features.snap import FeatureCurve, Snap, SnapSettings
from patterndb_sketch.features.splines import Constraint, Spline
from patterndb_sketch.features.strokes import find_held_samples


def open_session_curves(
    session: FeatureSession, settings: SnapSettings, first: int = 0
) -> tuple[list[tuple[DrawnCurve, CurveLook]], SnapSettings]:
    """The curves of a session with their looks, and the settings of the next curve: the given
    ones where they are not as by default, else the session's.

    first: the first curve's key, from which the others count on.
    """
    curves: list[tuple[DrawnCurve, CurveLook]] = []
    for key, one in enumerate(session.curves, first):
        curve = DrawnCurve(
            key, one.name, one.clicked, one.settings, one.constraints, closed=one.spline.closed
        )
        curves.append((curve, CurveLook.of(one.spline, one.samples)))
    return curves, replace(session.settings, **settings.list_differences(SnapSettings()))


def collect_session(
    session: FeatureSession, curves: Sequence[tuple[DrawnCurve, CurveLook]], settings: SnapSettings
) -> FeatureSession:
    """Collect a session: these curves, and the settings of the next one; all else stays."""
    drawn = tuple(
        SessionCurve(
            curve.name, curve.clicked, look.samples, curve.constraints, look.spline, curve.settings
        )
        for curve, look in curves
    )
    return replace(session, curves=drawn, settings=settings)


#: Points that a curve is drawn through, for each of its samples.
DENSITY = 3


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class DrawnCurve:
    """A curve as it is asked for; an edited one is another object.

    key:      stays when a curve is edited. name: which the user gives.
    clicked:  (c, 3) float64, on the model. constraints: samples that are pinned, and where.
    again:    further rounds of snapping that were asked for.
    closed:   does it go on from the last click to the first?
    """

    key: int
    name: str
    clicked: Points
    settings: SnapSettings
    constraints: tuple[Constraint, ...] = ()
    again: int = 0
    closed: bool = False

    def pinned(self, sample: int, point: Points) -> DrawnCurve:
        """With a sample pinned to a point (3,), wherever it was before."""
        others = [one for one in self.constraints if one[0] != sample]
        pins = sorted([*others, (sample, point)], key=lambda one: one[0])
        return replace(self, constraints=tuple(pins))

    def turned(self, model: Surface) -> DrawnCurve:
        """Closed if it was open, and open if it was closed.

        Pins stay where they are, at the samples that are nearest to them then.

        Raises InvalidFeatureError for fewer than three clicks, and for pins at one sample.
        """
        closed = not self.closed
        samples = find_initial_curve(model, self.clicked, closed=closed).samples
        pins = np.array([point for _, point in self.constraints]).reshape(-1, 3)
        held = sorted(find_held_samples(samples, pins), key=lambda one: one[0])
        return replace(self, closed=closed, constraints=tuple(held))

    def unpinned(self, sample: int) -> DrawnCurve:
        """With a sample free again."""
        kept = tuple(one for one in self.constraints if one[0] != sample)
        return replace(self, constraints=kept)


@dataclass(frozen=True, slots=True, eq=False)
class CurveLook:
    """What was made of a curve, as far as it is shown.

    line: (k, 3) float64, points along the spline. samples: (m, 3), where it was found.
    repaired, failed, ended, notes: as of :class:`patterndb_sketch.features.snap.FeatureCurve`;
    None for a curve that was read from a file, which does not know them.
    """

    spline: Spline
    samples: Points
    line: Points
    found: FeatureCurve | None

    @classmethod
    def of(cls, spline: Spline, samples: Points, found: FeatureCurve | None = None) -> CurveLook:
        """Of a spline and the samples that it was fitted to."""
        at = np.linspace(*spline.domain, DENSITY * len(samples))
        return cls(spline, samples, spline.evaluate(at), found)


@dataclass(frozen=True, slots=True, eq=False)
class FeatureEdits:
    """All curves, in the order in which they were drawn."""

    curves: tuple[DrawnCurve, ...] = ()

    def find(self, key: int | None) -> DrawnCurve | None:
        """The curve with a key."""
        return next((one for one in self.curves if one.key == key), None)

    def with_curve(self, curve: DrawnCurve) -> FeatureEdits:
        """With a curve in place of that of its key, or as the last."""
        if self.find(curve.key) is None:
            return FeatureEdits((*self.curves, curve))
        return FeatureEdits(tuple(curve if one.key == curve.key else one for one in self.curves))

    def without(self, key: int) -> FeatureEdits:
        """Without the curve of a key."""
        return FeatureEdits(tuple(one for one in self.curves if one.key != key))

    def free_name(self) -> str:
        """A name that no curve has."""
        names = {one.name for one in self.curves}
        count = len(names) + 1
        while f"curve {count}" in names:
            count += 1
        return f"curve {count}"


def snap_curve(
    model: Surface, wanted: DrawnCurve, before: DrawnCurve | None, known: Snap | None
) -> Snap:
    """Snap a curve, as far as that is needed after what it was before.

    before: the curve that it was edited from, None if it is new. known: what that one snapped
    to, if that is still known; else it is snapped anew. So is a curve with other clicks, one that
    was closed or opened, or one without a pin of before: ribs follow a curve to its pins, but not
    back.

    Raises as :meth:`patterndb_sketch.features.snap.Snap.begin` does.
    """
    if before is None or _freed(before, wanted):
        snapped = Snap.begin(
            model, wanted.clicked, wanted.settings, wanted.constraints, closed=wanted.closed
        )
        return snapped.again(wanted.again)
    if known is None:
        known = Snap.begin(
            model, before.clicked, before.settings, before.constraints, closed=before.closed
        )
        known = known.again(before.again)
    if wanted.settings != known.settings:
        known = known.with_settings(wanted.settings)
    if wanted.constraints is not before.constraints:
        known = known.with_constraints(wanted.constraints)
    return known.again(wanted.again - before.again)


def _freed(before: DrawnCurve, after: DrawnCurve) -> bool:
    """Are the clicks others, is it closed or opened, or is a sample no more pinned?"""
    pinned = {number for number, _ in after.constraints}
    free = any(number not in pinned for number, _ in before.constraints)
    other = before.closed != after.closed or not np.array_equal(before.clicked, after.clicked)
    return free or other
