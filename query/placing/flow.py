"""How well the strands of a placed fill follow the strokes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from patterndb._native.query.placing.flow import (
    list_loop_targets,
    list_open_targets,
    measure_loop_distance,
    measure_open_distance,
)
from patterndb._native.query.placing.strands import find_far_ends
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from patterndb.system.numbers import TOLERANCE
from query.placing.strands import (
    SidedDisk,
    assign_strands,
    find_strand_edges,
    list_loop_chains,
    locate_span,
    walk_strand,
)
from query.stroke import Stroke

#: Places along a stroke where its distance to a midline is measured, at the middles of as
#: many equal parts.
SAMPLES = 64


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """A stroke and the strand that carries it.

    stroke:   the stroke; it has points.
    edges:    (m, 2) int32 vertices of the strand's transversal edges, in the stroke's sense.
    targets:  (m, 3) float64, where the middle of each edge lies on the stroke, both by arc
              length. For a loop the edges begin anywhere, and so do the targets.
    distance: integral of the distance over the stroke's length.
    mean, most: the mean and the greatest distance over the stroke.
    """

    stroke: Stroke
    edges: Int32Array
    targets: Points
    distance: float
    mean: float
    most: float

    @classmethod
    def between(cls, stroke: Stroke, edges: Int32Array, vertices: Points) -> Following:
        """Of a stroke with points and the transversal edges (m, 2) of a strand."""
        assert stroke.points is not None
        middle = vertices[edges].mean(axis=1)
        if not stroke.is_loop:
            distance, mean, most = measure_open_distance(stroke.points, middle)
            targets = list_open_targets(stroke.points, middle)
            return cls(stroke, edges, targets, distance, mean, most)
        distance, mean, most, offset, against = measure_loop_distance(stroke.points, middle)
        if against:
            # Turned about, the first edge stays first and the others come in reverse.
            edges = np.ascontiguousarray(np.roll(edges[::-1], 1, axis=0)[:, ::-1])
            middle = vertices[edges].mean(axis=1)
        targets = list_loop_targets(stroke.points, middle, offset)
        return cls(stroke, edges, targets, distance, mean, most)

    def partly(self, vertices: Points, part: float) -> Following:
        """With targets only a part of the way from where the midline is now."""
        middle = vertices[self.edges].mean(axis=1)
        return replace(self, targets=middle + part * (self.targets - middle))


def measure_flow_distance(
    fill: SidedDisk, vertices: Points, strokes: Sequence[Stroke], tolerance: int = TOLERANCE
) -> float:
    """How far the strokes are from the strands that carry them best; smaller is better.

    vertices: (v, 3) float64, the placed fill; tolerance: edges that a strand's end may be off
    its stroke's. For every stroke that has points: the integral, over the stroke's length, of
    its distance to the strand's midline, both by arc length, for the nearest of the strands
    that may carry it. Several strokes are carried by different strands, so that the sum is
    least. ``math.inf`` where there are not enough.

    Source: Marcias et al. 2015, section 4, "Sorting". Differs from the paper: two strokes
    never count with the same strand, as no fill has them on one.
    """
    followed = follow_strokes(fill, vertices, strokes, tolerance)
    total = 0.0
    for stroke, one in zip(strokes, followed, strict=True):
        if stroke.points is not None:
            total += math.inf if one is None else one.distance
    return total


def follow_strokes(
    fill: SidedDisk,
    vertices: Points,
    strokes: Sequence[Stroke],
    tolerance: int,
    beside: Neighbours | None = None,
) -> list[Following | None]:
    """The strand of every stroke; None for a stroke without points or without a strand.

    Arguments as in :func:`measure_flow_distance`; beside: the fill's neighbours, if they are known.
    """
    result: list[Following | None] = [None] * len(strokes)
    drawn = [i for i, stroke in enumerate(strokes) if stroke.points is not None]
    if not drawn:
        return result
    beside = beside or Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
    choices = [_costs(fill, vertices, fill.lengths, strokes[i], tolerance, beside) for i in drawn]
    costs = [{name: distance for name, (distance, _) in choice.items()} for choice in choices]
    for i, name, choice in zip(drawn, assign_strands(costs), choices, strict=True):
        if name is not None:
            edges = find_strand_edges(fill.quads, choice[name][1])
            result[i] = Following.between(strokes[i], edges, vertices)
    return result


def _costs(
    fill: SidedDisk,
    vertices: Points,
    lengths: tuple[int, ...],
    stroke: Stroke,
    tolerance: int,
    beside: Neighbours,
) -> dict[int, tuple[float, Int32Array]]:
    """Integral distance and half-edges of every strand that may carry a stroke, by the
    strand's name: its lowest half-edge."""
    assert stroke.points is not None
    found: dict[int, tuple[float, Int32Array]] = {}
    if stroke.start is None or stroke.end is None:
        chains = list_loop_chains(beside.twin)
    else:
        first = locate_span(lengths, stroke.start, tolerance)
        last = locate_span(lengths, stroke.end, tolerance)
        far = find_far_ends(beside.twin, beside.border)
        chains = [
            walk_strand(beside.twin, int(beside.border[at]))
            for at in range(*first)
            if last[0] <= far[at] < last[1]
        ]
    for chain in chains:
        middle = vertices[find_strand_edges(fill.quads, chain)].mean(axis=1)
        if stroke.is_loop:
            distance, _, _, _, _ = measure_loop_distance(stroke.points, middle)
        else:
            distance, _, _ = measure_open_distance(stroke.points, middle)
        # A strand from one span to the same span is met from both its ends.
        name = int(min(chain.min(), (chain ^ 2).min()))
        if name not in found or distance < found[name][0]:
            found[name] = distance, chain
    return found
