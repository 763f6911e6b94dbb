"""How exactly a drawing was made: by how much ends and crossings of its curves miss each other."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb._native.surfacing.curvenetwork.survey import select_seam_joins
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb_sketch.curvenetwork.meetings import Joins, find_joins
from patterndb_sketch.curvenetwork.polylines import PackedCurves
from patterndb_sketch.curvenetwork.smoothcurves import FollowedCurves

#: Curves meet within this share of the diagonal in every drawing, and in none beyond MOST.
LEAST = 4e-3
MOST = 1.6e-2

#: Ends, and crossings, may miss by so many times what the QUANTILE of them misses by.
EASE_ENDS = 4.0
EASE_CROSSINGS = 3.0
QUANTILE = 0.9

#: Fewer gaps do not count.
FEWEST = 3

#: The search for a tolerance stops when it grows by less than this factor, or after ROUNDS.
GROWTH = 1.05
ROUNDS = 4

#: If more than this share of the ends that have a curve within MOST miss it by more than LEAST, the
#: drawing is coarse: MARGIN times the QUANTILE of all gaps is where the search begins.
COARSE = 0.4
MARGIN = 1.3

#: Curves meet within this share of the usual distance from one meeting to the next along them.
SHARE_OF_SPACING = 0.4

#: Two curves that meet more often than this run along each other; how far it is from one such
#: meeting to the next says nothing.
OFTEN = 8

#: Meetings nearer than this share of their curve are one.
ONE_MEETING = 0.05

#: A curve that meets an end's own curve so near to the end, as a share of that curve, may be what
#: the end was drawn to: an end that goes on too far.
NEAR_END = 0.25

#: A join at a closed curve's seam may be part of a meeting beyond it, within this share of it.
#: NEAR_SEAM of rust/surfacing/src/curvenetwork/survey.rs is the same.
NEAR_SEAM = 0.2

#: Closed curves are placed exactly if they meet others exactly at so many places, of which MOST_OF
#: count with one other: a closed stroke that is drawn twice crosses itself often.
PLACES_OF_CLOSED = 3
MOST_OF_ONE = 2


#: Curves may be apart by this share more of what sparse samples leave out, at most twice as far.
LOOSE = 0.5

#: Curves that are placed exactly elsewhere pass each other on purpose, unless they are within so
#: many times what their samples leave out, or within this share of the tolerance.
SURE_FRINGE = 2.0

#: An end that is nearer to one curve than this share of the distance to another does not need the
#: other.
SATISFIED = 0.1


@dataclass(frozen=True, slots=True)
class Survey:
    """How far apart curves of a drawing may be and still meet.

    ends, crossings: for joins with an end, and without. limits: (c,) for every curve, at most, by
    how closely its meetings follow each other. placed: (c,) curves that meet others exactly at both
    ends, or at several places if closed. settled: (c,) curves that do so at both ends as they were
    drawn: they are *drawn exactly*. given: the user says how far apart they may be.
    """

    ends: float
    crossings: float
    limits: Floats = field(repr=False)
    placed: NDArray[np.bool_] = field(repr=False)
    settled: NDArray[np.bool_] = field(repr=False)
    given: bool

    @property
    def most(self) -> float:
        """The greater of both."""
        return max(self.ends, self.crossings)

    @property
    def reaches(self) -> Floats:
        """(c,) how far apart every curve and others may be and still meet."""
        return np.minimum(self.limits, self.most)


def survey_drawing(
    followed: FollowedCurves, settled: NDArray[np.bool_], exact: float, diagonal: float
) -> Survey:
    """Find how far apart curves may be and still meet, by what most of them miss by."""
    curves, fixed = followed.curves, followed.exact
    least, most = max(LEAST * diagonal, exact), max(MOST * diagonal, exact)
    near = find_approaches(curves, np.full(len(curves), least), settled)
    limits = np.maximum(SHARE_OF_SPACING * measure_spacing(curves, near, fixed, least), exact)
    for_ends = least
    if has_loose_ends(curves, fixed):
        far = find_approaches(curves, np.full(len(curves), most), settled)
        gaps = measure_end_gaps(curves, far.append(fixed), most)
        if (gaps > least).sum() > COARSE * len(gaps):
            for_ends = min(MARGIN * float(np.quantile(gaps, QUANTILE)), most)
        for _ in range(ROUNDS):
            for_ends, wider = _widen(gaps, EASE_ENDS, for_ends, least, most)
            if not wider:
                break
    for_crossings = least
    for _ in range(ROUNDS):
        gaps = _measure_crossing_gaps(curves, near)
        for_crossings, wider = _widen(gaps, EASE_CROSSINGS, for_crossings, least, most)
        if not wider:
            break
        near = find_approaches(curves, np.full(len(curves), for_crossings), settled)
    return Survey(
        for_ends,
        for_crossings,
        limits,
        find_placed_curves(curves, fixed),
        settled,
        False,
    )


def take_tolerance(
    followed: FollowedCurves, settled: NDArray[np.bool_], tolerance: float
) -> Survey:
    """Take a tolerance that is given for all joins and all curves."""
    curves = followed.curves
    placed = find_placed_curves(curves, followed.exact)
    return Survey(tolerance, tolerance, np.full(len(curves), np.inf), placed, settled, True)


def _widen(
    gaps: Floats, ease: float, tolerance: float, least: float, most: float
) -> tuple[float, bool]:
    """Return the tolerance that follows from the gaps within one, and if it is wider."""
    within = gaps[gaps <= tolerance]
    if len(within) < FEWEST:
        return tolerance, False
    usual = float(np.quantile(within, QUANTILE, method="lower"))
    wanted = min(max(ease * usual, least), most)
    return (wanted, True) if wanted > GROWTH * tolerance else (tolerance, False)


def find_approaches(curves: PackedCurves, reaches: Floats, settled: NDArray[np.bool_]) -> Joins:
    """Find where curves come within reach of each other, the parts of a meeting at a seam once.

    reaches: (c,) for every curve. settled: (c,) curves that are not compared with each other.
    """
    joins = find_joins(curves, reaches, settled)
    lasts = curves.lasts[joins.curves]
    ways = np.minimum(joins.lengths, lasts - joins.lengths)
    alone = np.bincount(joins.meetings)[joins.meetings] == 1
    # A meeting of several joins has one at the seam if it goes on there.
    beside = curves.closed[joins.curves] & (ways <= NEAR_SEAM * lasts)
    alone &= joins.curves[:, 0] != joins.curves[:, 1]
    beside &= alone[:, None] | (ways == 0.0)
    some = np.flatnonzero(beside.any(axis=1))
    if not len(some):
        return joins
    pair = joins.curves[:, 0] * len(curves) + joins.curves[:, 1]
    by_pair = np.argsort(pair, kind="stable")
    kept = select_seam_joins(
        curves.points,
        curves.starts,
        curves.along,
        curves.closed,
        joins.curves,
        joins.lengths,
        joins.gaps,
        ways,
        beside,
        some,
        by_pair,
        np.searchsorted(pair[by_pair], pair[some]),
        np.searchsorted(pair[by_pair], pair[some], side="right"),
        reaches,
    )
    return joins.take(kept)


def find_settled_curves(curves: PackedCurves, exact: float) -> tuple[NDArray[np.bool_], Joins]:
    """Find which open curves have both ends exactly at others, as they are drawn.

    Returns that (c,), and where curves were put: where one ends exactly at another, or both have a
    sample.
    """
    joins = find_joins(curves, np.full(len(curves), exact))
    other = joins.curves[:, 0] != joins.curves[:, 1]
    ends = np.zeros((2, len(curves)), bool)
    for side in range(2):
        curve, length = joins.curves[other, side], joins.lengths[other, side]
        ends[0, curve[length == 0.0]] = True
        ends[1, curve[length == curves.lasts[curve]]] = True
    curve, length = joins.curves.reshape(-1), joins.lengths.reshape(-1)
    vertices = curves.find_vertices(curve, length)
    at_sample = (np.abs(curves.along[vertices] - length) <= exact).reshape(-1, 2).all(axis=1)
    put = at_sample | curves.is_open_end(joins.curves, joins.lengths).any(axis=1)
    # Closed curves begin anywhere: that one meets itself there holds nothing.
    put &= ~curves.is_seam(joins.curves, joins.lengths)
    return ends.all(axis=0) & ~curves.closed, joins.take(np.flatnonzero(put))


def has_loose_ends(curves: PackedCurves, fixed: Joins) -> bool:
    """Is there an end of an open curve at which no join, of those that are exact, is?"""
    met = np.zeros((len(curves), 2), bool)
    for side in range(2):
        curve, length = fixed.curves[:, side], fixed.lengths[:, side]
        met[curve[length == 0.0], 0] = True
        met[curve[length == curves.lasts[curve]], 1] = True
    return not met[~curves.closed].all()


def find_placed_curves(curves: PackedCurves, fixed: Joins) -> NDArray[np.bool_]:
    """Find which curves meet others exactly: at both ends, closed ones at several places."""
    other = fixed.curves[:, 0] != fixed.curves[:, 1]
    both = fixed.curves[other]
    curve = np.concatenate([both[:, 0], both[:, 1]])
    beside = np.concatenate([both[:, 1], both[:, 0]])
    length = fixed.lengths[other].T.reshape(-1)
    ends = np.zeros((2, len(curves)), bool)
    ends[0, curve[length == 0.0]] = True
    ends[1, curve[length == curves.lasts[curve]]] = True
    rows = np.unique(np.stack([curve, beside, length], axis=1), axis=0)
    pairs, count = np.unique(rows[:, :2].astype(np.int64), axis=0, return_counts=True)
    places = np.bincount(pairs[:, 0], weights=np.minimum(count, MOST_OF_ONE), minlength=len(curves))
    return np.where(curves.closed, places >= PLACES_OF_CLOSED, ends.all(axis=0))


def measure_spacing(curves: PackedCurves, near: Joins, fixed: Joins, tolerance: float) -> Floats:
    """(c,) how far it usually is from one meeting to the next along every curve.

    near, fixed: where curves come within the tolerance, and where they meet exactly.
    """
    both = fixed.append(near)
    pair = both.curves[:, 0] * len(curves) + both.curves[:, 1]
    _, number, count = np.unique(pair, return_inverse=True, return_counts=True)
    some = count[number.reshape(-1)] <= OFTEN
    curve, length = both.curves[some].reshape(-1), both.lengths[some].reshape(-1)
    order = np.lexsort((length, curve))
    curve, length = curve[order], length[order]
    width = np.minimum(tolerance, ONE_MEETING * curves.lasts)
    apart = np.r_[True, (np.diff(curve) > 0) | (np.diff(length) > width[curve[1:]])][: len(curve)]
    meetings = np.bincount(curve[apart], minlength=len(curves))
    return curves.lasts / np.maximum(1, np.where(curves.closed, meetings, meetings - 1))


def measure_end_gaps(curves: PackedCurves, joins: Joins, within: float) -> Floats:
    """(m,) by how much the open ends that have a curve near them miss it.

    Ends that are nearest to each other are one place, and count once, with the widest of their
    gaps: one corner of many ends that is drawn carelessly does not show how the rest is drawn.
    """
    nearest = find_nearest_at_ends(curves, joins, within).reshape(-1)
    one, other = (
        is_near_end(curves, joins.curves[:, side], joins.lengths[:, side], within)
        for side in range(2)
    )
    join, first, last = np.nonzero(one[:, :, None] & other[:, None, :])
    ends = 2 * joins.curves[join] + np.stack([first, last], axis=1)
    ends = ends[(nearest[ends] == joins.gaps[join][:, None]).any(axis=1)]
    graph = coo_array((np.ones(len(ends), bool), ends.T), shape=(len(nearest), len(nearest)))
    count, place = connected_components(graph, directed=False)
    some = np.isfinite(nearest)
    gaps = np.full(count, -1.0)
    np.maximum.at(gaps, place[some], nearest[some])
    return gaps[gaps >= 0.0]


def is_near_end(
    curves: PackedCurves, curve: Int64Array, lengths: Floats, within: float
) -> NDArray[np.bool_]:
    """(m, 2) are arc lengths within so much of the first and last end of an open curve?"""
    last = curves.lasts[curve]
    away = np.stack([lengths, last - lengths], axis=1)
    near = away <= np.minimum(within, NEAR_END * last)[:, None]
    return near & ~curves.closed[curve][:, None]


def find_nearest_at_ends(
    curves: PackedCurves,
    joins: Joins,
    within: float,
    copies: Int64Array | None = None,
) -> Floats:
    """(c, 2) how near another curve is to the first and last end of every curve, inf if none is.

    A curve that passes the end's own curve shortly before the end, within so much of it, counts as
    well. copies: (k, 2) pairs of curves that are drawn over each other: these do not count. Where
    they are given, one end of one other curve does not count either, unless they meet exactly: it
    may be loose as well. Two make a corner.
    """
    nearest = np.full((len(curves), 2), np.inf)
    at_ends: list[tuple[Int64Array, Int64Array, Floats]] = []
    counts = np.ones(len(joins), bool)
    if copies is not None:
        pair = joins.curves[:, 0] * len(curves) + joins.curves[:, 1]
        counts = ~np.isin(pair, np.sort(copies, axis=1) @ [len(curves), 1])
    both = curves.is_open_end(joins.curves, joins.lengths).all(axis=1) & (joins.gaps > 0.0)
    for side in range(2):
        curve = joins.curves[:, side]
        near = is_near_end(curves, curve, joins.lengths[:, side], within)
        partner = 2 * joins.curves[:, 1 - side] + (joins.lengths[:, 1 - side] > 0)
        for end in range(2):
            which = counts & near[:, end]
            if copies is not None:
                some = which & both
                at_ends.append((2 * curve[some] + end, partner[some], joins.gaps[some]))
                which &= ~both
            np.minimum.at(nearest[:, end], curve[which], joins.gaps[which])
    if copies is not None:
        key, partner, gap = (np.concatenate(part) for part in zip(*at_ends, strict=True))
        # The least gap to every partner, and of these the second at every end.
        order = np.lexsort((gap, partner, key))
        first = np.r_[True, (np.diff(key[order]) > 0) | (np.diff(partner[order]) > 0)][: len(key)]
        order = order[first]
        order = order[np.lexsort((gap[order], key[order]))]
        begins = np.r_[True, np.diff(key[order]) > 0][: len(order)]
        second = order[1:][begins[:-1] & ~begins[1:]]
        flat = nearest.reshape(-1)
        flat[key[second]] = np.minimum(flat[key[second]], gap[second])
    return nearest


def _measure_crossing_gaps(curves: PackedCurves, joins: Joins) -> Floats:
    """(m,) by how much curves miss each other where they pass, alone in their meeting."""
    inner = ~curves.is_open_end(joins.curves, joins.lengths).any(axis=1)
    alone = np.bincount(joins.meetings)[joins.meetings] == 1
    return joins.gaps[inner & alone]


def measure_allowance(
    followed: FollowedCurves, survey: Survey, joins: Joins, exact: float
) -> Floats:
    """(m,) how far apart curves may be at approaches to meet there."""
    curves = followed.curves
    has_end = curves.is_open_end(joins.curves, joins.lengths).any(axis=1)
    fringes = followed.measure_fringes(joins)
    allowed = np.where(has_end, survey.ends, survey.crossings)
    allowed = allowed + np.minimum(LOOSE * fringes, allowed)
    if not survey.given:
        both = survey.placed[joins.curves].all(axis=1)
        sure = np.minimum(allowed, np.maximum(SURE_FRINGE * fringes, exact))
        allowed = np.where(both, sure, allowed)
    return allowed


def select_joins(
    followed: FollowedCurves,
    survey: Survey,
    approaches: Joins,
    copies: Int64Array,
    exact: float,
) -> Joins:
    """Select the approaches that are meant: near enough, and needed by an end if there is one.

    copies: (k, 2) pairs of curves that may be drawn over each other. exact: what is no further
    apart meets anyway.
    """
    curves = followed.curves
    allowed = measure_allowance(followed, survey, approaches, exact)
    near = approaches.take(approaches.gaps <= allowed)
    nearest = find_nearest_at_ends(curves, near.append(followed.exact), survey.ends, copies)
    # An end that goes on too far needs what its curve meets shortly before.
    has_end = curves.is_open_end(near.curves, near.lengths)
    needed = ~(has_end[:, 0] | has_end[:, 1])
    for side in range(2):
        curve = near.curves[:, side]
        ends = is_near_end(curves, curve, near.lengths[:, side], survey.ends)
        ends &= nearest[curve] >= SATISFIED * near.gaps[:, None] - exact
        needed |= ends.any(axis=1)
    return near.take(needed)
