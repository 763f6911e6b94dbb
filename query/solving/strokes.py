"""Strokes on a pattern: which strands carry them, and the best widths under which they do.

A stroke asks for a strand of quads that leaves side a at edge i and side b at edge j, give
or take the tolerance K. If polychord q carries it, q is a strand 1 wide between two parts of
any width >= 0: x_q = u + 1 + w. The strand cuts side a in two *pieces*, of i + d and
L_a - i - 1 - d edges with \\|d\\| <= K, and side b likewise. So strokes only cut sides: what is
left is the same matching as without them, with pieces in the place of sides, and classes of
polychords that join pieces. A tolerance is one more node, of slack 2 K, joined to the two
pieces of its cut: what it gives to one it does not give to the other.

Several strokes may lie on one polychord, in any order; its two ends see that order reversed.
:func:`carry_strokes` tries every assignment of strokes to strands.

Source: Marcias et al. 2015, section 4, "Edge-flow constraints". Differs from the paper: one
system of the matching instead of an integer program per polychord, every assignment of
strokes to polychords is tried, and each of several strokes has a strand of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb.core.halfedge import Int32Array
from query.boundary import Boundary
from query.orientation import Orientation
from query.stroke import Stroke

#: Columns of strokes as a pattern sees them: side and edge of one end, and of the other.
FLOW_COLUMNS = 4


def orient_strokes(
    strokes: Sequence[Stroke], boundary: Boundary, orientation: Orientation
) -> Int32Array:
    """(s, 4) int32 side, edge, side, edge of the strokes in the pattern's own order.

    Loops are left out: no side sees them.
    """
    n = max(boundary.n_sides, 1)
    rows: list[list[int]] = []
    for stroke in strokes:
        if stroke.start is None or stroke.end is None:
            continue
        row: list[int] = []
        for side, edge in (stroke.start, stroke.end):
            if orientation.mirrored:
                row += [(orientation.rotation - side) % n, boundary.lengths[side] - 1 - edge]
            else:
                row += [(orientation.rotation + side) % n, edge]
        rows.append(row)
    return np.array(rows, np.int32).reshape(-1, FLOW_COLUMNS)
