"""How the fill of a hole is to lie: the request, and the choices with their help.

:func:`query.holes.fill_holes`, the options of the command line, batch files, the service, its
description and the page read :class:`CapRequest` and :data:`SHAPES`; no other list has them.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypedDict

from msgspec import Meta

from patterndb.system.documents import JsonModel
from query.errors import InvalidQueryError

Shape = Literal["auto", "flat", "smooth"]

#: The shapes that can be asked for, the default first, and what each does.
SHAPES: dict[Shape, str] = {
    "auto": "flat where the boundary is that of a cap, smooth elsewhere",
    "flat": "new vertices lie in the plane of the boundary",
    "smooth": "the surface goes on as it arrives",
}

#: The least tension, which is the default, and the greatest.
LEAST_TENSION, MOST_TENSION = 0.0, 1.0

Tension = Annotated[
    float,
    Meta(ge=LEAST_TENSION, le=MOST_TENSION, description="a number from 0 to 1"),
]


class CapOptions(TypedDict):
    """The keywords of :func:`query.holes.fill_holes` that a :class:`CapRequest` holds."""

    shape: Shape
    tension: float
    ngon: bool


class CapRequest(JsonModel):
    """How the fill of a hole is to lie.

    shape: one of SHAPES.
    tension: of fills that go on smoothly, how far every new vertex is moved from where it bends
        the surface least (0) straight to where the fill is a membrane, of the least sum of squared
        edges (1).
    ngon: one face of as many corners as the boundary has vertices, instead of quads.

    Raises InvalidQueryError for another shape, a tension out of its range, and entries that
    contradict each other.
    """

    shape: Shape = "auto"
    tension: Tension = LEAST_TENSION
    ngon: bool = False

    def __post_init__(self) -> None:
        if self.shape not in SHAPES:
            raise InvalidQueryError(f"shape is {self.shape!r}; choose one of {', '.join(SHAPES)}")
        if not (math.isfinite(self.tension) and LEAST_TENSION <= self.tension <= MOST_TENSION):
            raise InvalidQueryError(
                f"tension is {self.tension}; give a number from {LEAST_TENSION:g} to "
                f"{MOST_TENSION:g}"
            )
        if self.tension and self.shape == "flat":
            raise InvalidQueryError(
                "a flat fill has no tension to choose; leave tension or shape flat out"
            )
        if self.ngon and (self.tension or self.shape == "smooth"):
            raise InvalidQueryError(
                "an n-gon has no new vertices to place; leave tension and shape smooth out"
            )

    @property
    def cap_options(self) -> CapOptions:
        """The same as keywords of :func:`query.holes.fill_holes`."""
        return {"shape": self.shape, "tension": self.tension, "ngon": self.ngon}
