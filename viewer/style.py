"""Colours and shapes that mean the same in every picture, sheet and window.

Valence colours are from Okabe and Ito's palette, which colour-blind readers can tell
apart; the shape says it a second time (a triangle for 3, a pentagon for 5).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

PAPER = "#ffffff"
QUAD = "#fdfcf9"
EDGE = "#5b6472"
BOUNDARY = "#1f2733"
TEXT = "#1f2733"
FAINT_TEXT = "#6d7683"
SELECTED = "#e4487f"
STROKE = "#8a3ffc"
MESSAGE = "#b3124c"

#: The two strands of quads that cross under the pointer.
STRANDS = ("#0b8a7d", "#b45a0b")

#: Soft tints for polychords, told apart in this order.
TINTS = (
    "#9cc3e6",
    "#f6c08a",
    "#a6d3a2",
    "#cbb2e0",
    "#f2e08e",
    "#90d3ce",
    "#f2b2c1",
    "#cfc0aa",
)

VALENCE_COLOURS = {
    2: "#56b4e9",
    3: "#0072b2",
    5: "#d55e00",
    6: "#cc79a7",
    7: "#111111",
    8: "#009e73",
    9: "#b8860b",
    10: "#7b3294",
    11: "#8c510a",
    12: "#b3124c",
}

#: The least valence that is drawn as a star, of so many points.
STAR = 7


def choose_valence_colour(valence: int) -> str:
    """Choose the colour of a valence: beyond the last of them, stars differ by their points."""
    return VALENCE_COLOURS[min(max(valence, 2), max(VALENCE_COLOURS))]


def choose_valence_shape(valence: int) -> Points:
    """Choose (n, 2) float64 outline of a valence's marker, about the unit circle's size."""
    if valence <= 2:
        return make_circle()
    if valence >= STAR:
        return _star(valence)
    # A triangle of the same radius looks smaller than the rounder shapes.
    return _regular(valence) * (1.22 if valence == 3 else 1.06)


def make_circle() -> Points:
    """Make (24, 2) float64 the marker of a convex corner, and of valence 2."""
    return _regular(24)


def make_diamond() -> Points:
    """Make (4, 2) float64 the marker of a reflex corner."""
    return _regular(4)


def parse_colour(colour: str) -> NDArray[np.float64]:
    """Parse (3,) float64 red, green and blue of "#rrggbb", each 0 to 1."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def _regular(n: int) -> Points:
    angle = 2.0 * math.pi * np.arange(n) / n + math.pi / 2.0
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _star(n: int) -> Points:
    radius = np.where(np.arange(2 * n) % 2, 0.62, 1.25)
    return _regular(2 * n) * radius[:, None]


#: After Okabe and Ito, as colour-blind readers can tell them apart, darker than theirs: lines
#: are thin. In the order of being drawn.
CURVE_COLOURS = (
    "#0b63b5",
    "#d1570c",
    "#08855f",
    "#b1478a",
    "#a87b00",
    "#6a48c8",
    "#2a93c4",
    "#a33238",
)


def choose_curve_colour(key: int) -> str:
    """Choose the colour of a curve by its key: it keeps it while others come and go."""
    return CURVE_COLOURS[key % len(CURVE_COLOURS)]
