"""The question in the patterns' own terms: lengths, weights and strokes per orientation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary
from query.orientation import orientations, sides_seen
from query.solving.batch import Asked
from query.solving.evenness import MAX_WEIGHT
from query.solving.flow import flows_seen
from query.stroke import Stroke

#: The weight of a square where all edges are equally long: fine enough to tell proportions.
EVEN_WEIGHT = 16


def asked(boundary: Boundary, strokes: Sequence[Stroke], tolerance: int) -> Asked:
    """The boundary and the strokes in every orientation; see :mod:`query.orientation`."""
    n = max(boundary.n_sides, 1)
    sides = sides_seen(n)
    lengths = np.array(boundary.lengths, np.int32)
    weights = side_weights(boundary)
    return Asked(
        lengths=np.ascontiguousarray(lengths[sides]),
        weights=np.ascontiguousarray(weights[sides[:, :, None], sides[:, None, :]]),
        flows=np.stack([flows_seen(strokes, boundary, o) for o in orientations(n)]),
        tolerance=tolerance,
    )


def side_weights(boundary: Boundary) -> Int32Array:
    """(n, n) int32: what the square of a width counts for strands between two sides.

    1 where the boundary has no points. Else in proportion to the sum of the squares of the
    sides' edge lengths: then the most even widths are those that take equal lengths of the
    boundary, not equal numbers of edges.
    """
    n = len(boundary.lengths)
    if boundary.points is None:
        return np.ones((n, n), np.int32)
    steps = np.linalg.norm(np.roll(boundary.points, -1, axis=0) - boundary.points, axis=1)
    starts = np.array(boundary.side_starts)
    squares = (np.add.reduceat(steps, starts[:-1]) / np.diff(starts)) ** 2
    sums = squares[:, None] + squares[None, :]
    weights = np.rint(EVEN_WEIGHT * sums / (2 * squares.mean()))
    return np.clip(weights, 1, MAX_WEIGHT).astype(np.int32)
