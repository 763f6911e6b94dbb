"""Networks from curves as drawn: where they meet is found, and they are cut there.

Places that meet (see :mod:`sketch.surfacing.meetings`) become one node, and so do neighbours on
a curve that are no further apart than the tolerance:

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

from query.polyline import Points, arc_length, sampled
from sketch.surfacing.cutting import Node, find_cuts, find_nodes, in_order, part_of
from sketch.surfacing.errors import InvalidNetworkError
from sketch.surfacing.naming import Step
from sketch.surfacing.nearest import farthest
from sketch.surfacing.network import Curve, CurveId, Network
from sketch.surfacing.polylines import SAME_PLACE, as_curve, bent, diagonal_of

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


@dataclass(slots=True)
class _Piece:
    """A piece of a curve between two nodes, in the sense in which the curve is worked on.

    copy_of: the piece that stays of the two that are alike, and whether it runs the other way.
    """

    points: Points
    nodes: tuple[int, int]
    length: float
    copy_of: tuple[int, bool] | None = None


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
    pieces: list[_Piece] = []
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
            piece = _Piece(moved, (begin.node, end.node), length)
            same = known.setdefault((min(piece.nodes), max(piece.nodes)), [])
            piece.copy_of = _copied(piece, same, pieces, reach)
            if piece.copy_of is None:
                same.append(len(pieces))
            else:
                leave(curve, "twice", length, part[0])
            run.append(len(pieces))
            pieces.append(piece)
        runs.append(run)
    _close(runs, pieces)
    told = tuple(left for of_curve in left_out for left in of_curve)
    network, walks, numbers = _numbered(
        pieces, runs, nodes, order, turned, names, strokes, exponent
    )
    crowded = sorted(
        (numbers[number], node.count, math.ldexp(node.spread, exponent))
        for number, node in nodes.items()
        if number in numbers and node.spread > CROWDED * tolerance
    )
    return Joined(network, walks, told, tuple(Crowd(*crowd) for crowd in crowded))


def _copied(
    piece: _Piece, same: list[int], pieces: list[_Piece], reach: float
) -> tuple[int, bool] | None:
    """Which of some pieces between the same nodes this one copies, and whether it is turned."""
    for number in same:
        other = pieces[number].points
        if farthest(piece.points, other) <= reach and farthest(other, piece.points) <= reach:
            first, last = piece.nodes
            if first != last:
                return number, pieces[number].nodes != piece.nodes
            quarters = [sampled(points, 4)[[1, 3]] for points in (piece.points, other)]
            straight = np.linalg.norm(quarters[0] - quarters[1])
            return number, bool(np.linalg.norm(quarters[0] - quarters[1][::-1]) < straight)
    return None


def _close(runs: list[list[int]], pieces: list[_Piece]) -> None:
    """Make one piece of the last and first of a closed curve that no other ends meet between."""
    copied = {piece.copy_of[0] for piece in pieces if piece.copy_of is not None}
    ends = Counter(node for piece in pieces if piece.copy_of is None for node in piece.nodes)
    for run in runs:
        if len(run) < 2:
            continue
        first, last = pieces[run[0]], pieces[run[-1]]
        seam = first.nodes[0]
        ours = first.copy_of is None and last.copy_of is None and not copied & {run[0], run[-1]}
        if not ours or last.nodes[1] != seam or ends[seam] != 2:
            continue
        last.points = np.concatenate([last.points, first.points[1:]])
        last.nodes = (last.nodes[0], first.nodes[1])
        last.length += first.length
        del run[0]


def _numbered(
    pieces: list[_Piece],
    runs: list[list[int]],
    nodes: dict[int, Node],
    order: list[int],
    turned: list[bool],
    names: list[CurveId],
    strokes: list[CurveId],
    exponent: int,
) -> tuple[Network, tuple[tuple[Step, ...], ...], dict[int, int]]:
    """The network with curves and nodes in the order in which the curves were given.

    Returns it, the walks of the curves, and the new numbers of the nodes that remain.
    """
    walks: list[list[Step]] = [[] for _ in names]
    for run, number, backward in zip(runs, order, turned, strict=True):
        steps = [pieces[piece].copy_of or (piece, False) for piece in run]
        owned = [(piece, way != backward) for piece, way in steps]
        walks[number] = owned[::-1] if backward else owned
    owner = {piece: number for run, number in zip(runs, order, strict=True) for piece in run}
    #: The new number of every piece that stays, and whether it was turned round.
    placed: dict[int, Step] = {}
    numbers: dict[int, int] = {}
    curves: list[Curve] = []
    for number, walk in enumerate(walks):
        for piece, backward in walk:
            if owner[piece] != number or piece in placed:
                continue
            points = np.ldexp(pieces[piece].points, exponent)
            ends = pieces[piece].nodes
            if backward:
                points, ends = np.ascontiguousarray(points[::-1]), ends[::-1]
            first, last = (numbers.setdefault(node, len(numbers)) for node in ends)
            placed[piece] = len(curves), backward
            curves.append(Curve(points, (first, last), names[number], strokes[number]))
    at = np.array([np.ldexp(nodes[node].place, exponent) for node in numbers]).reshape(-1, 3)
    named = tuple(
        tuple((placed[piece][0], way != placed[piece][1]) for piece, way in walk) for walk in walks
    )
    return Network(tuple(curves), at), named, numbers
