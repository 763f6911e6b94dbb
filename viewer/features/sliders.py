"""What sliders and keys change of a curve's settings: numbers, the axis, the degree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines.spline import MAX_DEGREE
from viewer.slider import Slider

#: Unit vectors by name.
AXIS_OF = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

#: The least and the greatest degree.
DEGREES = (1, MAX_DEGREE)

#: The sliders by what they change.
SLIDERS = {
    "alpha": Slider("alpha", 0.0, 1.0, 0.01, ends=("angle of normals", "bends")),
    "stiffness": Slider("stiffness", 1.0, 100.0, digits=3, ends=("follows all", "goes straight")),
    "angle": Slider("isophote angle", 0.0, 180.0, 1.0, unit="°"),
}


def get_slider_value(settings: SnapSettings, name: str) -> float:
    """Get what a slider shows of the settings."""
    if name == "angle":
        return float(np.rad2deg(settings.beta))
    return float(getattr(settings, name))


def replace_value(settings: SnapSettings, name: str, value: float) -> SnapSettings:
    """Replace a value of the settings by that which a slider was moved to."""
    if name == "angle":
        return replace(settings, beta=float(np.deg2rad(value)))
    if name == "alpha":
        return replace(settings, alpha=value)
    return replace(settings, stiffness=value)


def name_axis(settings: SnapSettings) -> str | None:
    """Name the axis of the settings, None if it is another direction."""
    return next((name for name, axis in AXIS_OF.items() if axis == settings.axis), None)
