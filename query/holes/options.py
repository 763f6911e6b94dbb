"""What can be asked about the fills of a hole, besides which hole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from patterndb.system.numbers import TOLERANCE
from query.caprequest import LEAST_TENSION, CapRequest, Shape
from query.errors import InvalidQueryError
from query.stroke import Stroke

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from query.holes.fills import HoleFill


def _no_corners() -> dict[int, int]:
    return {}


@dataclass(frozen=True, slots=True, kw_only=True)
class HoleOptions:
    """How a hole is to be filled.

    limit: the most fills; None is no limit.
    corners: for loop vertices of the mesh, the quads within that the caller fixes, 1 to 4.
    strokes: strands that every fill must have; their ends are edges of side 0 of the loop, from
        the hole's first vertex. Strands are pulled onto those that have points.
    tolerance: edges by which a strand's end may miss the stroke's end.
    surface: new vertices come to rest on the part of it that the loop encloses, or, where the loop
        does not lie on it, are moved to its nearest points.
    twins: is a mirror image of the other side of the mesh listed first?
    like: fills of other holes of the mesh. Where the hole is the mirror image of one of theirs, the
        same fill comes first, mirrored; where the mesh is nearly symmetric, it is placed again.
    shape, tension, ngon: how the fill is to lie; see :class:`query.caprequest.CapRequest`. A mirror
        image lies as the other side does unless a shape or a tension is chosen.
    time_limit: seconds after which the list ends; so does an earlier deadline of the thread that
        begins it (:mod:`patterndb.system.deadline`). A list that is still empty then has the best
        fill that was found by then, if there is one.
    threads: threads of each query, at most; by default one a processor.

    Raises InvalidQueryError for options that contradict each other.
    """

    limit: int | None = 20
    corners: Mapping[int, int] = field(default_factory=_no_corners)
    strokes: Sequence[Stroke] = ()
    tolerance: int = TOLERANCE
    surface: Surface | None = None
    twins: bool = True
    like: Sequence[HoleFill] = ()
    shape: Shape = "auto"
    tension: float = LEAST_TENSION
    ngon: bool = False
    time_limit: float | None = None
    threads: int | None = None

    def __post_init__(self) -> None:
        CapRequest(shape=self.shape, tension=self.tension, ngon=self.ngon)
        if self.surface is not None and (self.shape == "flat" or self.tension):
            raise InvalidQueryError(
                "new vertices lie on the surface that is given; leave shape flat and tension out"
            )
        if self.ngon and (self.corners or self.strokes or self.surface is not None):
            raise InvalidQueryError("an n-gon has no quads; leave corners, strokes and surface out")
