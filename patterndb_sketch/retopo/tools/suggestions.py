"""Suggest patches that close against the boundaries around a point, in the plane.

Source: sketch-based quad meshes paper, section 5 and Fig. 11; cases have its letters. A window of
each of some sizes shows sequences of the boundaries (:func:`_find_sequences`); each configuration
of their corners suggests a patch, or none (:func:`_suggest`); :func:`suggest_patches` lists those
that can be, the largest first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from collections.abc import Sequence as Many
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.planar import (
    NewSide,
    OldSide,
    PlanarBoundary,
    PlanarCorner,
    PlanarPatch,
    Side,
    find_fault,
    make_arc,
    make_line,
)

#: Windows that are looked at, from a tenth of the radius to all of it.
SIZES = 10

#: Tells of a line (n, 2) whether all of it is on the part of the surface that has a
#: parameterisation.
Covered = Callable[[Points], bool]


def is_finite(line: Points) -> bool:
    """The whole plane has a surface."""
    return bool(np.isfinite(line).all())


def suggest_patch(
    boundaries: list[PlanarBoundary],
    size: float,
    *,
    triangle: bool = False,
    covered: Covered = is_finite,
) -> Suggestion | None:
    """The patch suggested by what a window of one size shows, or None if there is none."""
    found = _suggest(boundaries, _find_sequences(boundaries, _Window(size)), triangle=triangle)
    if found is None or find_fault(found.patch, boundaries) is not None:
        return None
    if not all(covered(curve) for curve in found.patch.curves):
        return None
    return replace(found, size=size)


def suggest_patches(
    boundaries: list[PlanarBoundary],
    radius: float,
    snap: float,
    *,
    covered: Covered = is_finite,
) -> list[Suggestion]:
    """Patches around the origin, best first: the largest quad, smaller quads, then triangles.

    boundaries: in the plane of a parameterisation about a vertex of one of them: u along that
    boundary, v into the empty side. radius: of what is looked at. snap: suggestions whose
    corners are this near to each other's are one.

    Differs from the released program, which shows the largest window's patch first even where
    it is a triangle; the paper says that the largest quadrangle is.
    """
    sizes = [radius * k / SIZES for k in range(SIZES, 0, -1)]
    quads: list[Suggestion] = []
    triangles: list[Suggestion] = []
    for asked in (False, True):
        for size in sizes:
            found = suggest_patch(boundaries, size, triangle=asked, covered=covered)
            if found is None:
                continue
            kept = triangles if len(found.patch.corners) == 3 else quads
            if not any(_are_same(found, other, snap) for other in kept):
                kept.append(found)
    triangles.sort(key=lambda s: -s.size)
    return quads + triangles


def _are_same(a: Suggestion, b: Suggestion, snap: float) -> bool:
    """Are all corners within the snap radius of each other, in some rotation?"""
    one, other = a.patch.points, b.patch.points
    if len(one) != len(other):
        return False
    return any(
        bool((np.linalg.norm(one - np.roll(other, k, axis=0), axis=1) <= snap).all())
        for k in range(len(one))
    )


#: Angles on the empty side, in radians, below which a corner is sharp, and very sharp: those of
#: the authors' released program.
SHARP, VERY_SHARP = 0.66 * np.pi, 0.33 * np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Suggestion:
    """A patch that would close against boundaries.

    case:  its letter: "a", "a0", "b1" ... "k"; "loop" for a boundary that is closed already.
    patch: in the plane.
    size:  half-width of the window that it came from; set by the list.
    """

    case: str
    patch: PlanarPatch
    size: float = 0.0


@dataclass(frozen=True, eq=False)
class _PlacedSequence:
    """A sequence on its boundary, as the cases see it."""

    boundary: PlanarBoundary
    sequence: _Sequence

    def corner(self, number: int) -> PlanarCorner:
        """A point of the sequence, 0 the first and -1 the last, as a corner of the patch."""
        number %= len(self.sequence.points)
        place = float(self.sequence.places[number])
        return PlanarCorner(self.sequence.points[number], self.sequence.boundary, place)

    def placed(self, place: float) -> PlanarCorner:
        return PlanarCorner(self.boundary.at(place), self.sequence.boundary, place)

    @property
    def first(self) -> PlanarCorner:
        return self.corner(0)

    @property
    def last(self) -> PlanarCorner:
        return self.corner(-1)

    @property
    def corners(self) -> list[PlanarCorner]:
        return [self.corner(number) for number in self.sequence.corners]

    def reached(self, index: int, distance: float, *, forward: bool) -> PlanarCorner:
        """What is at this distance from a corner, on the way out; X+ and X-."""
        number = self.sequence.corners[index]
        return self.placed(self.sequence.reach(number, distance, forward=forward))

    def angles(self) -> list[float]:
        """The angle on the empty side at each corner, in radians from 0 to 2 pi.

        Between chords to the neighbouring corners, or to the vertices that the cut ends go to.
        """
        run = self.sequence
        outer = [*run.corners]
        chain = [run.before, *(run.points[k] for k in outer), run.after]
        # Where there is more than the cut edge, its end on the window's edge is the better chord.
        if outer and outer[0] > 1:
            chain[0] = run.points[0]
        if outer and outer[-1] < run.last - 1:
            chain[-1] = run.points[-1]
        found = []
        for a, b, c in zip(chain, chain[1:], chain[2:], strict=False):
            leaving, back = c - b, a - b
            turn = np.arctan2(_cross(leaving, back), leaving @ back)
            found.append(float(turn % (2.0 * np.pi)))
        return found


def _suggest(
    boundaries: list[PlanarBoundary], shown: list[_Sequence], *, triangle: bool = False
) -> Suggestion | None:
    """The patch that the sequences in a window suggest, or None.

    triangle: rather a triangle, where a sharp corner allows one.
    """
    runs = [_PlacedSequence(boundaries[sequence.boundary], sequence) for sequence in shown]
    if len(runs) == 1:
        if runs[0].sequence.whole:
            return _suggest_loop(runs[0])
        return _suggest_beside(runs[0], triangle)
    if len(runs) == 2 and not any(run.sequence.whole for run in runs):
        return None if triangle else _suggest_between(runs[0], runs[1])
    return None


def _suggest_loop(run: _PlacedSequence) -> Suggestion | None:
    corners = run.corners
    if len(corners) < 2:
        return None
    round_again = [*corners[1:], run.last]
    sides = [
        OldSide(run.sequence.boundary, a.place, b.place)
        for a, b in zip(corners, round_again, strict=True)
    ]
    return Suggestion("loop", PlanarPatch(tuple(corners), tuple((side,) for side in sides)))


def _suggest_beside(run: _PlacedSequence, triangle: bool) -> Suggestion | None:
    angles = run.angles()
    sharp = [0.0 < angle < SHARP for angle in angles]
    pointed = [0.0 < angle < VERY_SHARP for angle in angles]
    match len(angles):
        case 0:
            return None if triangle else _extrude("a", run.first, run.last, AHEAD_OF_BASE)
        case 1:
            return _one_corner(run, sharp[0], pointed[0] or triangle, triangle)
        case 2:
            return _two_corners(run, sharp, [p or triangle for p in pointed], triangle)
        case 3:
            return _three_corners(run, run.corners, sharp, pointed[1] or triangle)
        case 4:
            return _four_corners(run, sharp, pointed, triangle)
    return None


#: The height of a patch on a straight boundary, as a part of its base: as high as wide.
AHEAD_OF_BASE = 1.0


def _one_corner(
    run: _PlacedSequence, sharp: bool, pointed: bool, triangle: bool
) -> Suggestion | None:
    first, corner, last = run.first, run.corners[0], run.last
    before, after = _distance(corner, first), _distance(corner, last)
    if not sharp:
        # Differs from the released program, which has nothing here.
        if triangle:
            return None
        base = (first, corner) if before > after else (corner, last)
        return _extrude("a0", *base, AHEAD_OF_BASE)
    if pointed:
        reach = min(before, after)
        one = run.reached(0, reach, forward=False)
        other = run.reached(0, reach, forward=True)
        return _close_by_arc("b2", one, corner, other)
    opposite = PlanarCorner(first.point + last.point - corner.point)
    return _close_by_lines("b1", first, corner, last, opposite)


def _two_corners(
    run: _PlacedSequence, sharp: list[bool], pointed: list[bool], triangle: bool
) -> Suggestion | None:
    first, last = run.first, run.last
    c0, c1 = run.corners
    reach = _distance(c0, c1)
    if all(sharp):
        return None if triangle else _close_by_lines("e", first, c0, c1, last)
    if not any(sharp):
        return None if triangle else _extrude("c", c0, c1, 1.0)
    if sharp[1]:
        far = run.reached(1, reach, forward=True)
        if pointed[1]:
            return _close_by_arc("d2", c0, c1, far)
        new = PlanarCorner(c0.point + reach * _unit(last.point - c1.point))
        return _close_by_lines("d1", c0, c1, far, new)
    far = run.reached(0, reach, forward=False)
    if pointed[0]:
        return _close_by_arc("d2", far, c0, c1)
    new = PlanarCorner(c1.point + reach * _unit(first.point - c0.point))
    return _close_by_lines("d1", far, c0, c1, new)


def _three_corners(
    run: _PlacedSequence, corners: list[PlanarCorner], sharp: list[bool], pointed: bool, at: int = 0
) -> Suggestion | None:
    """corners: three in a row, the first is number ``at`` of the sequence's."""
    c0, c1, c2 = corners
    if not sharp[1] or (sharp[0] and sharp[2]):
        return None
    if sharp[0]:
        far = run.reached(at, _distance(c1, c2), forward=False)
        return _close_by_lines("g", far, c0, c1, c2)
    if sharp[2]:
        far = run.reached(at + 2, _distance(c0, c1), forward=True)
        return _close_by_lines("g", c0, c1, c2, far)
    if pointed:
        return _close_by_arc("f2", c0, c1, c2)
    new = PlanarCorner(c0.point + c2.point - c1.point)
    return _close_by_lines("f1", c0, c1, c2, new)


def _four_corners(
    run: _PlacedSequence, sharp: list[bool], pointed: list[bool], triangle: bool
) -> Suggestion | None:
    corners = run.corners
    if sharp[1] and sharp[2]:
        return None if triangle else _close_by_arc("h", *corners)
    for middle in (1, 2):
        if sharp[middle]:
            three = corners[middle - 1 : middle + 2]
            beside = [False, True, False]
            return _three_corners(run, three, beside, pointed[middle] or triangle, middle - 1)
    return None


def _suggest_between(near: _PlacedSequence, far: _PlacedSequence) -> Suggestion | None:
    """What closes between two sequences."""
    if len(near.sequence.corners) < len(far.sequence.corners):
        near, far = far, near
    if any(0.0 < angle < SHARP for run in (near, far) for angle in run.angles()):
        return None
    match len(near.sequence.corners), len(far.sequence.corners):
        case 0, 0:
            return _bridge("i", near.first, near.last, far.first, far.last)
        case 2, 0:
            c0, c1 = near.corners
            ahead = _left(c1.point - c0.point)
            apart = _measure_ahead(c0.point / 2 + c1.point / 2, ahead, far.sequence)
            # Differs from the released program, which takes the ends of the window: a fan.
            over1 = far.placed(_find_nearest(far.sequence, c1.point + apart * ahead))
            over0 = far.placed(_find_nearest(far.sequence, c0.point + apart * ahead))
            if not over1.place < over0.place:
                return None
            return _bridge("j", c0, c1, over1, over0)
        case 2, 2:
            return _bridge("k", *near.corners, *far.corners)
    return None


def _extrude(case: str, start: PlanarCorner, end: PlanarCorner, height: float) -> Suggestion:
    """A rectangle on a stretch of a boundary, on its left, ``height`` times as high as wide."""
    up = height * _distance(start, end) * _left(end.point - start.point)
    return _close_by_lines(
        case, start, end, PlanarCorner(end.point + up), PlanarCorner(start.point + up)
    )


def _close_by_lines(case: str, *corners: PlanarCorner) -> Suggestion:
    return _close(case, corners, [None] * len(corners))


def _close_by_arc(case: str, *corners: PlanarCorner) -> Suggestion:
    """A patch whose last side is an arc, upright on the sides that it joins."""
    curve = _arc(corners[-2], corners[-1], corners[0], corners[1])
    return _close(case, corners, [*[None] * (len(corners) - 1), curve])


def _bridge(
    case: str, a: PlanarCorner, b: PlanarCorner, c: PlanarCorner, d: PlanarCorner
) -> Suggestion:
    """A patch between two boundaries, from a to b and from c to d, with arcs between."""
    return _close(case, (a, b, c, d), [None, _arc(a, b, c, d), None, _arc(c, d, a, b)])


def _arc(a: PlanarCorner, b: PlanarCorner, c: PlanarCorner, d: PlanarCorner) -> NewSide:
    """An arc from b to c, upright on the sides from a to b and from c to d."""
    return make_arc(b.point, _left(b.point - a.point), c.point, -_left(d.point - c.point))


def _close(case: str, corners: Many[PlanarCorner], curves: Many[NewSide | None]) -> Suggestion:
    sides: list[Side] = []
    for k, (start, curve) in enumerate(zip(corners, curves, strict=True)):
        end = corners[(k + 1) % len(corners)]
        if curve is not None:
            sides.append(curve)
        elif (
            start.boundary is not None
            and start.boundary == end.boundary
            and start.place < end.place
        ):
            sides.append(OldSide(start.boundary, start.place, end.place))
        else:
            sides.append(make_line(start.point, end.point))
    return Suggestion(case, PlanarPatch(tuple(corners), tuple((side,) for side in sides)))


def _find_nearest(run: _Sequence, point: Points) -> float:
    """The place of a sequence nearest to a point."""
    tail, step = run.points[:-1], np.diff(run.points, axis=0)
    length = np.einsum("ij,ij->i", step, step)
    along = np.einsum("ij,ij->i", point - tail, step)
    part = np.clip(along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    k = int(np.argmin(np.linalg.norm(tail + part[:, None] * step - point, axis=1)))
    return float(run.places[k] + part[k] * (run.places[k + 1] - run.places[k]))


def _measure_ahead(start: Points, direction: Points, run: _Sequence) -> float:
    """How far a sequence is in a direction; where that misses it, how far its nearest point is."""
    offset = run.points - start
    ahead, aside = offset @ direction, _cross(direction, offset)
    crossing = np.flatnonzero((aside[:-1] <= 0.0) != (aside[1:] <= 0.0))
    hits = [
        ahead[k] + aside[k] / (aside[k] - aside[k + 1]) * (ahead[k + 1] - ahead[k])
        for k in crossing
    ]
    hits = [hit for hit in hits if hit > 0.0]
    return float(min(hits) if hits else np.linalg.norm(offset, axis=1).min())


def _distance(a: PlanarCorner, b: PlanarCorner) -> float:
    return float(np.linalg.norm(a.point - b.point))


def _unit(v: Points) -> Points:
    length = np.linalg.norm(v)
    return v / length if length > 0.0 else v


def _left(v: Points) -> Points:
    """The unit vector to the left."""
    return np.array([-v[1], v[0]]) / max(float(np.linalg.norm(v)), 1e-300)


def _cross(a: Points, b: Points) -> Points:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


#: How far a window reaches behind the boundary that it stands on, and ahead of it, as multiples
#: of its half-width.
BEHIND, AHEAD = 0.25, 2.0


@dataclass(frozen=True, slots=True)
class _Window:
    """What is looked at: abs(u) <= size, and v from -0.25 size to 2 size."""

    size: float

    @property
    def low(self) -> tuple[float, float]:
        return -self.size, -BEHIND * self.size

    @property
    def high(self) -> tuple[float, float]:
        return self.size, AHEAD * self.size

    def has(self, points: Points) -> NDArray[np.bool_]:
        """(n,) are the points in it? NaN is not."""
        return np.all((points >= self.low) & (points <= self.high), axis=1)

    def leaves(self, inside: Points, outside: Points) -> float:
        """Which part of the way from a point inside to one outside is inside."""
        step = outside - inside
        parts = [1.0]
        for k in range(2):
            room = (self.high[k] if step[k] > 0.0 else self.low[k]) - inside[k]
            if abs(room) < abs(step[k]):
                parts.append(room / step[k])
        return max(0.0, min(parts))


@dataclass(frozen=True, eq=False)
class _Sequence:
    """A run of edges of a boundary, each with an end in the window.

    boundary: its number. places: (m,) float64, ascending, of its points on the boundary; the
    first and the last may be within an edge, where the window cuts it. points: (m, 2) float64.
    corners:  numbers of the points strictly between the ends at which corners are.
    before, after: (2,) float64, the vertices that the cut edges come from and go to, which tell
    the directions of these edges even where next to nothing of them is left.
    whole:    is it all of a closed boundary? Its last point is then its first again.

    Differs from the released program: runs end on the edge of the window, not a vertex beyond,
    so that a suggestion does not depend on where vertices happen to be.
    """

    boundary: int
    places: NDArray[np.float64]
    points: Points
    corners: tuple[int, ...]
    before: Points
    after: Points
    whole: bool = False

    @property
    def first(self) -> int:
        """The number of the first point."""
        return 0

    @property
    def last(self) -> int:
        """The number of the last point."""
        return len(self.points) - 1

    def reach(self, corner: int, distance: float, *, forward: bool) -> float:
        """The place at this distance from a corner, on the way out; the end if all is nearer.

        corner: number of a point.
        """
        order = range(corner + 1, len(self.points)) if forward else range(corner - 1, -1, -1)
        centre, near = self.points[corner], corner
        for k in order:
            if np.linalg.norm(self.points[k] - centre) >= distance:
                start, step = self.points[near] - centre, self.points[k] - self.points[near]
                # The greater root of |start + t step| = distance: the way out.
                a, b = step @ step, start @ step
                c = start @ start - distance * distance
                t = (-b + np.sqrt(max(b * b - a * c, 0.0))) / a
                return float(self.places[near] + t * (self.places[k] - self.places[near]))
            near = k
        return float(self.places[near])


def _find_sequences(boundaries: list[PlanarBoundary], window: _Window) -> list[_Sequence]:
    """All sequences of the boundaries in a window."""
    return [
        run
        for number, boundary in enumerate(boundaries)
        for run in _find_runs(number, boundary, window)
    ]


def _find_runs(number: int, boundary: PlanarBoundary, window: _Window) -> Iterator[_Sequence]:
    points, n = boundary.points, len(boundary.points)
    inside = window.has(points)
    if n < 2 or not inside.any():
        return
    known = np.isfinite(points).all(axis=1)
    shown = (inside | np.roll(inside, -1)) & known & np.roll(known, -1)
    if not boundary.closed:
        shown[-1] = False
    if shown.all():
        # All of a closed boundary: from its first corner around to it again.
        at = np.flatnonzero(boundary.corner)
        start = int(at[0]) if len(at) else 0
        order = (start + np.arange(n + 1)) % n
        yield _Sequence(
            number,
            start + np.arange(n + 1, dtype=np.float64),
            points[order],
            tuple(int(k) for k in np.flatnonzero(boundary.corner[order][:-1])),
            points[order[-2]],
            points[order[1]],
            whole=True,
        )
        return
    begins = np.flatnonzero(shown & ~np.roll(shown, 1))
    for begin in begins:
        length = 0
        while shown[(begin + length) % n]:
            length += 1
        yield _cut_run(number, boundary, window, int(begin), length)


def _cut_run(
    number: int, boundary: PlanarBoundary, window: _Window, begin: int, length: int
) -> _Sequence:
    """The run of ``length`` edges from vertex ``begin`` on, ends cut on the window's edge."""
    n = len(boundary.points)
    order = (begin + np.arange(length + 1)) % n
    points = boundary.points[order]
    places = begin + np.arange(length + 1, dtype=np.float64)
    corners = np.flatnonzero(boundary.corner[order])
    before, after = points[0].copy(), points[-1].copy()
    inside = window.has(points[[0, -1]])
    if not inside[0]:
        part = window.leaves(points[1], points[0])
        places[0] = places[1] - part
        points[0] = boundary.at(places[0]) if part < 1.0 else before
    if not inside[1]:
        part = window.leaves(points[-2], points[-1])
        places[-1] = places[-2] + part
        points[-1] = boundary.at(places[-1]) if part < 1.0 else after
    between = tuple(int(k) for k in corners if 0 < k < length)
    return _Sequence(number, places, points, between, before, after)
