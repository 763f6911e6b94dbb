"""Networks from curves as drawn: where they meet is found, and they are cut there.

Places that meet (see :mod:`patterndb_sketch.surfacing.joining.meetings`) become one node, and so do
neighbours on a curve that are no further apart than the tolerance:

- ends that meet become one node, at their mean;
- an end that meets another curve on its way moves onto it, and cuts it there;
- curves that cross, or pass within the tolerance, are cut both, as is a curve that crosses itself;
- what a curve has beyond its last node, no longer than the tolerance, is an overshoot and is
  left out; so is a piece that returns to its node within two tolerances;
- of pieces that run from the same node to the same node within two tolerances of each other all
  but one are left out: that of the longest curve stays;
- a curve whose two ends meet each other alone is closed, and is cut where others meet it alone.

What curves move by to reach their nodes is spread along their pieces. What is left out is told.
The result does not depend on the order and the senses in which the curves are given.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.surfacing.errors import InvalidNetworkError
from patterndb_sketch.surfacing.joining.cutting import find_cuts, find_nodes, in_order, part_of
from patterndb_sketch.surfacing.joining.pieces import Piece, close, copied, numbered
from patterndb_sketch.surfacing.joining.polylines import SAME_PLACE, as_curve, bent, diagonal_of
from patterndb_sketch.surfacing.naming import Step
from patterndb_sketch.surfacing.network import CurveId, Network

#: Pieces of curves are the same, or nothing, if so many tolerances hold them.
SAME_PIECE = 2.0

#: A node whose curves moved further than so many tolerances to reach it is told.
CROWDED = 2.0

#: Less than this share of the diagonal is rounding, and not told as left out.
ROUNDING = 1e-12

Reason = Literal["overshoot", "nothing", "twice"]

_WHY: dict[Reason, str] = {
    "overshoot": "goes on beyond a node by less than the tolerance; that was left out",
    "nothing": "has a piece that stays within the tolerance of one node; it was left out",
    "twice": "has a piece that runs along another curve; one of them was left out",
}


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A part of a drawn curve that is not in the network.

    curve: the id of the curve. length: its arc length. place: (3,) where it begins.
    """

    curve: CurveId
    reason: Reason
    length: float
    place: NDArray[np.float64] = field(repr=False)

    def __str__(self) -> str:
        x, y, z = self.place
        return (
            f"curve {self.curve!r} {_WHY[self.reason]} (length {self.length:.4g}, at {x:.4g}, "
            f"{y:.4g}, {z:.4g})"
        )


@dataclass(frozen=True, slots=True)
class Crowd:
    """A node that gathers so many cuts of curves, the furthest ``spread`` away from it."""

    node: int
    count: int
    spread: float

    def __str__(self) -> str:
        return (
            f"node {self.node} gathers {self.count} cuts of curves up to {self.spread:.4g} away; "
            "at a smaller tolerance they may be several nodes"
        )


@dataclass(frozen=True, slots=True)
class Joined:
    """A network of drawn curves.

    network:  the curves' pieces in the order in which the curves were given, each along its
              curve; nodes in the order in which the pieces come to them.
    walks:    for every drawn curve the steps along the network that it became, in its sense.
              A piece left out because it is there twice is the other one here.
    left_out: the parts of curves that are not in the network.
    crowded:  nodes that gather places further apart than the tolerance, one by one.
    """

    network: Network
    walks: tuple[tuple[Step, ...], ...]
    left_out: tuple[LeftOut, ...] = ()
    crowded: tuple[Crowd, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out or crowded together, a sentence each."""
        return tuple(map(str, (*self.left_out, *self.crowded)))


def network_of_polylines(
    polylines: Sequence[ArrayLike],
    ids: Sequence[CurveId] | None = None,
    strokes: Sequence[CurveId] | None = None,
    tolerance: float | None = None,
) -> Network:
    """The network of some drawn curves; :func:`joined` also tells what was left out."""
    return joined(polylines, ids, strokes, tolerance).network


def joined(
    polylines: Sequence[ArrayLike],
    ids: Sequence[CurveId] | None = None,
    strokes: Sequence[CurveId] | None = None,
    tolerance: float | None = None,
) -> Joined:
    """The network of some drawn curves, cut where they meet.

    polylines: each (k, 3) or (k, 2), open or closed (its end is its beginning). ids: their
    names, all different; by default 0, 1, ... strokes: the strokes they are parts of, by
    default the ids. tolerance: how far apart curves may pass and still meet, in the unit of the
    points; by default SAME_PLACE of the diagonal, for curves from programs; strokes drawn by
    hand need a hundredth of the diagonal or so.

    Raises InvalidNetworkError for polylines without length or with points that are not finite,
    ids that are there twice, a tolerance that is no length, and if nothing is left.
    """
    names: list[CurveId] = [*(range(len(polylines)) if ids is None else ids)]
    of_strokes: list[CurveId] = [*(names if strokes is None else strokes)]
    if not len(names) == len(of_strokes) == len(polylines):
        raise InvalidNetworkError(
            f"{len(polylines)} polylines, {len(names)} ids and {len(of_strokes)} strokes; give "
            "one of each for every polyline"
        )
    twice = [name for name, times in Counter(names).items() if times > 1]
    if twice:
        raise InvalidNetworkError(f"the curve id {twice[0]!r} is there twice; give each its own")
    drawn = [as_curve(line, f"curve {n!r}") for line, n in zip(polylines, names, strict=True)]
    diagonal = diagonal_of(drawn)
    tolerance = SAME_PLACE * diagonal if tolerance is None else tolerance
    if not (math.isfinite(tolerance) and tolerance >= 0):
        raise InvalidNetworkError(f"the tolerance is {tolerance}; give a length of 0 or more")
    if not drawn:
        return Joined(Network((), np.empty((0, 3))), ())
    # At the size of 1: products of lengths must neither overflow nor vanish. Powers of two
    # change no digit.
    exponent = math.frexp(diagonal)[1]
    result = _joined(
        [np.ldexp(points, -exponent) for points in drawn],
        names,
        of_strokes,
        math.ldexp(tolerance, -exponent),
        exponent,
    )
    if not result.network.curves:
        raise InvalidNetworkError(
            f"at a tolerance of {tolerance:g} nothing is left of {len(drawn)} curves of "
            f"{diagonal:.3g} across; make it smaller"
        )
    return result


def _joined(
    drawn: list[Points],
    names: list[CurveId],
    strokes: list[CurveId],
    tolerance: float,
    exponent: int,
) -> Joined:
    lines, order, turned = in_order(drawn)
    alongs = [arc_length(points) for points in lines]
    for number, along in zip(order, alongs, strict=True):
        if along[-1] == 0:
            raise InvalidNetworkError(f"curve {names[number]!r} is nothing beside the others")
    cuts = find_cuts(lines, alongs, tolerance)
    nodes = find_nodes(lines, alongs, cuts)
    pieces: list[Piece] = []
    runs: list[list[int]] = []
    left_out: list[list[LeftOut]] = [[] for _ in drawn]

    def leave(curve: int, reason: Reason, length: float, place: Points) -> None:
        if length > ROUNDING:
            number = order[curve]
            place = np.ldexp(place, exponent)
            left = LeftOut(names[number], reason, math.ldexp(length, exponent), place)
            left_out[number].append(left)

    known: dict[tuple[int, int], list[int]] = {}
    for curve, (points, along) in enumerate(zip(lines, alongs, strict=True)):
        run: list[int] = []
        of_curve = cuts[curve]
        if len(of_curve) == 1:
            leave(curve, "nothing", along[-1], points[0])
        else:
            leave(curve, "overshoot", of_curve[0].length, points[0])
            leave(curve, "overshoot", along[-1] - of_curve[-1].length, points[-1])
        for begin, end in pairwise(of_curve):
            part = part_of(points, along, begin.length, end.length)
            length = end.length - begin.length
            first, last = nodes[begin.node].place, nodes[end.node].place
            reach = SAME_PIECE * tolerance
            near = begin.node == end.node and np.linalg.norm(part - first, axis=1).max() <= reach
            moved = part if near else bent(part, first, last)
            if near or len(moved) < 2:
                leave(curve, "nothing", length, part[0])
                continue
            piece = Piece(moved, (begin.node, end.node), length)
            same = known.setdefault((min(piece.nodes), max(piece.nodes)), [])
            piece.copy_of = copied(piece, same, pieces, reach)
            if piece.copy_of is None:
                same.append(len(pieces))
            else:
                leave(curve, "twice", length, part[0])
            run.append(len(pieces))
            pieces.append(piece)
        runs.append(run)
    close(runs, pieces)
    told = tuple(left for of_curve in left_out for left in of_curve)
    network, walks, numbers = numbered(pieces, runs, nodes, order, turned, names, strokes, exponent)
    crowded = sorted(
        (numbers[number], node.count, math.ldexp(node.spread, exponent))
        for number, node in nodes.items()
        if number in numbers and node.spread > CROWDED * tolerance
    )
    return Joined(network, walks, told, tuple(Crowd(*crowd) for crowd in crowded))
