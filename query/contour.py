"""A boundary that is being edited: its sides as they were drawn, and what may change."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, sample_polyline
from query.boundary import Boundary, CornerKind
from query.stroke import Stroke

#: Edges around a boundary that was just drawn, about: few enough for fills to come at once.
EDGES = 24

#: Radians by which a drawn boundary turns to the right at a corner that is taken for a reflex
#: one. An angle above 180 degrees is nearer to the 270 of three quads than to the 90 of one; a
#: straight corner that was clicked not quite straight stays convex.
REFLEX_TURN = math.radians(10.0)


#: Times that edge counts are scaled until rounding does not undo it: 2 edges become 4 by a
#: fourth of 1.25.
SCALINGS = 6

#: A drawn stroke gives way to the way to the middle of its boundary edges for so many times the
#: length of that.
EASE = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """Sides, corners and edge counts, which need not be a boundary yet.

    sides:   a (k, 3) float64 polyline per side, counter-clockwise.
    corners: the kind of the corner where each side begins; none for one closed side.
    lengths: edges of every side. Their sum may be odd while they are changed one by one.
    placed:  are the points of a side the boundary's vertices, as long as its edges are as many?
    """

    sides: tuple[Points, ...]
    corners: tuple[CornerKind, ...]
    lengths: tuple[int, ...]
    placed: bool = False

    @classmethod
    def of(cls, boundary: Boundary) -> Contour:
        """From a boundary whose vertices are placed."""
        assert boundary.points is not None
        ring = np.concatenate([boundary.points, boundary.points[:1]])
        start = boundary.side_starts
        sides = [ring[a : b + 1] for a, b in pairwise(start)]
        return cls(tuple(sides), boundary.corners, boundary.lengths, placed=True)

    @classmethod
    def drawn(cls, sides: Sequence[Points], normals: Points) -> Contour:
        """From polylines that were drawn, the base's normals (n, 3) where they begin.

        Those that run clockwise are turned round; corners that turn to the right are reflex.
        """
        sides = list(sides)
        ring = np.concatenate([side[:-1] for side in sides])
        spokes = ring - ring.mean(axis=0)
        area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
        if float(area @ normals.sum(axis=0)) < 0.0:
            sides = [side[::-1] for side in reversed(sides)]
            # Side i now begins where side n - 1 - i ended.
            normals = np.roll(normals[::-1], 1, axis=0)
        kinds: list[CornerKind] = []
        for i, side in enumerate(sides):
            arriving = sides[i - 1][-1] - sides[i - 1][-2]
            leaving = side[1] - side[0]
            across = float(np.cross(arriving, leaving) @ normals[i])
            turn = math.atan2(across, float(arriving @ leaving))
            kinds.append("reflex" if turn < -REFLEX_TURN else "convex")
        around = sum(float(arc_length(side)[-1]) for side in sides)
        lengths = Boundary.from_polylines(sides, edge_length=around / EDGES).lengths
        return cls(tuple(sides), tuple(kinds), lengths)

    def boundary(self) -> Boundary:
        """The boundary, its vertices at equal distances along each side.

        Raises InvalidBoundaryError for an odd perimeter, say.
        """
        along: list[Points] = []
        for side, length in zip(self.sides, self.lengths, strict=True):
            kept = self.placed and len(side) == length + 1
            along.append((side if kept else sample_polyline(side, length))[:-1])
        return Boundary(self.lengths, self.corners, np.concatenate(along))

    def lengthened(self, side: int, by: int) -> Contour:
        """With more or fewer edges on a side, at least 1."""
        lengths = list(self.lengths)
        lengths[side] = max(1, lengths[side] + by)
        return replace(self, lengths=tuple(lengths))

    def list_even_lengths(self) -> list[tuple[int, int]]:
        """List (side, edges) that make an odd perimeter even by one edge; none if it is even."""
        if sum(self.lengths) % 2 == 0:
            return []
        return [
            (side, length + by)
            for side, length in enumerate(self.lengths)
            for by in (-1, 1)
            if length + by >= 1
        ]

    def scaled(self, factor: float) -> Contour:
        """With about so many times the edges on all sides, and at least one more or fewer
        where that can be; raises InvalidBoundaryError for too many."""
        around = sum(float(arc_length(side)[-1]) for side in self.sides)
        by = factor
        for _ in range(SCALINGS):
            edge_length = around / (by * sum(self.lengths))
            finer = Boundary.from_polylines(
                self.sides, edge_length=edge_length, corners=self.corners
            )
            if sum(finer.lengths) != sum(self.lengths):
                return replace(self, lengths=finer.lengths)
            by *= factor
        return self

    def toggled(self, corner: int) -> Contour:
        """With a convex corner made reflex, or a reflex one convex."""
        kinds = list(self.corners)
        kinds[corner] = "convex" if kinds[corner] == "reflex" else "reflex"
        return replace(self, corners=tuple(kinds))

    def reversed(self) -> Contour:
        """Running the other way round, so that what was outside is to be filled.

        A corner that was convex is reflex from the other side, and the other way about.
        """
        sides = tuple(side[::-1] for side in reversed(self.sides))
        kinds = self.corners[:1] + self.corners[:0:-1]
        if kinds:
            # Side i now begins where side n - 1 - i ended: at corner n - i.
            kinds = tuple[CornerKind, ...](
                "convex" if kind == "reflex" else "reflex" for kind in kinds
            )
        return Contour(sides, kinds, self.lengths[::-1], self.placed)


def make_flat_boundary(
    lengths: Sequence[int], corners: Sequence[CornerKind] | None = None
) -> Boundary:
    """Make a boundary of these edge counts in the plane: a regular polygon; with reflex corners
    these drawn in, with two sides a lens, with one or none (``corners=()``) a circle.

    Raises InvalidBoundaryError as :class:`query.Boundary` does.
    """
    asked = Boundary(lengths, corners)
    n = len(asked.lengths)
    if n < 3:
        arcs = [_arc(i, n) for i in range(n)]
        return Boundary.from_polylines(arcs, lengths=asked.lengths, corners=asked.corners)
    angle = 2.0 * math.pi * (np.arange(n) - 0.5) / n - math.pi / 2.0
    inner = max(0.15, 0.55 * math.cos(2.0 * math.pi / n))
    radius = np.array([inner if kind == "reflex" else 1.0 for kind in asked.corners])
    at = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    sides = [np.stack([a, b]) for a, b in zip(at, np.roll(at, -1, axis=0), strict=True)]
    return Boundary.from_polylines(sides, lengths=asked.lengths, corners=asked.corners)


def _arc(side: int, n_sides: int) -> Points:
    """(k, 2) a whole circle from its bottom, or one of the two sides of a lens."""
    half = math.pi if n_sides == 1 else math.pi / 3.0
    middle = math.pi / 2.0 if n_sides == 1 else math.pi * (side - 0.5)
    angle = middle + np.linspace(-half, half, 65)
    off = 0.0 if n_sides == 1 else 0.5 - side
    return np.stack([np.cos(angle), np.sin(angle) + off], axis=1)


def centre_stroke_ends(boundary: Boundary, stroke: Stroke) -> Stroke:
    """Have a drawn stroke begin and end in the middle of its boundary edges."""
    assert boundary.points is not None and stroke.points is not None
    ends: list[Points] = []
    for end in (stroke.start, stroke.end):
        assert end is not None
        at = boundary.side_starts[end[0]] + end[1]
        ends.append((boundary.points[at] + boundary.points[(at + 1) % boundary.perimeter]) / 2.0)
    # What was drawn nearer to its ends than they were off would leave a kink.
    along = arc_length(stroke.points)
    off = EASE * np.array(
        [np.linalg.norm(e - p) for e, p in zip(ends, stroke.points[[0, -1]], strict=True)]
    )
    inner = stroke.points[(along >= off[0]) & (along[-1] - along >= off[1])]
    line = np.concatenate([ends[:1], inner, ends[1:]])
    apart = [True, *(bool((a != b).any()) for a, b in pairwise(line))]
    return Stroke(stroke.start, stroke.end, line[apart])
