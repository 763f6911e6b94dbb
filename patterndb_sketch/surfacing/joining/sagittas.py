"""Curves that cross between their samples: polylines brought together where smooth curves meet.

A polyline runs beside the smooth curve that it was sampled from: between two samples h apart where
the curve turns by t, by h t / 8, the sagitta. So two curves that cross pass each other by as much
as their sagittas, and a curve ends that far from the polyline that it ends on, unless a sample is
there. The curves between the samples are guessed, as cubics whose second derivatives are those of
the samples; where they meet, both polylines get a point in common. Where polylines are straight, or
have a corner, nothing moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.surfacing.joining.meetings import find_contacts
from patterndb_sketch.surfacing.network import drop_repeats, measure_turning
from patterndb_sketch.surfacing.sampling import CORNER_ANGLE

#: Polylines may be apart by so many times their sagittas where curves meet: these do not bend
#: evenly.
EASE = 1.5

#: Guessed curves meet if they come as near to each other as this share of their sagittas: of an
#: arc sampled every 20 degrees the guess is off by 0.01 of it. Beside ends and corners, where the
#: second derivative is that of the next sample, END_FIT.
FIT = 0.05
END_FIT = 0.3

#: Rounds of Gauss-Newton that look for the places where guessed curves are nearest.
ROUNDS = 6

#: A place this near to a sample, as a share of the edge, is the sample: no short edges.
AT_SAMPLE = 0.07

#: ... and so near it is the sample's own place, to which the other curve comes. Farther off the
#: sample moves; open ends do not.
AT_PLACE = 0.01

#: Curves that run along each other by less than this do not cross; in radians.
LEAST_ANGLE = math.radians(15)

#: Places on one curve that are this many sagittas apart are one: three curves through one point
#: cross each other at three.
ONE_PLACE = 4.0


@dataclass(frozen=True, slots=True)
class _Place:
    """A place on a polyline.

    edge, share: the edge of the curve, and the share of it. length: arc length. vertex: the sample
    that it is at, -1 if none. given: is it the sample's own place? point: that, or where the
    guessed curve is.
    """

    curve: int
    edge: int
    share: float
    length: float
    vertex: int
    given: bool
    point: tuple[float, float, float]


def join_smooth_crossings(lines: list[Points], tolerance: float) -> list[Points]:
    """Give polylines (k, 3) a point in common where the smooth curves that they stand for meet.

    tolerance: what is no further apart meets already. Polylines keep their ends, but those that are
    moved onto another's.
    """
    starts = np.cumsum([0, *map(len, lines)])
    curves = guess_curves(lines)
    greatest = 2.0 * EASE * float(curves.sagitta.max())
    if greatest <= tolerance:
        return lines
    meetings = _find_meetings(curves, starts, tolerance)
    places = [
        tuple(
            _place(lines, starts, int(meetings.pairs[k, side]), meetings.shares[k, side], point)
            for side, point in enumerate(meetings.points[k])
        )
        for k in range(len(meetings.pairs))
    ]
    wide = [ONE_PLACE * curves.sagitta[a:b] for a, b in pairwise(starts.tolist())]
    group_of = _group_places(wide, places)
    groups: dict[int, list[_Place]] = {}
    apart: set[int] = set()
    for k, (pair, met) in enumerate(zip(places, meetings.exact.tolist(), strict=True)):
        group = int(group_of[2 * k])
        groups.setdefault(group, []).extend(pair)
        if not met:
            apart.add(group)
    moved: dict[int, list[tuple[_Place, Points]]] = {}
    for group in sorted(apart):
        point = _choose_point(lines, groups[group])
        for place in dict.fromkeys(groups[group]):
            moved.setdefault(place.curve, []).append((place, point))
    return [_insert(line, moved.get(curve, [])) for curve, line in enumerate(lines)]


@dataclass(frozen=True, slots=True)
class _Meetings:
    """Where curves meet: edges (k, 2), shares of them (k, 2), points (k, 2, 3), and whether the
    polylines meet there as they are (k,)."""

    pairs: Int64Array
    shares: Floats
    points: Points
    exact: NDArray[np.bool_]


def _find_meetings(curves: GuessedCurves, starts: Int64Array, tolerance: float) -> _Meetings:
    """Find where guessed curves or their polylines meet, each place once."""
    points = curves.points
    curve_of = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    reaches = np.maximum(EASE * curves.sagitta, tolerance / 2)
    most = max(2.0 * float(reaches.max()), tolerance)
    pairs, shares, gaps = find_contacts(points, starts, most, reaches)
    own = (curve_of[pairs[:, 0]] == curve_of[pairs[:, 1]]) & (np.diff(pairs)[:, 0] <= 2)
    pairs, shares, gaps = pairs[~own], shares[~own], gaps[~own]
    exact = gaps <= tolerance
    nearer, guessed, places = _approach(curves, pairs, shares)
    meets = exact | (guessed <= curves.fit[pairs].sum(axis=1) + tolerance)
    meets &= exact | _may_cross(points, starts, curve_of, pairs, nearer)
    straight = points[pairs] + shares[..., None] * (points[pairs + 1] - points[pairs])
    shares = np.where(exact[:, None], shares, nearer)
    places = np.where(exact[:, None, None], straight, places)
    gaps = np.where(exact, 0.0, guessed)
    kept = np.flatnonzero(meets)
    kept = kept[np.lexsort((pairs[kept, 1], pairs[kept, 0], gaps[kept]))]
    along = np.zeros(len(points))
    size = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along[1:] = np.cumsum(size)
    at = along[pairs] + shares * size[pairs]
    chosen = kept[_choose_nearest(curve_of[pairs[kept]], at[kept], size[pairs[kept]])]
    return _Meetings(pairs[chosen], shares[chosen], places[chosen], exact[chosen])


@dataclass(frozen=True, slots=True)
class GuessedCurves:
    """Curves between the samples of polylines, as cubics; n samples, an edge from each to the next.

    sagitta: (n,) how far every edge may be from its curve. fit: (n,) how far the curve may be
    from its guess. bends: (n, 3) second derivatives by arc length at the samples, as seen from the
    edge that begins there; after: (n, 3) likewise at its end.
    """

    points: Points = field(repr=False)
    sagitta: Floats = field(repr=False)
    fit: Floats = field(repr=False)
    bends: Points = field(repr=False)
    after: Points = field(repr=False)

    def locate(self, edges: Int64Array, shares: Floats) -> tuple[Points, Points]:
        """The places (k, 3) at shares (k,) of edges on the curves, and their derivatives."""
        start = self.points[edges]
        step = self.points[edges + 1] - start
        s = shares[:, None]
        r = 1.0 - s
        scale = (step * step).sum(axis=1)[:, None] / 6.0
        bends, after = self.bends[edges], self.after[edges]
        at = start + s * step - scale * (bends * (r - r**3) + after * (s - s**3))
        slope = step - scale * (bends * (3.0 * r**2 - 1.0) + after * (1.0 - 3.0 * s**2))
        return at, slope


def guess_curves(lines: Sequence[Points]) -> GuessedCurves:
    """Guess the curves between the samples of polylines (k, 3), which are in one array then."""
    parts = [_guess_curve(line) for line in lines]
    sagitta, fit, bends, after = (np.concatenate(part) for part in zip(*parts, strict=True))
    return GuessedCurves(np.concatenate(lines), sagitta, fit, bends, after)


def _guess_curve(line: Points) -> tuple[Floats, Floats, Points, Points]:
    n = len(line)
    closed = is_closed(line)
    around = np.concatenate([line[-2:-1], line, line[1:2]]) if closed else line
    bends = np.zeros((n, 3))
    turning = np.zeros(n)
    if len(around) > 2:
        steps = np.diff(around, axis=0)
        size = np.linalg.norm(steps, axis=1)[:, None]
        # Steps so short beside the network that their squares vanish have no direction.
        unit = steps / np.where(size > 0.0, size, 1.0)
        both = size[1:] + size[:-1]
        within = slice(None) if closed else slice(1, -1)
        bends[within] = 2.0 * np.diff(unit, axis=0) / np.where(both > 0.0, both, 1.0)
        turning[within] = measure_turning(around)
    # What is no smooth sample is as its neighbour across the edge.
    smooth = turning <= CORNER_ANGLE
    if not closed:
        smooth[[0, -1]] = False
    bends[~smooth] = 0.0
    turning[~smooth] = 0.0
    at_start, at_end = smooth[:-1], smooth[1:]
    bends_start = np.where(at_start[:, None], bends[:-1], bends[1:])
    bends_end = np.where(at_end[:, None], bends[1:], bends[:-1])
    size = np.linalg.norm(np.diff(line, axis=0), axis=1)
    sagitta = size * np.maximum(turning[:-1], turning[1:]) / 8.0
    fit = np.where(at_start & at_end, FIT, END_FIT) * sagitta
    none = np.zeros((1, 3))
    return (
        np.r_[sagitta, 0.0],
        np.r_[fit, 0.0],
        np.concatenate([bends_start, none]),
        np.concatenate([bends_end, none]),
    )


def is_closed(line: Points) -> bool:
    """Does a polyline end where it begins?"""
    return bool((line[0] == line[-1]).all())


def _approach(
    curves: GuessedCurves, pairs: Int64Array, shares: Floats
) -> tuple[Floats, Floats, Points]:
    """Move places on pairs of edges (k, 2) to where the curves are nearest, within the edges.

    Returns the shares (k, 2), how far apart the curves are there (k,), and the points (k, 2, 3).
    """
    shares = shares.copy()
    for _ in range(ROUNDS):
        (p, dp), (q, dq) = (curves.locate(pairs[:, side], shares[:, side]) for side in range(2))
        gap = p - q
        a, b, c = (dp * dp).sum(axis=1), (dp * dq).sum(axis=1), (dq * dq).sum(axis=1)
        d, e = (dp * gap).sum(axis=1), (dq * gap).sum(axis=1)
        determinant = a * c - b * b
        # Nearly parallel curves have no nearest places; these stay as they are.
        safe = determinant > 1e-6 * a * c
        scale = np.where(safe, determinant, 1.0)
        moves = np.stack([(b * e - c * d) / scale, (a * e - b * d) / scale], axis=1)
        shares += np.where(safe[:, None], moves, 0.0)
        np.clip(shares, 0.0, 1.0, out=shares)
    points = np.stack(
        [curves.locate(pairs[:, side], shares[:, side])[0] for side in range(2)], axis=1
    )
    return shares, np.linalg.norm(points[:, 0] - points[:, 1], axis=1), points


def _may_cross(
    points: Points, starts: Int64Array, curve_of: Int64Array, pairs: Int64Array, shares: Floats
) -> NDArray[np.bool_]:
    """(k,) which contacts cross, or are at an end of a curve, and are no neighbours on one."""
    steps = points[pairs + 1] - points[pairs]
    cosine = np.abs((steps[:, 0] * steps[:, 1]).sum(axis=1))
    across = cosine <= math.cos(LEAST_ANGLE) * np.linalg.norm(steps, axis=2).prod(axis=1)
    first, last = starts[:-1][curve_of[pairs]], starts[1:][curve_of[pairs]] - 1
    is_end = ((pairs == first) & (shares == 0)) | ((pairs + 1 == last) & (shares == 1))
    is_end &= (points[first] != points[last]).any(axis=2)
    other = (curve_of[pairs[:, 0]] != curve_of[pairs[:, 1]]) | (pairs[:, 1] - pairs[:, 0] > 2)
    return (across | is_end.any(axis=1)) & other


def _choose_nearest(curves: Int64Array, at: Floats, edges: Floats) -> list[int]:
    """The contacts, nearest first, that have no nearer one of the same curves within an edge of it.

    curves, at, edges: (k, 2) which curves, where along them, and how long the edges there are.
    """
    known: dict[tuple[int, ...], list[tuple[float, float]]] = {}
    chosen: list[int] = []
    for contact, (pair, (a, b), (wide, high)) in enumerate(
        zip(curves.tolist(), at.tolist(), edges.tolist(), strict=True)
    ):
        others = known.setdefault(tuple(pair), [])
        if all(abs(a - x) > wide or abs(b - y) > high for x, y in others):
            others.append((a, b))
            chosen.append(contact)
    return chosen


def _place(
    lines: Sequence[Points], starts: Int64Array, edge: int, share: float, point: Points
) -> _Place:
    """The place on a curve, at its sample if one is near; the last of a closed one is its first."""
    curve = int(np.searchsorted(starts, edge, side="right")) - 1
    line = lines[curve]
    closed = is_closed(line)
    at = edge - int(starts[curve])
    vertex = -1
    given = False
    for end in range(2):
        own = not closed and at + end in (0, len(line) - 1)
        if abs(share - end) <= (AT_PLACE if own else AT_SAMPLE):
            vertex = 0 if closed and at + end == len(line) - 1 else at + end
            given = abs(share - end) <= AT_PLACE
    length = float(np.linalg.norm(np.diff(line[: at + 2], axis=0), axis=1)[:at].sum())
    length += share * float(np.linalg.norm(line[at + 1] - line[at]))
    x, y, z = (line[vertex] if given else point).tolist()
    return _Place(curve, at, share, 0.0 if vertex == 0 else length, vertex, given, (x, y, z))


def _group_places(wide: Sequence[Floats], places: Sequence[tuple[_Place, ...]]) -> Int64Array:
    """For the places of all contacts, in pairs, which of them are one point of the network."""
    sites = [place for pair in places for place in pair]
    order = sorted(range(len(sites)), key=lambda k: (sites[k].curve, sites[k].length))
    links = [(k, k + 1) for k in range(0, len(sites), 2)]
    for a, b in pairwise(order):
        one, other = sites[a], sites[b]
        within = max(wide[one.curve][one.edge], wide[other.curve][other.edge])
        if one.curve == other.curve and other.length - one.length <= within:
            links.append((a, b))
    ends = np.array(links, np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(links), bool), ends), shape=(len(sites), len(sites)))
    return connected_components(graph, directed=False)[1]


def _choose_point(lines: Sequence[Points], group: Sequence[_Place]) -> Points:
    """Where the curves of a group meet: at an end, else at a sample, else between their guesses."""
    given = [place for place in group if place.given]
    at_end = [
        place
        for place in given
        if not is_closed(lines[place.curve]) and place.vertex in (0, len(lines[place.curve]) - 1)
    ]
    points = [place.point for place in at_end or given or group]
    return np.unique(np.array(points), axis=0).mean(axis=0)


def _insert(line: Points, changes: Sequence[tuple[_Place, Points]]) -> Points:
    """The polyline with points put into its edges, and samples moved onto others."""
    if not changes:
        return line
    points = line.copy()
    for place, point in changes:
        if place.vertex >= 0:
            points[place.vertex] = point
    if is_closed(line):
        points[-1] = points[0]
    put = sorted(
        (
            (place.edge + 1, place.share, k)
            for k, (place, _) in enumerate(changes)
            if place.vertex < 0
        )
    )
    if put:
        rows = [changes[k][1] for _, _, k in put]
        points = np.insert(points, [at for at, _, _ in put], rows, axis=0)
    return drop_repeats(points)
