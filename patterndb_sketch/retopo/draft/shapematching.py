"""Shape matching: where vertices are to go for quads to become squares of about one size.

Every quad draws its vertices towards the square that fits it best in the least-squares sense.
"""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.quadshape import scaled_jacobian

#: The size of a quad's square is this share its own, and else the mean of all.
OWN_SIZE = 0.3

#: Quads with a scaled Jacobian below POOR weigh more, up to MOST times.
POOR, MOST = 0.6, 12.0


def match_squares(at: Points, quads: Int32Array, edge: float) -> Points:
    """Return (v, 3) where vertices are to go: the weighted mean of the corners of their squares.

    at: (v, 3) where they are; those of no quad stay. quads: (q, 4). edge: the mean edge length.
    """
    corner = at[quads]
    middle = corner.mean(axis=1)
    # Half diagonals; the square's are turned into each other by a right angle.
    one, two = 0.5 * (corner[:, 0] - corner[:, 2]), 0.5 * (corner[:, 1] - corner[:, 3])
    normal = units(np.cross(one, two))
    one = 0.5 * (one + np.cross(two, normal))
    own = np.linalg.norm(one, axis=1, keepdims=True)
    wanted = OWN_SIZE * own + (1.0 - OWN_SIZE) * edge / np.sqrt(2.0)
    one = one * (wanted / np.maximum(own, 1e-300))
    two = np.cross(normal, one)
    poor = np.clip((POOR - scaled_jacobian(quads, at)) / POOR, 0.0, 1.0)
    weight = 1.0 + (MOST - 1.0) * poor
    drawn = np.stack([middle + one, middle + two, middle - one, middle - two], axis=1)
    total = _sum_at(quads, weight[:, None, None] * drawn, len(at))
    count = np.bincount(quads.ravel(), np.repeat(weight, 4), len(at))[:, None]
    return np.where(count > 0.0, total / np.maximum(count, 1e-300), at)


def mean_normals(at: Points, quads: Int32Array) -> Points:
    """Return (v, 3) unit normals of the quads around each vertex.

    Projection by them brings back what had landed on the other side of a thin plate, where the
    surface's own normal would keep it.
    """
    corner = at[quads]
    across = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    return units(_sum_at(quads, np.repeat(across[:, None], 4, axis=1), len(at)))


def _sum_at(quads: Int32Array, values: Floats, n: int) -> Floats:
    """Return (n, 3) sums of values (q, 4, 3) over the vertices of quads."""
    flat = values.reshape(-1, 3)
    total = np.stack([np.bincount(quads.ravel(), flat[:, c], n) for c in range(3)], axis=1)
    return total.astype(np.float64, copy=False)
