"""Where things stand in the panel: rows of curves, sliders, and what is chosen by a click."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.splines.spline import MAX_DEGREE
from viewer.panel import MARGIN, PANEL
from viewer.scene import HEIGHT
from viewer.slider import Rail, Slider, find_rail

#: The list of curves: its first row's middle, the height of a row, and how many rows there are.
FIRST_ROW = HEIGHT - 92.0
ROW = 24.0
ROWS = 8

#: Heights of the sliders' lines, and of the row of choices below them.
TOP_SLIDER = FIRST_ROW - ROWS * ROW - 44.0
BETWEEN = 66.0
CHOICES = TOP_SLIDER - 3.0 * BETWEEN + 2.0

#: Where the facts of a curve begin.
FACTS = CHOICES - 44.0

#: Half the size of a choice, and the middles of those of the row from the panel's left.
HALF_CHOICE = (14.0, 12.0)
AXES = {axis: MARGIN + 50.0 + 31.0 * i for i, axis in enumerate("xyz")}
DEGREE = {-1: PANEL - MARGIN - 68.0, 1: PANEL - MARGIN - 14.0}

#: Unit vectors by name.
AXIS_OF = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

#: The least and the greatest degree.
DEGREES = (1, MAX_DEGREE)

_ENDS = MARGIN + 6.0, PANEL - MARGIN - 6.0

#: The sliders by what they change, x from the panel's left.
RAILS = {
    "alpha": Rail(Slider("alpha", 0.0, 1.0, 0.01, ends=("angle of normals", "bends")), *_ENDS, 0.0),
    "stiffness": Rail(
        Slider("stiffness", 1.0, 100.0, digits=3, ends=("follows all", "goes straight")),
        *_ENDS,
        -BETWEEN,
    ),
    "angle": Rail(Slider("isophote angle", 0.0, 180.0, 1.0, unit="°"), *_ENDS, -2.0 * BETWEEN),
}


def place_rails(left: float) -> dict[str, Rail]:
    """Place the sliders in a panel that begins at x = left, in points of the picture."""
    return {name: rail.shifted(left, TOP_SLIDER) for name, rail in RAILS.items()}


def find_slider(left: float, x: float, y: float) -> str | None:
    """Find the slider at a place of the picture."""
    return find_rail(place_rails(left), x, y)


def find_row(left: float, x: float, y: float) -> int | None:
    """Find the row of the list at a place of the picture, from 0."""
    row = int((FIRST_ROW + ROW / 2.0 - y) // ROW)
    inside = left + MARGIN / 2.0 <= x <= left + PANEL - MARGIN / 2.0
    return row if inside and 0 <= row < ROWS else None


def find_choice(left: float, x: float, y: float) -> str | int | None:
    """Find the axis, or by how much the degree is changed, at a place of the picture."""
    if abs(y - CHOICES) > HALF_CHOICE[1]:
        return None
    for choice, at in (*AXES.items(), *DEGREE.items()):
        if abs(x - left - at) <= HALF_CHOICE[0]:
            return choice
    return None


def choose_rows(count: int, selected: int | None) -> range:
    """Choose which of so many curves the list has, with the selected one among them."""
    first = 0
    if count > ROWS:
        middle = count - 1 if selected is None else selected
        first = min(max(middle - ROWS // 2, 0), count - ROWS)
    return range(first, min(first + ROWS, count))


def get_slider_value(settings: SnapSettings, name: str) -> float:
    """Get what a slider shows of the settings."""
    if name == "angle":
        return float(np.rad2deg(settings.beta))
    return float(getattr(settings, name))


def name_axis(settings: SnapSettings) -> str | None:
    """Name the axis of the settings, None if it is another direction."""
    return next((name for name, axis in AXIS_OF.items() if axis == settings.axis), None)
