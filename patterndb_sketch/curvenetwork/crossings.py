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
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.curvenetwork.meetings import Joins, find_contacts
from patterndb_sketch.curvenetwork.polylines import Groups, PackedCurves, drop_repeats, is_closed
from patterndb_sketch.curvenetwork.smoothcurves import END_FIT, GuessedCurves, guess_curves

#: Polylines may be apart by so many times their sagittas where curves meet: these do not bend
#: evenly.
EASE = 1.5

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


#: The search for where curves are nearest may leave an edge by this share of it: places at samples
#: are on one edge or the other.
BEYOND = 0.01


@dataclass(frozen=True, slots=True)
class _Place:
    """A place on a polyline.

    edge, share: the edge of the curve, and the share of it. length: arc length. vertex: the sample
    that it is at, -1 if none. given: is it the sample's own place? held: is it one at which curves
    were put as they were drawn? point: the sample's own place, or where the guessed curve is.
    """

    curve: int
    edge: int
    share: float
    length: float
    vertex: int
    given: bool
    held: bool
    point: tuple[float, float, float]


def join_smooth_crossings(
    packed: PackedCurves, settled: NDArray[np.bool_], put: Joins, tolerance: float
) -> list[Points]:
    """Give polylines (k, 3) a point in common where the smooth curves that they stand for meet.

    settled: (c,) curves that are drawn exactly. put: where curves were put as they were drawn;
    nothing moves these places. tolerance: polylines that are no further apart meet as they are.
    Polylines keep their ends, except those that are moved onto another's.
    """
    lines = packed.split()
    guessed = guess_curves(packed)
    greatest = 2.0 * EASE * float(guessed.sagitta.max())
    if greatest <= tolerance:
        return lines
    meetings = _find_meetings(packed, guessed, settled, tolerance)
    places = _list_places(packed, meetings, put, tolerance)
    # What is held at both places is there on purpose, and not here.
    both = [a.held and b.held for a, b in zip(places[::2], places[1::2], strict=True)]
    meant = meetings.exact | ~np.array(both, bool)
    meetings = meetings.take(meant)
    places = [place for k, place in enumerate(places) if meant[k // 2]]
    wide = ONE_PLACE * guessed.sagitta
    # A closed curve meets itself at its seam, but that is one sample as any other.
    seams = [
        a.vertex >= 0 and (a.curve, a.vertex) == (b.curve, b.vertex)
        for a, b in zip(places[::2], places[1::2], strict=True)
    ]
    exact = meetings.exact & ~np.array(seams, bool)
    group_of = _group_places(packed, wide, places, exact.tolist(), tolerance)
    groups: dict[int, list[int]] = {}
    for k, group in enumerate(group_of):
        groups.setdefault(group, []).append(k)
    # Of two curves that are drawn exactly, both come to where they meet.
    both_settled = settled[packed.curve_of[meetings.pairs]].all(axis=1)
    points = np.array([place.point for place in places]).reshape(-1, 2, 3)
    off = np.linalg.norm(points - meetings.points, axis=2).max(axis=1)
    eases = (
        np.where(both_settled, END_FIT * guessed.sagitta[meetings.pairs].sum(axis=1) + off, 0.0)
        + tolerance
    )
    was_put = np.zeros(len(packed), bool)
    was_put[put.curves] = True
    moved: dict[int, list[tuple[_Place, Points]]] = {}
    for group in sorted({group_of[2 * k] for k in np.flatnonzero(~meetings.exact).tolist()}):
        held = [places[k] for k in groups[group] if places[k].held]
        met = [places[k] for k in groups[group] if exact[k // 2]]
        point = _choose_point(packed, held or met or [places[k] for k in groups[group]])
        for k in {places[k]: k for k in groups[group]}.values():
            place = places[k]
            near = wide[packed.starts[place.curve] + place.edge] + eases[k // 2]
            away = float(np.linalg.norm(point - place.point))
            # What was put somewhere does not come to where a careless curve meets others.
            if not place.held and (away <= near or not was_put[place.curve]):
                moved.setdefault(place.curve, []).append((place, point))
    # Edges bend where points are put into them: what is held within one becomes a point before.
    for place in _list_held_places(packed, put, tolerance):
        if place.curve in moved:
            moved[place.curve].append((place, np.array(place.point)))
    return [_insert(line, moved.get(curve, [])) for curve, line in enumerate(lines)]


def _list_held_places(packed: PackedCurves, put: Joins, tolerance: float) -> list[_Place]:
    """List the places between samples at which curves were put."""
    curves, lengths = packed.select_between_points(
        put.curves.reshape(-1), put.lengths.reshape(-1), tolerance
    )
    edges = packed.find_edges(curves, lengths)
    shares = (lengths - packed.along[edges]) / (packed.along[edges + 1] - packed.along[edges])
    columns = curves, edges - packed.starts[curves], shares, lengths, packed.locate(curves, lengths)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [
        _Place(curve, edge, share, length, -1, False, True, (x, y, z))
        for curve, edge, share, length, (x, y, z) in rows
    ]


@dataclass(frozen=True, slots=True)
class _Meetings:
    """Where curves meet: edges (k, 2), shares of them (k, 2), points (k, 2, 3), and whether the
    polylines meet there as they are (k,)."""

    pairs: Int64Array
    shares: Floats
    points: Points
    exact: NDArray[np.bool_]

    def take(self, which: NDArray[np.bool_]) -> _Meetings:
        """Return some of the meetings."""
        return _Meetings(
            self.pairs[which], self.shares[which], self.points[which], self.exact[which]
        )


def _find_meetings(
    packed: PackedCurves, curves: GuessedCurves, settled: NDArray[np.bool_], tolerance: float
) -> _Meetings:
    """Find where guessed curves or their polylines meet, each place once."""
    points, curve_of = packed.points, packed.curve_of
    boxes = np.maximum(EASE * curves.sagitta, tolerance / 2)
    most = max(2.0 * float(boxes.max()), tolerance)
    pairs, shares, gaps = find_contacts(packed, np.full(len(packed), most), boxes)
    own = (curve_of[pairs[:, 0]] == curve_of[pairs[:, 1]]) & (np.diff(pairs)[:, 0] <= 2)
    pairs, shares, gaps = pairs[~own], shares[~own], gaps[~own]
    exact = gaps <= tolerance
    nearer, guessed, places = _approach(curves, pairs, shares)
    # Curves that are drawn exactly do not miss each other by so little on purpose.
    both_settled = settled[curve_of[pairs]].all(axis=1)
    usual, most_off = (of_edge[pairs].sum(axis=1) for of_edge in (curves.fit, curves.sagitta))
    fit = np.where(both_settled, END_FIT * most_off, usual)
    meets = exact | (guessed <= fit + tolerance)
    # Where polylines run along each other there is no one place.
    meets &= _may_cross(packed, pairs, np.where(exact[:, None], shares, nearer))
    straight = points[pairs] + shares[..., None] * (points[pairs + 1] - points[pairs])
    shares = np.where(exact[:, None], shares, nearer)
    places = np.where(exact[:, None, None], straight, places)
    gaps = np.where(exact, 0.0, guessed)
    kept = np.flatnonzero(meets)
    kept = kept[np.lexsort((pairs[kept, 1], pairs[kept, 0], gaps[kept]))]
    size = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = packed.along[pairs] + shares * size[pairs]
    chosen = kept[_choose_nearest(curve_of[pairs[kept]], at[kept], size[pairs[kept]])]
    return _Meetings(pairs[chosen], shares[chosen], places[chosen], exact[chosen])


def _approach(
    curves: GuessedCurves, pairs: Int64Array, shares: Floats, beyond: float = 0.0
) -> tuple[Floats, Floats, Points]:
    """Move places on pairs of edges (k, 2) to where the curves are nearest, within the edges.

    beyond: by which share of an edge they may leave it. Returns the shares (k, 2), how far apart
    the curves are there (k,), and the points (k, 2, 3).
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
        np.clip(shares, -beyond, 1.0 + beyond, out=shares)
    points = np.stack(
        [curves.locate(pairs[:, side], shares[:, side])[0] for side in range(2)], axis=1
    )
    return shares, np.linalg.norm(points[:, 0] - points[:, 1], axis=1), points


def _may_cross(packed: PackedCurves, pairs: Int64Array, shares: Floats) -> NDArray[np.bool_]:
    """(k,) which contacts cross, or are at an end of a curve, and are no neighbours on one."""
    curve_of = packed.curve_of
    steps = packed.points[pairs + 1] - packed.points[pairs]
    cosine = np.abs((steps[:, 0] * steps[:, 1]).sum(axis=1))
    across = cosine <= math.cos(LEAST_ANGLE) * np.linalg.norm(steps, axis=2).prod(axis=1)
    other = (curve_of[pairs[:, 0]] != curve_of[pairs[:, 1]]) | (pairs[:, 1] - pairs[:, 0] > 2)
    return (across | _is_open_end(packed, pairs, shares).any(axis=1)) & other


def _is_open_end(packed: PackedCurves, edges: Int64Array, shares: Floats) -> NDArray[np.bool_]:
    """(k, 2) which places on edges are ends of open curves."""
    curve = packed.curve_of[edges]
    first, last = packed.starts[:-1][curve], packed.starts[1:][curve] - 1
    at_end = ((edges == first) & (shares == 0)) | ((edges + 1 == last) & (shares == 1))
    return at_end & ~packed.closed[curve]


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


def _list_places(
    curves: PackedCurves, meetings: _Meetings, put: Joins, tolerance: float
) -> list[_Place]:
    """The places of all contacts, two of each: samples where these are near.

    The last sample of a closed curve is its first.
    """
    of_put, lengths_put = put.curves.reshape(-1), put.lengths.reshape(-1)
    nearest = curves.find_vertices(of_put, lengths_put)
    nearest = nearest[np.abs(curves.along[nearest] - lengths_put) <= tolerance]
    held_samples = np.zeros(len(curves.points), bool)
    held_samples[nearest] = True
    of_nearest = curves.curve_of[nearest]
    at_seam = curves.closed[of_nearest] & (nearest == curves.starts[of_nearest + 1] - 1)
    held_samples[curves.starts[of_nearest[at_seam]]] = True
    edges, shares = meetings.pairs.reshape(-1), meetings.shares.reshape(-1)
    curve = curves.curve_of[edges]
    first, last = curves.starts[curve], curves.starts[curve + 1] - 1
    vertex = np.full(len(edges), -1)
    given = np.zeros(len(edges), bool)
    for end in range(2):
        at, away = edges + end, np.abs(shares - end)
        own = ~curves.closed[curve] & ((at == first) | (at == last))
        near = away <= np.where(own, AT_PLACE, AT_SAMPLE)
        vertex[near] = np.where(curves.closed[curve] & (at == last), first, at)[near]
        given = np.where(near, (away <= AT_PLACE) | held_samples[vertex], given)
    size = np.linalg.norm(curves.points[edges + 1] - curves.points[edges], axis=1)
    lengths = np.where(vertex == first, 0.0, curves.along[edges] + shares * size)
    points = np.where(given[:, None], curves.points[vertex], meetings.points.reshape(-1, 3))
    held = (vertex >= 0) & held_samples[vertex]
    if len(put):
        tree = KDTree(curves.locate(of_put, lengths_put))
        held |= np.repeat(meetings.exact, 2) & (tree.query(points)[0] <= 2.0 * tolerance)
    samples = np.where(vertex < 0, -1, vertex - first)
    columns = curve, edges - first, shares, lengths, samples, given, held, points
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [
        _Place(curve, edge, share, length, sample, given, held, (x, y, z))
        for curve, edge, share, length, sample, given, held, (x, y, z) in rows
    ]


def _group_places(
    curves: PackedCurves,
    wide: Floats,
    places: Sequence[_Place],
    exact: Sequence[bool],
    tolerance: float,
) -> list[int]:
    """For the places of all contacts, two of each, which of them are one point of the network.

    wide: (n,) for every edge how far apart two places on it may be. exact: for every contact, do
    the polylines meet there as they are? Such places, and those that are held, stay apart beyond
    the tolerance.
    """
    order = sorted(range(len(places)), key=lambda k: (places[k].curve, places[k].length))
    groups = Groups(len(places))
    for k in range(0, len(places), 2):
        groups.unite(k, k + 1)
    met = [exact[k // 2] or place.held for k, place in enumerate(places)]
    met = [met[k] or met[k ^ 1] for k in range(len(places))]
    near: list[tuple[float, int, int]] = []
    for a, b in pairwise(order):
        one, other = places[a], places[b]
        start = int(curves.starts[one.curve])
        within = max(wide[start + one.edge], wide[start + other.edge], tolerance)
        if one.curve == other.curve and other.length - one.length <= within:
            near.append((other.length - one.length, a, b))
    for gap, a, b in sorted(near):
        one, other = groups.find(a), groups.find(b)
        if gap <= tolerance or not (met[one] and met[other]):
            met[groups.unite(one, other)] = met[one] or met[other]
    return [groups.find(k) for k in range(len(places))]


def _choose_point(curves: PackedCurves, group: Sequence[_Place]) -> Points:
    """Where the curves of a group meet: at an end, else at a sample, else between their guesses."""
    given = [place for place in group if place.given]
    sizes = np.diff(curves.starts)
    at_end = [
        place
        for place in given
        if not curves.closed[place.curve] and place.vertex in (0, int(sizes[place.curve]) - 1)
    ]
    points = np.array([place.point for place in at_end or given or group])
    # From one of them on: the mean of equal points is that point.
    return points[0] + (points - points[0]).mean(axis=0)


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


@dataclass(frozen=True, slots=True)
class ClosestPlaces:
    """Places where two curves are closer to each other than around, the closest first.

    lengths: (m, 2) float64, arc lengths along the polylines of the first and the second. points:
    (m, 2, 3), on the smooth curves. gaps: (m,), how far these are apart. sines: (m,) of the angle
    between the curves there, 0 where they run side by side or on into each other.
    """

    lengths: Floats = field(repr=False)
    points: Points = field(repr=False)
    gaps: Floats = field(repr=False)
    sines: Floats = field(repr=False)

    def __len__(self) -> int:
        return len(self.gaps)

    @property
    def middles(self) -> Points:
        """(m, 3) midway between the points."""
        return self.points.mean(axis=1)

    def take(self, which: NDArray[np.bool_] | Int64Array) -> ClosestPlaces:
        """Return some of the places."""
        return ClosestPlaces(
            self.lengths[which], self.points[which], self.gaps[which], self.sines[which]
        )


def find_closest_places(packed: PackedCurves, reach: float) -> ClosestPlaces:
    """Find where the smooth curves that two polylines stand for come closest to each other.

    reach: places farther apart are left out. An end of an open curve counts if the other curve is
    not closer to its neighbourhood.
    """
    curves = guess_curves(packed)
    pairs, straight, gaps = find_contacts(packed, np.full(len(packed), reach))
    other = packed.curve_of[pairs[:, 0]] != packed.curve_of[pairs[:, 1]]
    pairs, straight, gaps = pairs[other], straight[other], gaps[other]
    lowest = _is_lowest(pairs, gaps, len(packed.points))
    pairs, straight, gaps = pairs[lowest], straight[lowest], gaps[lowest]
    shares, apart, _ = _approach(curves, pairs, straight, BEYOND)
    # Curves that bend much in comparison to their distance lead the search astray.
    inside = ((shares > -BEYOND) & (shares < 1.0 + BEYOND)).all(axis=1)
    inside &= apart <= gaps + curves.sagitta[pairs].sum(axis=1)
    shares = np.where(inside[:, None], shares, straight)
    (p, dp), (q, dq) = (curves.locate(pairs[:, side], shares[:, side]) for side in range(2))
    gaps = np.linalg.norm(p - q, axis=1)
    product = np.linalg.norm(dp, axis=1) * np.linalg.norm(dq, axis=1)
    sines = np.linalg.norm(np.cross(dp, dq), axis=1) / np.where(product > 0.0, product, 1.0)
    lengths = packed.along[pairs] + shares * (packed.along[pairs + 1] - packed.along[pairs])
    order = np.argsort(gaps, kind="stable")
    order = order[gaps[order] <= reach]
    # Edges differ much in length: what is within the longest of them is one place.
    longest = np.full(lengths.shape, np.diff(packed.along).max())
    chosen = order[_choose_nearest(packed.curve_of[pairs[order]], lengths[order], longest[order])]
    return ClosestPlaces(lengths, np.stack([p, q], axis=1), gaps, sines).take(chosen)


def _is_lowest(pairs: Int64Array, gaps: Floats, n: int) -> NDArray[np.bool_]:
    """(k,) which pairs of edges (k, 2) are no farther apart than those next to them.

    n: the number of points.
    """
    key = pairs @ [n, 1]
    order = np.argsort(key)
    lowest = np.ones(len(key), bool)
    for beside in (-n - 1, -n, 1 - n, -1, 1, n - 1, n, n + 1):
        at = np.searchsorted(key, key + beside, sorter=order)
        at = order[np.minimum(at, len(key) - 1)] if len(key) else at
        lowest &= (key[at] != key + beside) | (gaps <= gaps[at])
    return lowest
