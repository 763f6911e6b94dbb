"""Fills that are paved from the loop inwards, ring by ring.

The quads at the loop's vertices determine all quads that touch the loop: a ring. What the ring
leaves is a loop, too. Where every vertex of it gets what makes it regular, the next ring follows,
and so on until a fill with one irregular vertex, or none, fits the rest. One ring alone leaves a
loop that a regular fill or a pattern of holes fills; so fills are found whose pattern no mesh has
shown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb._native.query.holes.rings import pave
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

#: Part of artists' vertices at which c quads of the ring and 1 to 4 quads within it meet, by c = 1
#: to 6 (rows): measured behind the rims of 4,513 holes that scripts/cut_holes.py cut into 40 of the
#: meshes that scripts/train_holes.py learns from; what was not met counts as .001.
WITHIN = np.array(
    [
        [0.001, 0.624, 0.353, 0.022],
        [0.127, 0.858, 0.013, 0.002],
        [0.917, 0.071, 0.011, 0.001],
        [0.648, 0.349, 0.002, 0.001],
        [0.864, 0.134, 0.001, 0.001],
        [0.863, 0.135, 0.001, 0.001],
    ]
)

#: More rings than any loop has room for.
_ALL = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class QuadRing:
    """The quads that touch a loop, and the loop that they leave.

    quads: (q, 4) int32, loop vertices 0..L-1, others from L on. inner: (m,) int32 the vertices of
    the loop that is left, in order; none where the ring fills the loop. counts: (m,) int32 quads of
    the ring at each. n_vertices: of loop and ring.
    """

    quads: Int32Array
    inner: Int32Array
    counts: Int32Array
    n_vertices: int

    def log_within(self) -> Floats:
        """(m, 4) log of the part of vertices that get 1 to 4 quads within."""
        return np.log(WITHIN[np.minimum(self.counts, len(WITHIN)) - 1])

    def join(self, quads: Int32Array) -> Int32Array:
        """(q, 4) the ring's quads, and those of a fill of the loop that is left, in its numbers."""
        m = len(self.inner)
        far = np.arange(max(int(quads.max()) + 1, m))
        names = np.where(far < m, self.inner[np.minimum(far, m - 1)], far - m + self.n_vertices)
        return np.concatenate([self.quads, names[quads]]).astype(np.int32)


def lay_ring(corners: Int32Array) -> QuadRing | None:
    """Return the ring of the quads at each vertex of a loop, none of which are joined needlessly.

    corners: (L,) 1 to 4, L even. None where there is no such ring.
    """
    quads, inner, counts, n_vertices = pave(np.ascontiguousarray(corners, np.int32), 1)
    return QuadRing(quads, inner, counts, n_vertices) if n_vertices else None


def pave_loop(corners: Int32Array) -> tuple[Int32Array, int] | None:
    """Return the fill of rings that has these quads at each loop vertex: quads (q, 4) int32, loop
    vertices 0..L-1, inner ones after, and how many vertices; None where paving does not end.

    corners: (L,) 1 to 4, L even. Most fills with one irregular vertex inside are found so.
    """
    quads, inner, _, n_vertices = pave(np.ascontiguousarray(corners, np.int32), _ALL)
    return (quads, n_vertices) if n_vertices and not len(inner) else None
