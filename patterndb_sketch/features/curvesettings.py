"""The settings of curves as a session keeps them: numbers by name.

"alpha" is that of curves that have none of their own, "roof_rail: alpha" that of one curve.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.snap import SnapSettings

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
