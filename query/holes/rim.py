"""What a fill may not join: vertices of a loop that the mesh around it joins already.

An edge has two faces. Where an edge of the mesh leads from one vertex of a loop to another, across
a neck or a corner outside, quads within that join the two as well would make it four.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.holes.loops import Hole


@dataclass(frozen=True, slots=True, eq=False)
class HoleRim:
    """A loop, and which of its places are joined outside.

    loop:   (L,) int32 vertices. joined: (L, L) bool, does the mesh join two places that are not
            next to each other, or are they one vertex?
    bound:  is any pair joined? twice: does the loop run through a vertex twice?
    """

    loop: Int32Array
    joined: NDArray[np.bool_]
    bound: bool
    twice: bool

    @classmethod
    def of(cls, hole: Hole) -> HoleRim:
        """Of a hole; faces that are made anew join nothing."""
        topology, loop = hole.topology, hole.loop
        n = len(loop)
        kept = np.ones(topology.mesh.n_faces, np.bool_)
        kept[hole.removed] = False
        near = np.isin(topology.tail, loop) & np.isin(topology.head, loop) & kept[topology.face]
        names, name = np.unique(loop, return_inverse=True)
        one = np.searchsorted(names, topology.tail[near])
        two = np.searchsorted(names, topology.head[near])
        by_name = np.eye(len(names), dtype=np.bool_)
        by_name[one, two] = by_name[two, one] = True
        joined = by_name[name][:, name]
        place = np.arange(n)
        for step in (-1, 0, 1):
            joined[place, (place + step) % n] = False
        return cls(loop, joined, bool(joined.any()), len(names) < n)

    def admits(self, quads: Int32Array) -> bool:
        """May these quads (q, 4), loop vertices 0 to L - 1, inner ones after, be welded in?"""
        if not self.bound:
            return True
        n = len(self.loop)
        a, b = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
        within = (a < n) & (b < n)
        if self.joined[a[within], b[within]].any():
            return False
        if not self.twice:
            return True
        # Two edges of the fill may be one where their ends are one vertex.
        top = int(quads.max()) + 1
        name = np.arange(top)
        name[:n] = np.unique(self.loop, return_inverse=True)[1]
        name[n:] += n
        a, b = name[a], name[b]
        _, uses = np.unique(np.minimum(a, b) * (top + n) + np.maximum(a, b), return_counts=True)
        return bool(uses.max() <= 2)
