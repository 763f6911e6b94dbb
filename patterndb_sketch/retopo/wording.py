"""Write places and directions of a surface in words, alike in all notes and refusals."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

import numpy as np

from patterndb.geometry.points import Points

#: Places that a note names; of more it says how many there are.
MOST_PLACES = 3


def round_down(number: float, digits: int = 3) -> float:
    """Return a positive number with so many digits, not above it: a limit that may be typed."""
    return _round(number, digits, ROUND_FLOOR)


def round_up(number: float, digits: int = 3) -> float:
    """Return a positive number with so many digits, not below it: a limit that may be typed."""
    return _round(number, digits, ROUND_CEILING)


def _round(number: float, digits: int, way: str) -> float:
    exact = Decimal(number)
    return float(exact.quantize(Decimal(1).scaleb(exact.adjusted() + 1 - digits), rounding=way))


def format_place(point: Points | Sequence[float]) -> str:
    """Format a point (3,) as ``(x, y, z)``: close enough to be found, and to be pointed at by a
    call."""
    return "(" + ", ".join(f"{x + 0.0:.4g}" for x in np.asarray(point, np.float64)) + ")"


def count_places(one: str, many: str, points: Points) -> str:
    """Count things at points (n, 3), n >= 1, with their places: one is "a flipped quad", many
    are "flipped quads"."""
    what = one if len(points) == 1 else f"{len(points)} {many}"
    return f"{what} {list_places(points)}"


def list_places(points: Points) -> str:
    """List points (n, 3), n >= 1, after "at": all of a few, else the first ones."""
    said = [format_place(point) for point in points[:MOST_PLACES]]
    if len(points) > MOST_PLACES:
        return "at " + ", ".join(said) + f" and {len(points) - MOST_PLACES} more"
    return "at " + (", ".join(said[:-1]) + " and " if len(said) > 1 else "") + said[-1]
