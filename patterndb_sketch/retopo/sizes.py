"""How far the tools reach, and how finely curves are sampled: lengths in the surface's unit."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from patterndb_sketch.retopo.errors import InvalidRetopoError

#: The lengths below as parts of the surface's diagonal. Source: the released program of
#: Takayama et al. 2013, whose sizes at its first view are these; the target edge, which the
#: program gives in other words, is about that of its examples.
SNAP = 0.02
SPINE = 0.06
AUTOCOMPLETION = 0.08
BRUSH = 0.06
EDGE = 0.03
SAMPLING = 0.002

#: The snap radius is at most this part of the brush in use: what is snapped lies under it.
UNDER_THE_BRUSH = 0.9


@dataclass(frozen=True, slots=True)
class Sizes:
    """Lengths, in the surface's unit; with ``dataclasses.replace`` for another brush.

    snap:           radius within which ends of strokes find a target.
    spine:          half-width of the spine's brush.
    autocompletion: radius that suggestions are made in.
    brush:          radius of the vertex brush.
    edge:           target length of the quads' edges.
    sampling:       distance of neighbouring points of a curve.

    Raises InvalidRetopoError for one that is not above 0.
    """

    snap: float
    spine: float
    autocompletion: float
    brush: float
    edge: float
    sampling: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0.0):
                raise InvalidRetopoError(f"the size {field.name} is {value}; give a length above 0")

    @classmethod
    def of(cls, diagonal: float) -> Sizes:
        """The defaults for a surface whose box has this diagonal."""
        if not (math.isfinite(diagonal) and diagonal > 0.0):
            raise InvalidRetopoError(f"the surface's diagonal is {diagonal}; it must be above 0")
        return cls(
            snap=SNAP * diagonal,
            spine=SPINE * diagonal,
            autocompletion=AUTOCOMPLETION * diagonal,
            brush=BRUSH * diagonal,
            edge=EDGE * diagonal,
            sampling=SAMPLING * diagonal,
        )

    def snap_within(self, brush: float) -> float:
        """The snap radius while a brush of this radius is in use."""
        return min(self.snap, UNDER_THE_BRUSH * brush)
