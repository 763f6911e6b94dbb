"""Where lines of a field begin and end: at singularities, on other lines, on curves of the network.

The network's own curves are borders, the seam of symmetry, creases and what is drawn: chains that
it has before anything is drafted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from patterndb.geometry.points import Floats, Points, units
from patterndb_sketch.retopo.draft.crossfield import CrossField
from patterndb_sketch.retopo.draft.tracing import Starts
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    Chain,
    HalfChain,
    Network,
    find_nearest_place,
)
from patterndb_sketch.retopo.network.samples import Samples, take_chain_samples

#: What is on the right of a wall comes after all that is on its left: no vertex has more triangles.
BEYOND = 1e6

#: Lines end no nearer to the end of a chain than so many of its samples.
OFF_ENDS = 0.25

#: Places on a curve are equally near if their distances differ by less than this, in its lengths.
NEARLY = 1e-6

#: What ends beside a node, as far as ends are taken to it, is by this much in its order from what
#: ends at the node itself; no vertex has more triangles.
FAR = 1e3


@dataclass(frozen=True, slots=True)
class AtSingularity:
    """A node at a vertex of the field's mesh; order: where around it, counter-clockwise."""

    vertex: int
    order: float


@dataclass(frozen=True, slots=True)
class OnLine:
    """A T-junction on another line, ``there`` along it, met from its left or its right."""

    line: int
    there: float
    left: bool


@dataclass(frozen=True, slots=True)
class OnChain:
    """A node on a chain that the network has already, at a place in samples; order: of those at
    one place, counter-clockwise on their side."""

    chain: int
    place: float
    left: bool
    order: float = 0.0


@dataclass(frozen=True, slots=True)
class InWedge:
    """A node that the network has already, in the wedge on the left of one of its ends; order: of
    those in one wedge, counter-clockwise."""

    node: int
    half: HalfChain
    order: float = 0.0


@dataclass(frozen=True, eq=False)
class Constraints:
    """network: what is there. snap: what is nearer than this to a node that a drawn curve ends in
    is at the node."""

    network: Network
    snap: float = 0.0

    @cached_property
    def drawn(self) -> frozenset[int]:
        """The nodes that curves end in which are drawn."""
        return frozenset(
            node
            for chain in self.network.chains.values()
            if not (chain.marked or chain.is_closed_loop)
            for node in (chain.start, chain.end)
        )

    @cached_property
    def bare(self) -> bool:
        """Are there borders and the seam alone?"""
        return all(chain.marked for chain in self.network.chains.values())

    @cached_property
    def _samples(self) -> Samples:
        return take_chain_samples(self.network.chains)

    @cached_property
    def _tangents(self) -> Points:
        """(m, 3) where the samples go."""
        of = self._samples
        return units(np.roll(of.points, -1, axis=0) - np.roll(of.points, 1, axis=0))

    @cached_property
    def _segments(self) -> tuple[Points, Points]:
        """(m, 3) the samples, and (m, 3) the steps from them to the next of their chains."""
        of = self._samples
        after = np.arange(1, len(of.points) + 1)
        first, last = of.starts[:-1], of.starts[1:] - 1
        after[last] = np.where(of.is_closed_loop, first, last)
        return of.points, of.points[after] - of.points

    def find_place(self, point: Points, ahead: Points, middle: Points) -> OnChain | InWedge:
        """The place nearest to a point (3,) of a side of the field's mesh, where a chain runs along
        its direction (3,) or against it: of two borders that nearly touch, the one that is meant.

        middle: (3,) of that side, which tells curves apart that meet in a node."""
        of = self._samples
        if not len(of.points):
            raise RefusedError("a border of the surface is not among the curves; draw on it anew")
        if not self.bare:
            return self._find_drawn(point, ahead, middle)
        away = np.linalg.norm(of.points - point, axis=1)
        along = np.abs(self._tangents @ ahead) > 0.5 * np.linalg.norm(ahead)
        near = int(np.where(along | ~along.any(), away, np.inf).argmin())
        # Seen by the normal there, not by the mesh's: at a sharp border they may be opposed.
        found = find_nearest_place(of, point, of.normals[near], np.inf)
        assert found is not None
        chain = self.network.chains[found.chain]
        return OnChain(chain.id, _keep_off_ends(chain, found.place), chain.marks[0] == "")

    def _find_drawn(self, point: Points, ahead: Points, middle: Points) -> OnChain | InWedge:
        """See :meth:`find_place`, where curves are drawn."""
        of, (begin, step) = self._samples, self._segments
        # At the middle of the side: at its end the curve may turn, and others end. By segments:
        # the nearest sample may be a node.
        along = np.abs(step @ ahead) > 0.5 * np.linalg.norm(step, axis=1) * np.linalg.norm(ahead)
        _, away = _project_on(begin, step, middle)
        k = int(np.where(along | ~along.any(), away, np.inf).argmin())
        chain = self.network.chains[int(of.chain[k])]
        forth = bool(step[k] @ ahead > 0.0)
        mine = of.chain == chain.id
        share, away = _project_on(begin[mine], step[mine], point)
        place = of.place[mine] + share
        # Of a closed curve both ends are at one place.
        far = np.abs(place - of.place[k]) / len(place)
        there = float(place[(away + NEARLY * chain.length * far).argmin()])
        at = self._find_node(chain, point, there, 2 * chain.id + (not forth))
        if at is not None:
            return at
        # The mesh is on the left of its border's sides.
        left = chain.marks[0] == "" if chain.marked else forth
        return OnChain(chain.id, _keep_off_ends(chain, there), left)

    def _find_node(
        self, chain: Chain, point: Points, place: float, half: HalfChain
    ) -> InWedge | None:
        """The wedge at an end of a chain, if that is near and a drawn curve ends there; place: of
        the point on it. half: that has the mesh on its left."""
        if chain.is_closed_loop:
            return None
        ends = (half, half ^ 1)
        for end in ends if (place < 0.5 * chain.segments) == (half & 1 == 0) else ends[::-1]:
            node = self.network.nodes[self.network.origin(end)]
            away = float(np.linalg.norm(node.point - point))
            if node.id in self.drawn and away <= self.snap:
                # What comes to the curve further from the node lies closer beside the curve: at its
                # start first of its wedge, at its end last.
                far = FAR * away / self.snap
                if end == half:
                    return InWedge(node.id, end, -far)
                return InWedge(node.id, node.ends[node.wedge_before(end)], BEYOND + far)
        return None


def _project_on(begin: Points, step: Points, point: Points) -> tuple[Floats, Floats]:
    """Return (m,) the part of each segment at which it is nearest to a point, and (m,) how far."""
    share = np.einsum("mc,mc->m", point - begin, step)
    share = np.clip(share / np.maximum(np.einsum("mc,mc->m", step, step), 1e-300), 0.0, 1.0)
    return share, np.linalg.norm(begin + share[:, None] * step - point, axis=1)


def _keep_off_ends(chain: Chain, place: float) -> float:
    if chain.is_closed_loop:
        return place % len(chain.points)
    return min(max(place, OFF_ENDS), len(chain.points) - 1 - OFF_ENDS)


class Joints:
    """Where lines begin and end, in terms of the network."""

    def __init__(self, field: CrossField, walls: Constraints, starts: Starts) -> None:
        self.field = field
        self.walls = walls
        self.starts = starts
        self.borders: dict[int, OnChain | InWedge] = {}
        mesh = field.mesh
        begun = np.zeros(len(field.index), np.bool_)
        begun[starts.vertex] = True
        for vertex in np.flatnonzero(mesh.on_border & ((field.index != 0) | begun)).tolist():
            self.borders[vertex] = self.on_border(mesh.vertices[vertex], int(mesh.leaving[vertex]))

    def start(
        self, k: int, led: tuple[int, Points] | None = None
    ) -> AtSingularity | OnChain | InWedge:
        """The joint of a start; led: the triangle and the point that an arc goes to from there,
        which need not be where the trace would have gone."""
        mesh = self.field.mesh
        vertex, triangle = int(self.starts.vertex[k]), int(self.starts.triangle[k])
        corner, angle = int(self.starts.corner[k]), float(self.starts.angle[k])
        if led is not None:
            triangle = led[0]
            corner = int(np.flatnonzero(mesh.triangles[triangle] == vertex)[0])
            away = led[1] - mesh.vertices[vertex]
            angle = float(np.arctan2(away @ mesh.y[triangle], away @ mesh.x[triangle]))
        turned = (angle - mesh.side_angle[triangle, corner] + 0.1) % (2.0 * np.pi) - 0.1
        share = min(max(turned / mesh.corner_angle[triangle, corner], 0.0), 1.0)
        order = mesh.list_ring(vertex).index(3 * triangle + corner) + share
        if vertex in self.borders:
            at = self.borders[vertex]
            return replace(at, order=order + (at.order if isinstance(at, InWedge) else 0.0))
        return AtSingularity(vertex, order)

    def on_border(self, point: Points, side: int) -> OnChain | InWedge:
        """The place of the network's border chains that a place on a border's side is."""
        mesh = self.field.mesh
        f, e = divmod(side, 3)
        tail, head = mesh.vertices[mesh.triangles[f, [e, (e + 1) % 3]]]
        return self.walls.find_place(point, head - tail, 0.5 * (tail + head))

    def corners(self) -> list[OnChain | InWedge]:
        """Border vertices with one wedge, which no line leaves."""
        return [at for vertex, at in self.borders.items() if self.field.index[vertex] == 1]
