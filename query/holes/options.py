"""What can be asked about the fills of a hole, besides which hole.

:class:`HoleRequest` has the options that a text can hold: the command line, batch files, the
service, its description and the page read it. :class:`HoleOptions` adds what only a program has.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from msgspec import Meta

from patterndb.system.numbers import MOST_EDGES, TOLERANCE
from patterndb.system.requests import Positive, Request, Seconds, Threads, option
from query.errors import InvalidQueryError

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from query.holes.fills import HoleFill
    from query.stroke import Stroke
else:
    # These need not be imported to read options.
    Surface = HoleFill = Stroke = Any

Shape = Literal["auto", "flat", "smooth"]

#: The shapes that can be asked for, the default first, and what each does.
SHAPES: dict[Shape, str] = {
    "auto": "flat where the boundary is that of a cap, smooth elsewhere",
    "flat": "new vertices lie in the plane of the boundary",
    "smooth": "the surface goes on as it arrives",
}

#: Fills of a hole that are listed by default.
LISTED = 20

#: The least tension, which is the default, and the greatest.
LEAST_TENSION, MOST_TENSION = 0.0, 1.0

Tension = Annotated[
    float,
    Meta(ge=LEAST_TENSION, le=MOST_TENSION, description="a number from 0 to 1"),
]


class HoleRequest(Request, frozen=True, kw_only=True):
    """How a hole is to be filled, and how many fills are listed.

    Raises InvalidQueryError for options that contradict each other.
    """

    error = InvalidQueryError

    limit: Annotated[Positive | None, option("List at most K fills of a hole.", metavar="K")] = (
        LISTED
    )
    twins: Annotated[
        bool,
        option(
            "Do not copy the other side of a mesh that is symmetric.",
            flag="--no-twin",
            constant=False,
            hint="give True or False",
            section="what",
        ),
    ] = True
    ngon: Annotated[
        bool,
        option(
            "One face of as many corners as the hole has vertices, instead of quads.",
            hint="give True or False",
            section="what",
        ),
    ] = False
    shape: Annotated[
        Shape,
        option(
            "How it lies. " + "; ".join(f"{name}: {what}" for name, what in SHAPES.items()) + ".",
            hint=f"choose one of {', '.join(SHAPES)}",
            section="shape",
        ),
    ] = "auto"
    tension: Annotated[
        Tension,
        option(
            "How tight a smooth fill is: from 0, it bends least, to 1, it is a membrane.",
            metavar="T",
            hint=f"give a number from {LEAST_TENSION:g} to {MOST_TENSION:g}",
            section="shape",
        ),
    ] = LEAST_TENSION
    time_limit: Annotated[
        Seconds | None,
        option(
            "Stop after this many seconds, with what was found.",
            metavar="SECONDS",
            hint="give seconds above 0, at most 1,000,000",
        ),
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tension and self.shape == "flat":
            raise InvalidQueryError(
                "a flat fill has no tension to choose; leave tension or shape flat out"
            )
        if self.ngon and (self.tension or self.shape == "smooth"):
            raise InvalidQueryError(
                "an n-gon has no new vertices to place; leave tension and shape smooth out"
            )

    @property
    def is_laid(self) -> bool:
        """Did the caller choose how fills lie?"""
        return self.shape != "auto" or self.tension > 0


class HoleOptions(HoleRequest, frozen=True, kw_only=True):
    """How a hole is to be filled.

    limit: the most fills; None is no limit.
    twins: is a mirror image of the other side of the mesh listed first?
    ngon: one face of as many corners as the boundary has vertices, instead of quads.
    shape: one of SHAPES. A mirror image lies as the other side does unless a shape or a tension is
        chosen.
    tension: of fills that go on smoothly, how far every new vertex is moved from where it bends
        the surface least (0) straight to where the fill is a membrane, of the least sum of squared
        edges (1).
    time_limit: seconds after which the list ends; so does an earlier deadline of the thread that
        begins it (:mod:`patterndb.system.deadline`). A list that is still empty then has the best
        fill that was found by then, if there is one.
    corners: for loop vertices of the mesh, the quads within that the caller fixes, 1 to 4.
    strokes: strands that every fill must have; their ends are edges of side 0 of the loop, from
        the hole's first vertex. Strands are pulled onto those that have points.
    tolerance: edges by which a strand's end may miss the stroke's end.
    surface: new vertices come to rest on the part of it that the loop encloses, or, where the loop
        does not lie on it, are moved to its nearest points.
    like: fills of other holes of the mesh. Where the hole is the mirror image of one of theirs, the
        same fill comes first, mirrored; where the mesh is nearly symmetric, it is placed again.
    threads: threads of each query, at most; by default one a processor.

    Raises InvalidQueryError for options that contradict each other.
    """

    corners: Mapping[int, int] = {}
    strokes: Annotated[
        tuple[Stroke, ...], option("Strands that every fill has, each another one.")
    ] = ()
    tolerance: Annotated[
        Annotated[int, Meta(ge=0, le=MOST_EDGES, description="a whole number from 0")],
        option(
            "Edges by which strands may miss the strokes' ends.",
            metavar="K",
            hint="0 asks for exact strokes",
        ),
    ] = TOLERANCE
    surface: Surface | None = None
    like: Annotated[tuple[HoleFill, ...], option("Fills of other holes of the mesh.")] = ()
    threads: Annotated[
        Threads | None, option("Threads; one a core.", flag="--jobs", metavar="N")
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.surface is not None and (self.shape == "flat" or self.tension):
            raise InvalidQueryError(
                "new vertices lie on the surface that is given; leave shape flat and tension out"
            )
        if self.ngon and (self.corners or self.strokes or self.surface is not None):
            raise InvalidQueryError("an n-gon has no quads; leave corners, strokes and surface out")
