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

Without a tolerance curves meet where those that their samples stand for do
(:mod:`patterndb_sketch.surfacing.joining.sagittas`).

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
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from patterndb_sketch.surfacing.joining.looseends import (
    LooseEnd,
    find_loose_ends,
    tell_loose_ends,
)
from patterndb_sketch.surfacing.joining.meetings import find_joins, measure_deviation
from patterndb_sketch.surfacing.joining.polylines import (
    SAME_PLACE,
    as_curve,
    measure_diagonal,
    move_ends,
)
from patterndb_sketch.surfacing.joining.sagittas import join_smooth_crossings
from patterndb_sketch.surfacing.naming import Step
from patterndb_sketch.surfacing.network import (
    Curve,
    CurveId,
    CurveNetwork,
    InvalidNetworkError,
    drop_repeats,
)

Reason = Literal["overshoot", "nothing", "twice"]

#: Pieces of curves are the same, or nothing, if so many tolerances hold them.
SAME_PIECE = 2.0

#: A node whose curves moved further than so many tolerances to reach it is told.
CROWDED = 2.0

#: Less than this share of the diagonal is rounding, and not told as left out.
ROUNDING = 1e-12
_WHY: dict[Reason, str] = {
    "overshoot": "goes on beyond a node by less than the tolerance; that was left out",
    "nothing": "has a piece that stays within the tolerance of one node; it was left out",
    "twice": "has a piece that runs along another curve; one of them was left out",
}


@dataclass(frozen=True, slots=True)
class OmittedPart:
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
class CrowdedNode:
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
class JoinedCurves:
    """A network of drawn curves.

    network:  the curves' pieces in the order in which the curves were given, each along its
              curve; nodes in the order in which the pieces come to them.
    walks:    for every drawn curve the steps along the network that it became, in its sense.
              A piece left out because it is there twice is the other one here.
    left_out: the parts of curves that are not in the network.
    crowded:  nodes that gather places further apart than the tolerance, one by one.
    loose:    ends where nothing goes on that are near another curve, the farthest off first.
    """

    network: CurveNetwork
    walks: tuple[tuple[Step, ...], ...]
    left_out: tuple[OmittedPart, ...] = ()
    crowded: tuple[CrowdedNode, ...] = ()
    loose: tuple[LooseEnd, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out or crowded together, a sentence each, and what stops short."""
        told = tuple(map(str, (*self.left_out, *self.crowded)))
        return (*told, tell_loose_ends(self.loose)) if self.loose else told


def network_of_polylines(
    polylines: Sequence[ArrayLike],
    ids: Sequence[CurveId] | None = None,
    strokes: Sequence[CurveId] | None = None,
    tolerance: float | None = None,
) -> CurveNetwork:
    """Make the network of drawn curves; :func:`join_polylines` also tells what was left out."""
    return join_polylines(polylines, ids, strokes, tolerance).network


def join_polylines(
    polylines: Sequence[ArrayLike],
    ids: Sequence[CurveId] | None = None,
    strokes: Sequence[CurveId] | None = None,
    tolerance: float | None = None,
) -> JoinedCurves:
    """Make the network of some drawn curves, cut where they meet.

    polylines: each (k, 3) or (k, 2), open or closed (its end is its beginning). ids: their
    names, all different; by default 0, 1, ... strokes: the strokes they are parts of, by
    default the ids. tolerance: how far apart curves may pass and still meet, in the unit of the
    points; by default SAME_PLACE of the diagonal, and between samples of smooth curves what these
    leave out, for curves from programs; strokes drawn by hand need a hundredth of the diagonal or
    so.

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
    diagonal = measure_diagonal(drawn)
    sampled = tolerance is None
    tolerance = SAME_PLACE * diagonal if tolerance is None else tolerance
    if not (math.isfinite(tolerance) and tolerance >= 0):
        raise InvalidNetworkError(f"the tolerance is {tolerance}; give a length of 0 or more")
    if not drawn:
        return JoinedCurves(CurveNetwork((), np.empty((0, 3))), ())
    # At the size of 1: products of lengths must neither overflow nor vanish. Powers of two
    # change no digit.
    exponent = math.frexp(diagonal)[1]
    result = _join(
        [np.ldexp(points, -exponent) for points in drawn],
        names,
        of_strokes,
        math.ldexp(tolerance, -exponent),
        exponent,
        sampled,
    )
    if not result.network.curves:
        raise InvalidNetworkError(
            f"at a tolerance of {tolerance:g} nothing is left of {len(drawn)} curves of "
            f"{diagonal:.3g} across; make it smaller"
        )
    return result


def _join(
    drawn: list[Points],
    names: list[CurveId],
    strokes: list[CurveId],
    tolerance: float,
    exponent: int,
    sampled: bool,
) -> JoinedCurves:
    lines, order, turned = order_curves(drawn)
    if sampled:
        lines = join_smooth_crossings(lines, tolerance)
    alongs = [arc_length(points) for points in lines]
    for number, along in zip(order, alongs, strict=True):
        if along[-1] == 0:
            raise InvalidNetworkError(f"curve {names[number]!r} is nothing beside the others")
    cuts = find_cuts(lines, alongs, tolerance)
    nodes = find_nodes(lines, alongs, cuts)
    pieces: list[Piece] = []
    runs: list[list[int]] = []
    left_out: list[list[OmittedPart]] = [[] for _ in drawn]
    # What is less than the places that are one is nobody's concern.
    least = tolerance if sampled else ROUNDING

    def leave(curve: int, reason: Reason, length: float, place: Points) -> None:
        if length > least:
            number = order[curve]
            place = np.ldexp(place, exponent)
            left = OmittedPart(names[number], reason, math.ldexp(length, exponent), place)
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
            part = extract_part(points, along, begin.length, end.length)
            length = end.length - begin.length
            first, last = nodes[begin.node].place, nodes[end.node].place
            reach = SAME_PIECE * tolerance
            near = begin.node == end.node and np.linalg.norm(part - first, axis=1).max() <= reach
            moved = part if near else move_ends(part, first, last)
            if near or len(moved) < 2:
                leave(curve, "nothing", length, part[0])
                continue
            piece = Piece(moved, (begin.node, end.node), length)
            same = known.setdefault((min(piece.nodes), max(piece.nodes)), [])
            piece.copy_of = find_copy(piece, same, pieces, reach)
            if piece.copy_of is None:
                same.append(len(pieces))
            else:
                leave(curve, "twice", length, part[0])
            run.append(len(pieces))
            pieces.append(piece)
        runs.append(run)
    close_curves(runs, pieces)
    told = tuple(left for of_curve in left_out for left in of_curve)
    network, walks, numbers = number_pieces(
        pieces, runs, nodes, order, turned, names, strokes, exponent
    )
    crowded = sorted(
        (numbers[number], node.count, math.ldexp(node.spread, exponent))
        for number, node in nodes.items()
        if number in numbers and node.spread > CROWDED * tolerance
    )
    gathered = tuple(CrowdedNode(*crowd) for crowd in crowded)
    return JoinedCurves(network, walks, told, gathered, find_loose_ends(network))


def order_curves(drawn: list[Points]) -> tuple[list[Points], list[int], list[bool]]:
    """Sort curves, and turn them, by what depends on their geometry alone, longest first.

    Returns the curves, which each of them is, and whether it is turned round.
    """
    keyed: list[tuple[float, bytes, int, bool, Points]] = []
    for number, points in enumerate(drawn):
        # Adding 0 makes the negative zero positive: the bytes shall be alike.
        senses = [np.ascontiguousarray(sense + 0.0) for sense in (points, points[::-1])]
        turned = senses[1].tobytes() < senses[0].tobytes()
        line = senses[turned]
        keyed.append((-arc_length(line)[-1], line.tobytes(), number, turned, line))
    keyed.sort(key=lambda one: one[:3])
    return [k[4] for k in keyed], [k[2] for k in keyed], [k[3] for k in keyed]


@dataclass(frozen=True, slots=True)
class CurveCut:
    """A place where a curve is cut: its arc length, the node, and whether a curve ends there."""

    length: float
    node: int
    ending: bool


def find_cuts(lines: list[Points], alongs: list[Floats], tolerance: float) -> list[list[CurveCut]]:
    """Find where every curve is cut, ends included, in order; one alone if the curve vanishes."""
    starts = np.cumsum([0, *map(len, lines)])
    joins = find_joins(np.concatenate(lines), starts, np.concatenate(alongs), tolerance)
    n_curves, n_joins = len(lines), len(joins.curves)
    lasts = np.array([along[-1] for along in alongs])
    curve = np.r_[joins.curves.T.reshape(-1), np.arange(n_curves), np.arange(n_curves)]
    length = np.r_[joins.lengths.T.reshape(-1), np.zeros(n_curves), lasts]
    met = np.arange(len(curve)) < 2 * n_joins
    order = np.lexsort((length, curve))
    curve, length, met = curve[order], length[order], met[order]
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    apart = (np.diff(curve) > 0) | (np.diff(length) > tolerance)
    group = np.r_[0, np.cumsum(apart)]
    ends = group[place[: 2 * n_joins]].reshape(2, -1)
    links = coo_array((np.ones(n_joins, bool), ends), shape=(group[-1] + 1, group[-1] + 1))
    nodes = connected_components(links, directed=False)[1]
    cuts: list[list[CurveCut]] = [[] for _ in lines]
    for begin, end in pairwise([0, *(1 + np.flatnonzero(apart)).tolist(), len(curve)]):
        of_curve = int(curve[begin])
        within, real = length[begin:end], met[begin:end]
        at_ends = [e for e in (0.0, lasts[of_curve]) if e in (within[0], within[-1])]
        # A curve is cut at its end if others meet it there, else where they do meet it: what
        # goes on beyond is an overshoot.
        exact = [e for e in at_ends if (within[real] == e).any()]
        mean = _mean(within[real]) if real.any() else None
        at = float((exact or at_ends)[0] if exact or mean is None else mean)
        cuts[of_curve].append(CurveCut(at, int(nodes[group[begin]]), bool(at_ends)))
    return cuts


@dataclass(frozen=True, slots=True)
class JoinedNode:
    """Where curves meet.

    place:  (3,) the mean of the curves that pass it, or if there is none of those that end there.
    count:  how many cuts of curves are gathered in it.
    spread: how far the furthest of them was away.
    """

    place: Floats = field(repr=False)
    count: int
    spread: float


def find_nodes(
    lines: list[Points], alongs: list[Floats], cuts: list[list[CurveCut]]
) -> dict[int, JoinedNode]:
    """Place the nodes that the cuts name."""
    passing: dict[int, list[Points]] = {}
    ending: dict[int, list[Points]] = {}
    for points, along, of_curve in zip(lines, alongs, cuts, strict=True):
        at = _at(points, along, [cut.length for cut in of_curve])
        for cut, place in zip(of_curve, at, strict=True):
            (ending if cut.ending else passing).setdefault(cut.node, []).append(place)
    nodes: dict[int, JoinedNode] = {}
    for number in ending | passing:
        gathered = np.array(passing.get(number, []) + ending.get(number, []))
        place = _mean(gathered[: len(passing.get(number, gathered))])
        spread = np.linalg.norm(gathered - place, axis=1).max()
        nodes[number] = JoinedNode(place, len(gathered), float(spread))
    return nodes


def _mean(values: Floats) -> Floats:
    """The mean over the first axis; exact if all are the same."""
    return values[0] + (values - values[0]).mean(axis=0)


def _at(points: Points, along: Floats, lengths: list[float]) -> Points:
    return np.stack([np.interp(lengths, along, points[:, d]) for d in range(3)], axis=1)


def extract_part(points: Points, along: Floats, begin: float, end: float) -> Points:
    """Take the part of a polyline between two arc lengths."""
    inner = points[(along > begin) & (along < end)]
    first, last = _at(points, along, [begin, end])
    return drop_repeats(np.concatenate([first[None], inner, last[None]]))


@dataclass(slots=True)
class Piece:
    """A piece of a curve between two nodes, in the sense in which the curve is worked on.

    copy_of: the piece that stays of the two that are alike, and whether it runs the other way.
    """

    points: Points
    nodes: tuple[int, int]
    length: float
    copy_of: tuple[int, bool] | None = None


def find_copy(
    piece: Piece, same: list[int], pieces: list[Piece], reach: float
) -> tuple[int, bool] | None:
    """Find which of some pieces between the same nodes this one copies, and if it is turned."""
    for number in same:
        other = pieces[number].points
        if (
            measure_deviation(piece.points, other) <= reach
            and measure_deviation(other, piece.points) <= reach
        ):
            first, last = piece.nodes
            if first != last:
                return number, pieces[number].nodes != piece.nodes
            quarters = [sample_polyline(points, 4)[[1, 3]] for points in (piece.points, other)]
            straight = np.linalg.norm(quarters[0] - quarters[1])
            return number, bool(np.linalg.norm(quarters[0] - quarters[1][::-1]) < straight)
    return None


def close_curves(runs: list[list[int]], pieces: list[Piece]) -> None:
    """Make one piece of the last and the first of a closed curve where no other curve meets it."""
    originals = {piece.copy_of[0] for piece in pieces if piece.copy_of is not None}
    ends = Counter(node for piece in pieces if piece.copy_of is None for node in piece.nodes)
    for run in runs:
        if len(run) < 2:
            continue
        first, last = pieces[run[0]], pieces[run[-1]]
        seam = first.nodes[0]
        ours = first.copy_of is None and last.copy_of is None and not originals & {run[0], run[-1]}
        if not ours or last.nodes[1] != seam or ends[seam] != 2:
            continue
        last.points = np.concatenate([last.points, first.points[1:]])
        last.nodes = (last.nodes[0], first.nodes[1])
        last.length += first.length
        del run[0]


def number_pieces(
    pieces: list[Piece],
    runs: list[list[int]],
    nodes: dict[int, JoinedNode],
    order: list[int],
    turned: list[bool],
    names: list[CurveId],
    strokes: list[CurveId],
    exponent: int,
) -> tuple[CurveNetwork, tuple[tuple[Step, ...], ...], dict[int, int]]:
    """Make the network, curves and nodes in the order in which the curves were given.

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
    return CurveNetwork(tuple(curves), at), named, numbers
