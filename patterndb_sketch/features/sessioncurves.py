"""Curves out of a session and into it, and their settings as a session keeps them: numbers by name.

"alpha" is that of curves that have none of their own, "roof_rail: alpha" that of one curve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.sessionfile import FeatureSession, SessionCurve
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines import Constraint
from patterndb_sketch.features.strokes import FeatureStroke, RecoveredCurve

#

#: Settings that are one number each, whole numbers, and what the axis is written as. beta is in
#: degrees, strict 0 or 1.
NUMBERS = ("alpha", "stiffness", "theta", "window", "nearness", "radius")
WHOLE = ("degree", "n_samples", "rounds")
AXES = ("axis x", "axis y", "axis z")

#: Stands for a nearness without end, as JSON has none.
ENDLESS = 1e300


def settings_numbers(settings: SnapSettings) -> dict[str, float]:
    """All settings as numbers by name."""
    numbers = {name: float(getattr(settings, name)) for name in (*NUMBERS, *WHOLE)}
    numbers["nearness"] = min(numbers["nearness"], ENDLESS)
    numbers["strict"] = float(settings.strict)
    numbers["beta"] = float(np.rad2deg(settings.beta))
    return numbers | dict(zip(AXES, map(float, settings.axis), strict=True))


def own_numbers(name: str, settings: SnapSettings, usual: SnapSettings) -> dict[str, float]:
    """What the curve of this name has other than usual, with its name before each."""
    known = settings_numbers(usual)
    return {
        f"{name}: {key}": value
        for key, value in settings_numbers(settings).items()
        if value != known[key]
    }


def settings_of_numbers(
    numbers: Mapping[str, float], usual: SnapSettings, name: str | None = None
) -> SnapSettings:
    """The settings in a session's numbers, the usual ones for those that it does not have.

    name: of a curve, for what it has of its own. Raises InvalidFeatureError for numbers out of
    range.
    """
    prefix = "" if name is None else f"{name}: "
    known = settings_numbers(usual)
    of = {key: numbers.get(prefix + key, value) for key, value in known.items()}
    for key in WHOLE:
        if of[key] % 1:
            raise InvalidFeatureError(f"settings.{prefix}{key} is {of[key]}; give a whole number")
    # An angle that is not changed keeps its last digit.
    beta = usual.beta if of["beta"] == known["beta"] else float(np.deg2rad(of["beta"]))
    return SnapSettings(
        alpha=of["alpha"],
        axis=(of["axis x"], of["axis y"], of["axis z"]),
        beta=beta,
        stiffness=of["stiffness"],
        theta=of["theta"],
        strict=bool(of["strict"]),
        window=of["window"],
        nearness=np.inf if of["nearness"] >= ENDLESS else of["nearness"],
        degree=int(of["degree"]),
        radius=of["radius"],
        n_samples=int(of["n_samples"]),
        rounds=int(of["rounds"]),
    )


def session_strokes(
    session: FeatureSession, usual: SnapSettings
) -> list[tuple[FeatureStroke, tuple[Constraint, ...]]]:
    """What was clicked and what was dragged of every curve, with the curve's own settings, the
    usual ones where it has none.

    Raises InvalidFeatureError for settings out of range.
    """
    numbers = session.settings
    return [
        (
            FeatureStroke(
                one.name, one.clicked, settings=settings_of_numbers(numbers, usual, one.name)
            ),
            one.constraints,
        )
        for one in session.curves
    ]


def with_curves(
    session: FeatureSession, found: Sequence[RecoveredCurve], usual: SnapSettings
) -> FeatureSession:
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
