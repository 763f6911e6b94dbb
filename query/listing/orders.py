"""The orders in which fills are listed: one table for all who let one choose.

:func:`query.fills`, the option --order of the command line, the fill explorer and the tests read
:data:`ORDERS`; docs/queries.md and docs/definitions.md explain what stands here.

To add an order, write a function that measures a fill (see :data:`Measure`) and give it an entry in
:data:`ORDERS`: a name, what comes first, and what it needs. Nothing else has to know of it, and
tests/query/listing/test_orders.py finds it. Two entries have no measure: "artist" and "regular" are
ranks that fits have before they are expanded (:mod:`query.listing.matches`). All others sort the
first fills of "artist" (``pool`` of :func:`query.fills`).

Nothing here waits for solvers until a fill is measured: a command line's --help reads it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from query.boundary import Boundary
    from query.fill import Fill
    from query.stroke import Stroke

#: (fill, boundary, strokes, tolerance) -> (a number, the fill): fills come by the number, smallest
#: first, equal ones as the order "artist" has them. The fill may be told what was found.
Measure = Callable[["Fill", "Boundary", "Sequence[Stroke]", int], "tuple[float, Fill]"]

#: (boundary, strokes) -> a difference of what is measured that nobody sees.
Alike = Callable[["Boundary", "Sequence[Stroke]"], float]


@dataclass(frozen=True, slots=True)
class FillOrder:
    """An order of fills.

    name:    what it is asked for by.
    first:   what comes first, as one reads it after "what comes first: ".
    then:    what decides between equals, for the docs; "" where it is the order "artist".
    measure: what it sorts by; None for ranks that need no fill to be made.
    needs_points: must the boundary have points?
    needs_strokes: must a stroke have points, too?
    alike:   how much more than the best a fill may measure and still count as equal, so that of
             those the more regular come first; None for not at all.
    """

    name: str
    first: str
    measure: Measure | None = None
    needs_points: bool = False
    needs_strokes: bool = False
    then: str = ""
    alike: Alike | None = None

    def is_usable(self, *, points: bool, strokes: bool) -> bool:
        """Can fills be listed so, where the boundary has points, and a stroke has?"""
        return (points or not self.needs_points) and (strokes or not self.needs_strokes)

    @property
    def needs(self) -> str:
        """What it needs, in words; empty if nothing."""
        if not self.needs_points:
            return ""
        return "points of the boundary" + (" and of a stroke" if self.needs_strokes else "")


def measure_flow(
    fill: Fill, boundary: Boundary, strokes: Sequence[Stroke], tolerance: int
) -> tuple[float, Fill]:
    """Measure the distance of the strokes to their strands, after a first placing.

    Source: Marcias et al. 2015, section 4, "Sorting".
    """
    from query.placing.flow import measure_flow_distance
    from query.placing.laplace import lay_flat

    assert boundary.points is not None, "the order needs points"
    drawn = [stroke for stroke in strokes if stroke.points is not None]
    distance = measure_flow_distance(fill, lay_flat(fill, boundary.points), drawn, tolerance)
    return distance, replace(fill, flow_distance=distance)


#: Strands whose mean distances from the strokes differ by so many edges are equally near: placing
#: pulls either onto them.
EQUALLY_NEAR = 0.25


def allow_in_flow(boundary: Boundary, strokes: Sequence[Stroke]) -> float:
    """Give the difference of :func:`measure_flow` up to which strands are about equally near.

    It is a part of a mean edge of the boundary, over the length of all strokes.
    """
    import numpy as np

    from patterndb.geometry.polyline import arc_length

    assert boundary.points is not None, "the order needs points"
    ring = np.concatenate([boundary.points, boundary.points[:1]])
    edge = float(arc_length(ring)[-1]) / boundary.perimeter
    drawn = [(s.points, s.is_loop) for s in strokes if s.points is not None]
    lines = [np.concatenate([at, at[:1]]) if is_loop else at for at, is_loop in drawn]
    return EQUALLY_NEAR * edge * sum(float(arc_length(line)[-1]) for line in lines)


def measure_angles(
    fill: Fill, boundary: Boundary, strokes: Sequence[Stroke], tolerance: int
) -> tuple[float, Fill]:
    """Measure the squared deviation of the quads' angles from 90 degrees, after a first placing."""
    from patterndb.geometry.quadshape import quality
    from query.placing.laplace import lay_flat

    assert boundary.points is not None, "the order needs points"
    return quality(fill.quads, lay_flat(fill, boundary.points)), fill


def measure_fit(
    fill: Fill, boundary: Boundary, strokes: Sequence[Stroke], tolerance: int
) -> tuple[float, Fill]:
    """Judge the whole as for holes: what artists did, how regular it is, how it lies in space."""
    from query.holes.models import shipped_models
    from query.holes.ranking import measure_plain_fill

    assert boundary.points is not None, "the order needs points"
    numbers = measure_plain_fill(fill, boundary.points)
    return -float(shipped_models().plain.score(numbers[None])[0]), fill


def measure_size(
    fill: Fill, boundary: Boundary, strokes: Sequence[Stroke], tolerance: int
) -> tuple[float, Fill]:
    """Count the quads."""
    return float(fill.n_quads), fill


def measure_symmetry(
    fill: Fill, boundary: Boundary, strokes: Sequence[Stroke], tolerance: int
) -> tuple[float, Fill]:
    """Count the symmetries of the boundary that the fill has too, below 0: the most come first."""
    from query.recognition import count_symmetries

    return -float(count_symmetries(fill, boundary)), fill


#: All orders by name, as they are shown.
ORDERS: dict[str, FillOrder] = {
    order.name: order
    for order in (
        FillOrder("artist", "what artists did most"),
        FillOrder(
            "regular",
            "the fewest irregular vertices",
            then="the fewest of them on the boundary, then the pattern seen most",
        ),
        FillOrder(
            "flow",
            "the strands nearest to the strokes",
            measure_flow,
            True,
            True,
            then="of strands about equally near, the fewest irregular vertices",
            alike=allow_in_flow,
        ),
        FillOrder("fit", "what artists did most in such a shape", measure_fit, True),
        FillOrder("quality", "the squarest quads", measure_angles, True),
        FillOrder("small", "the fewest quads", measure_size),
        FillOrder("symmetric", "the most symmetries", measure_symmetry),
    )
}


def default_order(*, points: bool, drawn: bool) -> str:
    """The order where none is asked for. points: has the boundary points? drawn: have it and a
    stroke?"""
    return "flow" if drawn else "fit" if points else "artist"


def describe_orders() -> str:
    """What comes first in every order, in a sentence's words, and which is the default."""
    first = [order.first for order in ORDERS.values()]
    return (
        f"What comes first: {', '.join(first[:-1])}, or {first[-1]}.  [default: "
        f"{default_order(points=True, drawn=True)} where strokes are drawn, "
        f"{default_order(points=True, drawn=False)} where the boundary has points, else "
        f"{default_order(points=False, drawn=False)}]"
    )
