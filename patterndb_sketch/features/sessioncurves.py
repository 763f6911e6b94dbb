"""Curves out of a session and into it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from patterndb_sketch.features.curvesettings import (
    own_numbers,
    settings_numbers,
    settings_of_numbers,
)
from patterndb_sketch.features.sessionfile import Session, SessionCurve
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines import Constraint
from patterndb_sketch.features.strokes import RecoveredCurve, Stroke


def session_strokes(
    session: Session, usual: SnapSettings
) -> list[tuple[Stroke, tuple[Constraint, ...]]]:
    """What was clicked and what was dragged of every curve, with the curve's own settings, the
    usual ones where it has none.

    Raises InvalidFeatureError for settings out of range.
    """
    numbers = session.settings
    return [
        (
            Stroke(one.name, one.clicked, settings=settings_of_numbers(numbers, usual, one.name)),
            one.constraints,
        )
        for one in session.curves
    ]


def with_curves(session: Session, found: Sequence[RecoveredCurve], usual: SnapSettings) -> Session:
    """The session with curves in place of those of their names, or after them.

    usual: the settings that the session has from now on for all curves.
    """
    before = settings_of_numbers(session.settings, SnapSettings())
    numbers = dict(session.settings) | settings_numbers(usual)
    curves: dict[str, SessionCurve] = {}
    for one in session.curves:
        # Curves that stay have the settings that they had, whatever the others have now.
        own = settings_of_numbers(session.settings, before, one.name)
        numbers = _with_own(numbers, one.name, own, usual)
        curves[one.name] = one
    for one in found:
        curve = one.curve
        numbers = _with_own(numbers, one.name, curve.settings, usual)
        curves[one.name] = SessionCurve(
            one.name, one.stroke, curve.samples, curve.constraints, curve.spline
        )
    return replace(session, curves=tuple(curves.values()), settings=numbers)


def _with_own(
    numbers: dict[str, float], name: str, own: SnapSettings, usual: SnapSettings
) -> dict[str, float]:
    old = {f"{name}: {key}" for key in settings_numbers(usual)}
    kept = {key: value for key, value in numbers.items() if key not in old}
    return kept | own_numbers(name, own, usual)
