"""The card of a fill: in the outline of its boundary, the strokes asked for marked on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from query import Boundary, Fill, Stroke
from query.contour import make_flat_boundary
from query.placing import place
from query.placing.strands import find_carriers, locate_edge
from viewer.card import Card
from viewer.drawing import StrokeMark


def make_fill_card(
    fill: Fill,
    boundary: Boundary,
    strokes: Sequence[Stroke] = (),
    tolerance: int = 0,
    *,
    rank: int | None = None,
    facts: str | None = None,
) -> Card:
    """Make the card of a fill of a boundary, the strokes asked for marked on it.

    Where the boundary has reflex corners, all its fills have one outline, the boundary's; drawn by
    its own corners each would bend in a way of its own. tolerance: see :func:`query.fills`.
    """
    card = Card.of_disk(fill.disk(), fill.pattern.name, rank, facts)
    points = None if boundary.convex else lay_within(fill, boundary)
    return replace(card, points=points, marks=mark_strokes(fill, strokes, tolerance))


def lay_within(fill: Fill, boundary: Boundary) -> Points:
    """Lay out (v, 2) float64 a fill's vertices within the flat outline of its boundary."""
    outline = make_flat_boundary(boundary.lengths, boundary.corners).points
    assert outline is not None
    return place(fill, outline).vertices[:, :2]


def mark_strokes(fill: Fill, strokes: Sequence[Stroke], tolerance: int) -> tuple[StrokeMark, ...]:
    """Mark strokes on a fill, each with a strand of its own; tolerance: edges it may be off."""
    marks: list[StrokeMark] = []
    for stroke, strand in zip(strokes, find_carriers(fill, strokes, tolerance), strict=True):
        asked = [locate_edge(fill.lengths, e) for e in (stroke.start, stroke.end) if e is not None]
        ends = [(at, (at + 1) % fill.perimeter) for at in asked]
        edges = np.zeros((0, 2), np.int32)
        if strand is not None:
            again = strand.edges[:1] if strand.is_loop else strand.edges[:0]
            edges = np.concatenate([strand.edges, again])
        marks.append(StrokeMark(np.array(ends, np.int32).reshape(-1, 2), edges))
    return tuple(marks)
