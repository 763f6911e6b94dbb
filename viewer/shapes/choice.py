"""What of a shape can be chosen, and taken back step by step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.shapemodel.edit import STIFFNESS
from viewer.shapes.skin import Line

#: How far sliders go, in standard deviations: 997 of 1000 normally distributed shapes are within.
SIGMAS = 3.0

#: What a held curve weighs, least and most: a thousandth, and a hundred times, what is pulled.
HOLD = (1e-3, 100.0)

#: What leaving the present shape costs, least and most: from what decides only where nothing
#: else does to what hardly moves.
STIFF = (1e-4, 1.0)

#: And at first: more than :func:`patterndb_sketch.features.shapemodel.edit` takes by default. Pulls are
#: followed as nearly, and what nobody pulls swings less.
KEEP = 10.0 * STIFFNESS


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """All that can be taken back step by step.

    coefficients: (l,) of the shape. origin: how it came about. held: names of the features that
    pulls of others shall leave where they are. hold: the weight of those. stiffness: what it
    costs to leave the present shape; both as for :func:`patterndb_sketch.features.shapemodel.edit`.
    """

    coefficients: Floats
    origin: str
    held: frozenset[str] = frozenset()
    hold: float = 1.0
    stiffness: float = KEEP

    def is_like(self, other: Choice) -> bool:
        """Is nothing different?"""
        return np.array_equal(self.coefficients, other.coefficients) and (
            self.held,
            self.hold,
            self.stiffness,
        ) == (other.held, other.hold, other.stiffness)


@dataclass(frozen=True, slots=True, eq=False)
class Pulled:
    """The last pull.

    line: what was pulled. wanted: (n, 3) where its vertices should be. miss: the greatest
    distance from there.
    """

    line: Line
    wanted: Points = field(repr=False)
    miss: float
