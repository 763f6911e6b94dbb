"""Colours of curves: strong enough to stand out from a grey model."""

from __future__ import annotations

#: After Okabe and Ito, as colour-blind readers can tell them apart, darker than theirs: lines
#: are thin. In the order of being drawn.
CURVES = (
    "#0b63b5",
    "#d1570c",
    "#08855f",
    "#b1478a",
    "#a87b00",
    "#6a48c8",
    "#2a93c4",
    "#a33238",
)


def colour_of(key: int) -> str:
    """The colour of a curve by its key: it keeps it while others come and go."""
    return CURVES[key % len(CURVES)]
