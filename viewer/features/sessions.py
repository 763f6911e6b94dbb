"""What is worked on, from a session and into one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from patterndb_sketch.features.sessioncurves import (
    own_numbers,
    settings_numbers,
    settings_of_numbers,
)
from patterndb_sketch.features.sessionfile import FeatureSession, SessionCurve
from patterndb_sketch.features.snap import SnapSettings
from viewer.features.edits import Curve, Look


def opened(
    session: FeatureSession, settings: SnapSettings
) -> tuple[list[tuple[Curve, Look]], SnapSettings]:
    """The curves of a session with their looks, and the settings of the next curve: the given
    ones where they are not as by default, else the session's.

    Raises InvalidFeatureError for settings out of range.
    """
    common = settings_of_numbers(session.settings, SnapSettings())
    curves: list[tuple[Curve, Look]] = []
    for key, one in enumerate(session.curves):
        own = settings_of_numbers(session.settings, common, one.name)
        curve = Curve(key, one.name, one.clicked, own, one.constraints)
        curves.append((curve, Look.of(one.spline, one.samples)))
    asked, usual = settings_numbers(settings), settings_numbers(SnapSettings())
    given = {name: value for name, value in asked.items() if value != usual[name]}
    return curves, settings_of_numbers(given, common)


def saved(
    session: FeatureSession, curves: Sequence[tuple[Curve, Look]], settings: SnapSettings
) -> FeatureSession:
    """The session with these curves, and the settings of the next one; all else stays."""
    common = settings_numbers(settings)
    gone = {f"{one.name}: {name}" for one in session.curves for name in common}
    numbers = {name: value for name, value in session.settings.items() if name not in gone}
    numbers |= common
    for curve, _ in curves:
        numbers |= own_numbers(curve.name, curve.settings, settings)
    drawn = tuple(
        SessionCurve(curve.name, curve.clicked, look.samples, curve.constraints, look.spline)
        for curve, look in curves
    )
    return replace(session, curves=drawn, settings=numbers)
