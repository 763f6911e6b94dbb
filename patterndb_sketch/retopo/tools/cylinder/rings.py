"""Rings: closed loops with nothing on their left yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.network import HalfChain, Network, dead_end, face
from patterndb_sketch.retopo.tools.around import Edge, edge_of


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A closed loop of half-chains without a patch on its left.

    edge:    its half-chains, vertices and where its nodes are.
    lengths: (n + 1,) float64 arc length at every vertex, and all around.
    """

    edge: Edge
    lengths: NDArray[np.float64]

    @property
    def corners(self) -> NDArray[np.intp]:
        """(c,) the numbers of the vertices that are nodes."""
        return np.flatnonzero(self.edge.corner)

    def fractions(self, start: int, *, backwards: bool) -> NDArray[np.float64]:
        """(n,) of every vertex the part of the way round to it from ``start`` on."""
        whole = self.lengths[-1]
        way = (self.lengths[:-1] - self.lengths[start]) / whole
        return (-way if backwards else way) % 1.0

    def place(self, start: int, fraction: float, *, backwards: bool) -> float:
        """The place, in vertices, this part of the way round from a vertex on."""
        n, whole = len(self.edge.points), self.lengths[-1]
        length = self.lengths[start] + (-fraction if backwards else fraction) * whole
        return float(np.interp(length % whole, self.lengths, np.arange(n + 1.0)))


def rings(network: Network) -> list[Ring]:
    """All rings of a network, those of lower half-chains first."""
    taken = network.patch_of()
    done: set[HalfChain] = set()
    found: list[Ring] = []
    for chain in sorted(network.chains):
        for half in (2 * chain, 2 * chain + 1):
            if half in done or half in taken:
                continue
            loop, _ = face(network.nodes, network.chains, half)
            done.update(loop)
            if dead_end(network.nodes, network.chains, loop):
                continue
            if any(network.mark(one) for one in loop):
                continue
            edge = edge_of(network, list(loop), closed=True)
            around = np.concatenate([edge.points, edge.points[:1]])
            found.append(Ring(edge, arc_length(around)))
    return found


def ring_at(
    found: list[Ring], point: Points, normal: Points, direction: Points, snap: float
) -> tuple[Ring, int] | None:
    """The ring nearest to an end of a stroke, and the vertex it snaps to, or None.

    point, normal: (3,) of the end; direction: (3,) into the stroke. The stroke must lie on the
    ring's left. Of a ring with nodes only those count. The radius is ``snap``.
    """
    best, at = snap, None
    for ring in found:
        points = ring.edge.points
        along = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
        inward = np.einsum("nc,nc->n", np.cross(along, direction), ring.edge.normals)
        away = np.linalg.norm(points - point, axis=1)
        away[(inward <= 0.0) | (ring.edge.normals @ normal <= 0.0)] = np.inf
        if ring.edge.corner.any():
            away[~ring.edge.corner] = np.inf
        k = int(np.argmin(away))
        if away[k] < best or (at is None and away[k] <= best):
            best, at = float(away[k]), (ring, k)
    return at
