"""Networks from curves as drawn: where they meet is found, and they are cut there.

First curves meet where they do so exactly: within SAME_PLACE of the diagonal, or where the smooth
curves meet that their samples stand for (:mod:`.sagittas`). Nothing undoes that. Then the smooth
curves are followed finely (:mod:`.following`), and those that come near each other meet if that is
meant (:mod:`.selection`): within a tolerance that follows from the drawing (:mod:`.survey`), or
within one that is given. Strokes drawn twice are recognised (:mod:`.duplicates`), and all joined
places become nodes (:mod:`.cuts`):

- ends that meet become one node, at their mean, unless curves meet there exactly;
- an end that meets another curve on its way moves onto it, and cuts it there;
- curves that cross, or pass within the tolerance, are cut both, as is a curve that crosses itself;
- what a curve has beyond its last node, no longer than the tolerance, is an overshoot and is
  left out; so is a piece that returns to its node within two tolerances;
- of pieces that run from the same node to the same node within two tolerances of each other all
  except one are left out: that of the longest curve stays, or one that is drawn exactly;
- a curve whose two ends meet only each other is closed, and is cut only where others meet it.

A curve is *drawn exactly* if it is open and both of its ends lie exactly on others as drawn. Two
such curves meet where they meet exactly, and nowhere else, whatever the tolerance. They do not
move.

What curves move by to reach their nodes is spread along their pieces. What is left out is reported,
as are joins of curves that do not meet exactly, with their distances. The result does not depend on
the order, the directions and the unit in which the curves are given.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from patterndb._native.surfacing.curvenetwork.meetings import measure_deviation
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from patterndb_sketch.curvenetwork.crossings import join_smooth_crossings
from patterndb_sketch.curvenetwork.cuts import EXACT, FIRM, PUT, CurveCuts, cut_curves
from patterndb_sketch.curvenetwork.drawing import (
    CurveJoin,
    LooseEnd,
    describe_joins,
    describe_loose_ends,
    find_loose_ends,
)
from patterndb_sketch.curvenetwork.duplicates import (
    Stretches,
    carry_cuts_over,
    find_duplicates,
    find_stretches,
    is_on_duplicate,
    is_within_duplicate,
)
from patterndb_sketch.curvenetwork.meetings import Joins
from patterndb_sketch.curvenetwork.network import (
    Curve,
    CurveId,
    CurveNetwork,
    InvalidNetworkError,
    Step,
)
from patterndb_sketch.curvenetwork.polylines import (
    SAME_PLACE,
    PackedCurves,
    as_curve,
    drop_repeats,
    measure_diagonal,
    move_ends,
    pack_curves,
)
from patterndb_sketch.curvenetwork.smoothcurves import FollowedCurves, follow_curves
from patterndb_sketch.curvenetwork.survey import (
    LOOSE,
    Survey,
    find_approaches,
    find_settled_curves,
    select_joins,
    survey_drawing,
    take_tolerance,
)

Reason = Literal["overshoot", "nothing", "twice"]

#: Pieces of curves are the same, or nothing, if so many tolerances hold them.
SAME_PIECE = 2.0

#: A node whose curves moved further than so many tolerances to reach it is told.
CROWDED = 2.0

#: Less than this share of the diagonal is rounding.
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
    joins:    joins of curves that do not meet exactly, the farthest apart first.
    tolerance: how far apart curves may be and still meet.
    """

    network: CurveNetwork
    walks: tuple[tuple[Step, ...], ...]
    left_out: tuple[OmittedPart, ...] = ()
    crowded: tuple[CrowdedNode, ...] = ()
    loose: tuple[LooseEnd, ...] = ()
    joins: tuple[CurveJoin, ...] = ()
    tolerance: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """What was joined, left out or crowded together, and what stops short, in sentences."""
        joins = (describe_joins(self.joins),) if self.joins else ()
        loose = (describe_loose_ends(self.loose),) if self.loose else ()
        return (*joins, *map(str, (*self.left_out, *self.crowded)), *loose)


def network_of_polylines(
    polylines: Sequence[ArrayLike],
    ids: Sequence[CurveId] | None = None,
    strokes: Sequence[CurveId] | None = None,
    tolerance: float | None = None,
) -> CurveNetwork:
    """Make the network of drawn curves; :func:`join_polylines` also reports what was left out."""
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
    points; by default it follows from by how much the drawn curves miss each other. It adds to what
    meets exactly; curves that are drawn exactly meet each other nowhere else.

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
    if tolerance is not None and not (math.isfinite(tolerance) and tolerance >= 0):
        raise InvalidNetworkError(f"the tolerance is {tolerance}; give a length of 0 or more")
    if not drawn:
        return JoinedCurves(CurveNetwork((), np.empty((0, 3))), ())
    # At the size of 1: products of lengths must neither overflow nor vanish. Powers of two
    # change no digit.
    exponent = math.frexp(diagonal)[1]
    lines = [np.ldexp(points, -exponent) for points in drawn]
    result = _join(
        _sort_curves(lines, names, of_strokes, exponent),
        None if tolerance is None else math.ldexp(tolerance, -exponent),
    )
    if not result.network.curves:
        mend = "draw more of them" if tolerance is None else "give a smaller tolerance"
        raise InvalidNetworkError(
            f"nothing is left of {len(drawn)} curves of {diagonal:.3g} across when what lies "
            f"within {result.tolerance:g} is joined; {mend}"
        )
    return result


@dataclass(frozen=True, slots=True)
class _SortedCurves:
    """Drawn curves in an order, and senses, that depend on their geometry alone; longest first.

    lines: (k, 3) of every curve. order: which of the drawn ones each is. turned: whether each is
    turned round. names, strokes: of the drawn curves, in the order in which they were given.
    exponent: lines are in units of 2 to its power.
    """

    lines: list[Points]
    order: list[int]
    turned: list[bool]
    names: list[CurveId]
    strokes: list[CurveId]
    exponent: int


def _join(drawn: _SortedCurves, tolerance: float | None) -> JoinedCurves:
    lines, order, exponent = drawn.lines, drawn.order, drawn.exponent
    diagonal = measure_diagonal(lines)
    exact = SAME_PLACE * diagonal
    found = _find_cuts(lines, exact, diagonal, tolerance)
    curves, cuts, survey = found.followed.curves, found.cuts, found.survey
    left_out: list[list[OmittedPart]] = [[] for _ in lines]

    def leave(curve: int, reason: Reason, length: float, place: Points) -> None:
        # Less than this is one place.
        if length > exact:
            number = order[curve]
            place = np.ldexp(place, exponent)
            left = OmittedPart(drawn.names[number], reason, math.ldexp(length, exponent), place)
            left_out[number].append(left)

    at_cuts = curves.locate(np.repeat(np.arange(len(curves)), np.diff(cuts.starts)), cuts.lengths)
    reaches = SAME_PIECE * survey.reaches
    least = SAME_PIECE * (exact if tolerance is None else survey.ends)
    starts = curves.starts.tolist()
    pieces: dict[int, Piece] = {}
    runs: list[list[int]] = [[] for _ in lines]
    known: dict[tuple[int, int], list[int]] = {}
    # What is drawn exactly first: it stays where another curve runs along it.
    for curve in np.argsort(~survey.settled, kind="stable").tolist():
        begin, end = starts[curve], starts[curve + 1]
        at = slice(int(cuts.starts[curve]), int(cuts.starts[curve + 1]))
        nodes = cuts.nodes[at].tolist()
        cut = _CutCurve(
            curves.points[begin:end],
            curves.along[begin:end],
            found.followed.drawn[begin:end],
            cuts.lengths[at].tolist(),
            at_cuts[at],
            cuts.places[nodes[0]],
        )
        lengths, whole = cut.lengths, float(curves.lasts[curve])
        if len(lengths) == 1:
            leave(curve, "nothing", whole, cut.points[0])
        else:
            leave(curve, "overshoot", lengths[0], cut.points[0])
            leave(curve, "overshoot", whole - lengths[-1], cut.points[-1])
        reach = max(least, float(reaches[curve]))
        pairs = list(pairwise(range(len(lengths))))
        if len(pairs) > 1 and nodes[0] == nodes[-1] and cuts.counts[nodes[0]] == 2:
            # Its ends meet only each other: a piece goes on from the last cut before to the first.
            pairs = [*pairs[1:-1], (len(lengths) - 2, 1)]
        for k, m in pairs:
            first, last = cuts.places[nodes[k]], cuts.places[nodes[m]]
            size = lengths[m] - lengths[k] + (0.0 if k < m else lengths[-1] - lengths[0])
            part = cut.extract_piece(k, m, drawn_only=True)
            near = False
            if nodes[k] == nodes[m]:
                # A curve that meets only itself is small, not nothing.
                within = reach if len(lengths) > 2 else least
                gaps = np.linalg.norm(cut.extract_piece(k, m) - first, axis=1)
                near = bool(gaps.max() <= within)
            moved = part if near else move_ends(part, first, last)
            if near or np.abs(moved - moved[0]).max() <= ROUNDING * diagonal:
                leave(curve, "nothing", size, part[0])
                continue
            ends_at = nodes[k], nodes[m]
            follow = partial(cut.extract_piece, k, m)
            piece = Piece(moved, ends_at, size, follow, bool(survey.settled[curve]))
            same = known.setdefault((min(ends_at), max(ends_at)), [])
            piece.copy_of = find_copy(piece, same, pieces, reach, SAME_PIECE * exact)
            if piece.copy_of is None:
                same.append(len(pieces))
            else:
                leave(curve, "twice", size, part[0])
            runs[curve].append(len(pieces))
            pieces[len(pieces)] = piece
    close_curves(runs, pieces)
    left = tuple(part for of_curve in left_out for part in of_curve)
    network, walks, numbers = number_pieces(pieces, runs, cuts.places, drawn)
    crowded = sorted(
        (numbers[node], int(cuts.counts[node]), math.ldexp(float(cuts.spreads[node]), exponent))
        for node in np.flatnonzero(cuts.spreads > CROWDED * survey.most).tolist()
        if node in numbers
    )
    gathered = tuple(CrowdedNode(*crowd) for crowd in crowded)
    joins = _list_joins(curves, found.loose, [drawn.names[number] for number in order], exponent)
    loose = find_loose_ends(network)
    within = math.ldexp(survey.most, exponent)
    return JoinedCurves(network, walks, left, gathered, loose, joins, within)


def _list_joins(
    curves: PackedCurves, joins: Joins, names: list[CurveId], exponent: int
) -> tuple[CurveJoin, ...]:
    """The joins of curves that do not meet exactly, the farthest first."""
    places = np.ldexp(
        sum(curves.locate(joins.curves[:, side], joins.lengths[:, side]) for side in range(2)) / 2,
        exponent,
    )
    described = [
        CurveJoin((names[a], names[b]), place, math.ldexp(gap, exponent))
        for (a, b), place, gap in zip(
            joins.curves.tolist(), places, joins.gaps.tolist(), strict=True
        )
    ]
    return tuple(sorted(described, key=lambda join: (-join.gap, join.place.tolist())))


def _sort_curves(
    drawn: list[Points], names: list[CurveId], strokes: list[CurveId], exponent: int
) -> _SortedCurves:
    """Sort curves, and turn them, by what depends on their geometry alone."""
    for line, name in zip(drawn, names, strict=True):
        if arc_length(line)[-1] == 0.0:
            raise InvalidNetworkError(f"curve {name!r} has no length next to the others")
    # Lengths and coordinates that differ by rounding are equal: they may in another unit.
    rounding = ROUNDING * measure_diagonal(drawn)
    ranks = _rank(np.concatenate(drawn).reshape(-1), rounding).reshape(-1, 3)
    lengths = _rank(np.array([-arc_length(line)[-1] for line in drawn]), rounding).tolist()
    bounds = np.cumsum([0, *map(len, drawn)])
    keys: list[tuple[int, bytes, int]] = []
    turned: list[bool] = []
    for number, (begin, end) in enumerate(pairwise(bounds.tolist())):
        senses = [ranks[begin:end].tobytes(), ranks[begin:end][::-1].tobytes()]
        turned.append(senses[1] < senses[0])
        keys.append((lengths[number], min(senses), number))
    order = [number for _, _, number in sorted(keys)]
    lines = [np.ascontiguousarray(drawn[k][:: -1 if turned[k] else 1]) for k in order]
    return _SortedCurves(lines, order, [turned[k] for k in order], names, strokes, exponent)


def _rank(values: Floats, rounding: float) -> NDArray[np.uint32]:
    """(n,) the rank of every value, as bytes that sort likewise; values in a row are equal."""
    order = np.argsort(values)
    ranks = np.empty(len(values), ">u4")
    ranks[order] = np.r_[0, np.cumsum(np.diff(values[order]) > rounding)]
    return ranks


@dataclass(frozen=True, slots=True)
class _FoundCuts:
    """Curves, followed finely, where they are cut, and the joins that are not exact."""

    followed: FollowedCurves
    survey: Survey
    cuts: CurveCuts
    loose: Joins


def _find_cuts(
    lines: list[Points], exact: float, diagonal: float, tolerance: float | None
) -> _FoundCuts:
    """Find where curves meet: exactly, then within a tolerance."""
    drawn = pack_curves(lines)
    settled, put = find_settled_curves(drawn, exact)
    followed = follow_curves(join_smooth_crossings(drawn, settled, put, exact), exact, diagonal)
    curves, fixed = followed.curves, followed.exact
    if tolerance is None:
        survey = survey_drawing(followed, settled, exact, diagonal)
    else:
        survey = take_tolerance(followed, settled, max(tolerance, exact))
    most = survey.most
    search = most + min(most, LOOSE * float(followed.fringes.max()))
    approaches = find_approaches(curves, np.minimum(survey.limits, search), settled)
    stretches = find_stretches(approaches, survey.ends)
    meant = select_joins(followed, survey, approaches, stretches.curves, exact)
    stretches = find_duplicates(curves, stretches, meant, survey, exact)
    places = drawn.locate(put.curves.reshape(-1), put.lengths.reshape(-1))
    holds = _rate_exact_joins(curves, fixed, survey, stretches, places, exact)
    kept = (holds >= FIRM) | ~is_within_duplicate(curves, fixed, stretches, most)
    fixed, holds = fixed.take(kept), holds[kept]
    meant = meant.take(~is_within_duplicate(curves, meant, stretches, most))
    carried = carry_cuts_over(curves, fixed.append(meant), stretches, most)
    cuts = cut_curves(curves, fixed, holds, meant.append(carried), survey, exact)
    return _FoundCuts(followed, survey, cuts, meant.take(meant.gaps > exact))


def _rate_exact_joins(
    curves: PackedCurves,
    fixed: Joins,
    survey: Survey,
    duplicates: Stretches,
    put: Points,
    exact: float,
) -> Int64Array:
    """(m,) how firmly exact joins hold their nodes: PUT, FIRM or EXACT.

    PUT: curves were put there as they were drawn, at one of ``put`` (k, 3). FIRM, no accident: an
    end is there, or both are open and placed exactly at their ends, so that they cross where they
    are meant to; but where strokes are drawn twice, each of them meets what one of them is meant
    to.
    """
    has_end = curves.is_open_end(fixed.curves, fixed.lengths).any(axis=1)
    has_end &= ~curves.is_seam(fixed.curves, fixed.lengths)
    placed = (survey.placed & ~curves.closed)[fixed.curves].all(axis=1)
    firm = (has_end | placed) & ~is_on_duplicate(fixed, duplicates)
    if len(put) and len(fixed):
        places = curves.locate(fixed.curves[:, 0], fixed.lengths[:, 0])
        at_put = KDTree(put).query(places, distance_upper_bound=2 * exact)[0] <= 2 * exact
        return np.where(at_put, PUT, np.where(firm, FIRM, EXACT))
    return np.where(firm, FIRM, EXACT)


@dataclass(frozen=True, slots=True)
class _CutCurve:
    """A curve, followed finely, and where it is cut.

    drawn: (n,) which of its points are drawn. lengths: arc lengths of the cuts. places: (m, 3) of
    the cuts. seam: (3,) the node of the first and the last cut, if that is one.
    """

    points: Points
    along: Floats
    drawn: NDArray[np.bool_]
    lengths: list[float]
    places: Points
    seam: Points

    def extract_piece(self, first: int, last: int, drawn_only: bool = False) -> Points:
        """Take the piece between two cuts, over the seam if the last does not follow the first."""
        if first < last:
            begin = np.searchsorted(self.along, self.lengths[first], side="right")
            end = np.searchsorted(self.along, self.lengths[last])
            inner = self.points[begin:end]
            if drawn_only:
                inner = inner[self.drawn[begin:end]]
            places = self.places
            return drop_repeats(np.concatenate([places[[first]], inner, places[[last]]]))
        before = self.extract_piece(first, len(self.lengths) - 1, drawn_only)
        after = self.extract_piece(0, last, drawn_only)
        before = move_ends(before, before[0], self.seam)
        return np.concatenate([before, move_ends(after, self.seam, after[-1])[1:]])


@dataclass
class Piece:
    """A piece of a curve between two nodes, in the sense in which the curve is worked on.

    follow: gives the piece followed finely, not yet moved to its nodes. settled: is the curve drawn
    exactly?
    copy_of: the piece that stays of the two that are alike, and whether it runs the other way.
    """

    points: Points
    nodes: tuple[int, int]
    length: float
    follow: Callable[[], Points]
    settled: bool
    copy_of: tuple[int, bool] | None = None

    @cached_property
    def whole(self) -> Points:
        """(k, 3) the piece followed finely, between its nodes."""
        return move_ends(self.follow(), self.points[0], self.points[-1])


def find_copy(
    piece: Piece, same: list[int], pieces: dict[int, Piece], reach: float, exact: float
) -> tuple[int, bool] | None:
    """Find which of some pieces between the same nodes this one copies, and if it is turned.

    Two that are both drawn exactly are two on purpose, unless they are within ``exact`` of each
    other.
    """
    for number in same:
        other = pieces[number].whole
        within = exact if piece.settled and pieces[number].settled else reach
        if (
            measure_deviation(piece.whole, other) <= within
            and measure_deviation(other, piece.whole) <= within
        ):
            first, last = piece.nodes
            if first != last:
                return number, pieces[number].nodes != piece.nodes
            quarters = [sample_polyline(points, 4)[[1, 3]] for points in (piece.whole, other)]
            straight = np.linalg.norm(quarters[0] - quarters[1])
            return number, bool(np.linalg.norm(quarters[0] - quarters[1][::-1]) < straight)
    return None


def close_curves(runs: list[list[int]], pieces: dict[int, Piece]) -> None:
    """Make one piece of the last and the first of a closed curve where no other curve meets it."""
    originals = {piece.copy_of[0] for piece in pieces.values() if piece.copy_of is not None}
    ends = Counter(
        node for piece in pieces.values() if piece.copy_of is None for node in piece.nodes
    )
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
    pieces: dict[int, Piece],
    runs: list[list[int]],
    places: Points,
    drawn: _SortedCurves,
) -> tuple[CurveNetwork, tuple[tuple[Step, ...], ...], dict[int, int]]:
    """Make the network, curves and nodes in the order in which the curves were given.

    Returns it, the walks of the curves, and the new numbers of the nodes that remain.
    """
    walks: list[list[Step]] = [[] for _ in drawn.order]
    for run, number, backward in zip(runs, drawn.order, drawn.turned, strict=True):
        steps = [pieces[piece].copy_of or (piece, False) for piece in run]
        owned = [(piece, way != backward) for piece, way in steps]
        walks[number] = owned[::-1] if backward else owned
    owner = {piece: number for run, number in zip(runs, drawn.order, strict=True) for piece in run}
    #: The new number of every piece that stays, and whether it was turned round.
    placed: dict[int, Step] = {}
    numbers: dict[int, int] = {}
    curves: list[Curve] = []
    for number, walk in enumerate(walks):
        for piece, backward in walk:
            if owner[piece] != number or piece in placed:
                continue
            points = np.ldexp(pieces[piece].points, drawn.exponent)
            ends = pieces[piece].nodes
            if backward:
                points, ends = np.ascontiguousarray(points[::-1]), ends[::-1]
            first, last = (numbers.setdefault(node, len(numbers)) for node in ends)
            placed[piece] = len(curves), backward
            curves.append(Curve(points, (first, last), drawn.names[number], drawn.strokes[number]))
    at = np.array([np.ldexp(places[node], drawn.exponent) for node in numbers]).reshape(-1, 3)
    named = tuple(
        tuple((placed[piece][0], way != placed[piece][1]) for piece, way in walk) for walk in walks
    )
    return CurveNetwork(tuple(curves), at), named, numbers
