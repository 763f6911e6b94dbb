"""Close a patch: boundaries of the network around a place, and a planar patch made part of it.

For the tools that plan a patch in the plane (:mod:`patterndb_sketch.retopo.tools.planar`):
:func:`find_boundaries` finds what they snap to, :func:`map_boundaries` takes it to the plane, and
:func:`close_patch` makes curves and a patch of the network of what they planned.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    AtChain,
    AtNode,
    Edit,
    HalfChain,
    Network,
    NetworkBuilder,
    find_successor,
)
from patterndb_sketch.retopo.network.structure import NONE
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.planar import (
    NewSide,
    OldSide,
    PlanarBoundary,
    PlanarCorner,
    PlanarPatch,
)
from patterndb_sketch.retopo.tracing import LocalMap

#: How far behind its first place a stretch of a boundary is looked at, in samples, to see which
#: chain it runs along: beyond where a cut may have been moved to a sample.
BEYOND = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class PlannedPatch:
    """A patch that is planned, for the network that it was planned for: what a preview shows.

    edges: the boundaries that the patch's numbers mean. onto: the map that it is in the plane of.
    case:  of what was suggested, its letter; see
           :class:`~patterndb_sketch.retopo.tools.suggestions.Suggestion`.
    """

    patch: PlanarPatch
    edges: tuple[SurfaceBoundary, ...]
    onto: LocalMap
    case: str = ""

    def is_on_surface(self, sizes: Sizes) -> bool:
        """Does its map have surface under all of its new curves?"""
        lines = (sample_line(line, sizes.sampling) for line in self.patch.curves)
        return all(self.onto.at(line)[1].all() for line in lines)

    def curves(self, sizes: Sizes) -> list[Points]:
        """Its new curves on the surface, each (m, 3)."""
        return [
            lift_to_surface(self.onto, sample_line(line, sizes.sampling))[0]
            for line in self.patch.curves
        ]

    def corners(self) -> Points:
        """(k, 3) its corners on the surface."""
        return lift_to_surface(self.onto, self.patch.points)[0]


def close_patch(network: Network, planned: PlannedPatch, sizes: Sizes) -> Edit:
    """The network with a planned patch's curves, and with the patch.

    The patch's corners are corners of it alone: where new curves meet a boundary those behind
    have T-junctions, and nodes within its sides are T-junctions for it.
    Raises RefusedError if a new curve leaves the map, or the loop does not close.
    """
    patch, edges, onto = planned.patch, planned.edges, planned.onto
    builder = NetworkBuilder(network)
    parts = _list_parts(patch)
    if has_short_stretch(patch):
        raise RefusedError("two corners of the patch would be in one place; take a wider brush")
    # Places first: cutting later would move them.
    nodes = [_make_node(builder, network, corner, edges, onto) for corner, _, _ in parts]
    inner = [_list_within(network, part, edges) for _, part, _ in parts]
    leaving: list[HalfChain] = []
    for k, (_, part, _) in enumerate(parts):
        start, end = nodes[k], nodes[(k + 1) % len(nodes)]
        if isinstance(part, NewSide):
            points = lift_to_surface(onto, sample_line(part.points, sizes.sampling))
            leaving.append(2 * builder.add_chain(*points, AtNode(start), AtNode(end)))
        else:
            leaving.append(_find_leaving(builder, network, edges[part.boundary], part))
    for half in (half for halves in inner for half in halves):
        builder.flag(half, False)
    for half, (_, _, corner) in zip(leaving, parts, strict=True):
        builder.flag(half, corner)
    try:
        after = builder.finish(also=leaving[:1])
    except InvalidRetopoError as error:
        raise RefusedError(
            f"the curves would not close to a patch ({error}); draw it a little elsewhere"
        ) from error
    return Edit.of(network, after, builder.notes)


def has_short_stretch(patch: PlanarPatch) -> bool:
    """Is a stretch of a boundary so short that its ends would be one place?"""
    old = [part for part in patch.parts if isinstance(part, OldSide)]
    return any(part.end - part.start < 2.0 * BEYOND for part in old)


def lift_to_surface(onto: LocalMap, line: Points) -> tuple[Points, Points]:
    """(m, 3) points and normals of a line in the plane; RefusedError where there is no surface."""
    feet, found = onto.at(line)
    if not found.all():
        raise RefusedError(
            "the patch would reach beyond the surface, or around something too sharply; draw it "
            "elsewhere, or take a smaller brush"
        )
    return feet.points, feet.normals


def _list_parts(patch: PlanarPatch) -> list[tuple[PlanarCorner, OldSide | NewSide, bool]]:
    """Each part of the patch's border: where it begins, and is that a corner of the patch?"""
    found: list[tuple[PlanarCorner, OldSide | NewSide, bool]] = []
    for corner, side in zip(patch.corners, patch.sides, strict=True):
        at = corner
        for number, part in enumerate(side):
            if isinstance(part, OldSide):
                at = PlanarCorner(at.point, part.boundary, part.start)
            found.append((at, part, number == 0))
            if isinstance(part, OldSide):
                at = PlanarCorner(at.point, part.boundary, part.end)
            else:
                at = PlanarCorner(part.points[-1])
    return found


def _make_node(
    builder: NetworkBuilder,
    network: Network,
    corner: PlanarCorner,
    edges: Sequence[SurfaceBoundary],
    onto: LocalMap,
) -> int:
    if corner.boundary is not None:
        return edges[corner.boundary].make_node(builder, network, corner.place)
    points, normals = lift_to_surface(onto, corner.point[None])
    return builder.add_node(points[0], normals[0])


def _list_within(
    network: Network, part: OldSide | NewSide, edges: Sequence[SurfaceBoundary]
) -> list[HalfChain]:
    """The half-chains that leave nodes inside a part."""
    if isinstance(part, NewSide):
        return []
    return edges[part.boundary].nodes_within(network, part.start, part.end)


def _find_leaving(
    builder: NetworkBuilder, network: Network, edge: SurfaceBoundary, part: OldSide
) -> HalfChain:
    """The half-chain by which a stretch of a boundary leaves its first node, after cutting."""
    half, local = edge.located(network, part.start + min(BEYOND, (part.end - part.start) / 2.0))
    chain, _ = builder.locate(half >> 1, local)
    return 2 * chain + (half & 1)


#: A place nearer to a node than this part of a sample is at the node.
AT_NODE = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceBoundary:
    """A boundary of patches on the surface: half-chains in a row without a patch on their left.

    halves:  in order. starts: (h + 1,) the numbers of the vertices at which each begins, the last
             that of the last vertex.
    closed:  does the last half-chain lead to the first?
    points, normals: (n, 3) float64 its vertices; of a closed one the first is not repeated.
    corner:  (n,) bool, which of them are nodes.
    """

    halves: tuple[HalfChain, ...]
    starts: tuple[int, ...]
    closed: bool
    points: Points
    normals: Points
    corner: NDArray[np.bool_]

    def located(self, network: Network, place: float) -> tuple[HalfChain, float]:
        """The half-chain at a place of the boundary, and the place on its chain, in samples."""
        if self.closed:
            place %= len(self.points)
        k = int(np.searchsorted(self.starts, place, side="right")) - 1
        half = self.halves[min(k, len(self.halves) - 1)]
        chain = network.chains[half >> 1]
        local = place - self.starts[min(k, len(self.halves) - 1)]
        if half & 1:
            n = len(chain.points)
            local = (n - 1.0 - local) % n if chain.is_closed_loop else n - 1.0 - local
        return half, local

    def end(self, network: Network, place: float) -> AtNode | AtChain:
        """What a curve is joined to that ends at a place of the boundary."""
        half, local = self.located(network, place)
        chain = network.chains[half >> 1]
        if not chain.is_closed_loop:
            for node, edge in ((chain.start, 0.0), (chain.end, float(chain.segments))):
                if abs(local - edge) < AT_NODE:
                    return AtNode(node)
        return AtChain(chain.id, local)

    def make_node(self, builder: NetworkBuilder, network: Network, place: float) -> int:
        """The node at a place of the boundary; the chain there is cut unless it has one."""
        end = self.end(network, place)
        return end.node if isinstance(end, AtNode) else builder.cut_chain(end.chain, end.place)

    @property
    def corners(self) -> NDArray[np.intp]:
        """(c,) the numbers of the vertices that are nodes."""
        return np.flatnonzero(self.corner)

    @property
    def lengths(self) -> NDArray[np.float64]:
        """(n + 1,) of a closed one: arc length at every vertex, and all around."""
        return arc_length(np.concatenate([self.points, self.points[:1]]))

    def fractions(self, start: int, *, backwards: bool) -> NDArray[np.float64]:
        """(n,) of every vertex of a closed one the part of the way round to it from ``start``."""
        lengths = self.lengths
        way = (lengths[:-1] - lengths[start]) / lengths[-1]
        return (-way if backwards else way) % 1.0

    def place(self, start: int, fraction: float, *, backwards: bool) -> float:
        """The place on a closed one this part of the way round from a vertex on."""
        lengths = self.lengths
        n, whole = len(self.points), lengths[-1]
        length = lengths[start] + (-fraction if backwards else fraction) * whole
        return float(np.interp(length % whole, lengths, np.arange(n + 1.0)))

    def nodes_within(self, network: Network, start: float, end: float) -> list[HalfChain]:
        """The half-chains that leave nodes strictly between two places."""
        n = len(self.points)
        found: list[HalfChain] = []
        for k, half in enumerate(self.halves):
            if network.origin(half) == NONE or not (k or self.closed):
                continue
            first = float(self.starts[k])
            turns = range(-1, 3) if self.closed else (0,)
            if any(start + AT_NODE < first + t * n < end - AT_NODE for t in turns):
                found.append(half)
        return found


def find_boundaries(network: Network) -> list[SurfaceBoundary]:
    """All boundaries of what is there.

    A half-chain belongs to one if it has no patch on its left and may have one, and there is a
    patch on its right, or the border of the surface, or the plane of symmetry. A patch that has a
    chain on both its sides is none here: one curve between two rings closes the whole strip
    between them, and more are to come.

    Differs from the paper and its released program, to which only patches count: beside the
    surface's border they leave a gap that no quad can fill.
    """
    slit = {
        patch.id
        for patch in network.patches.values()
        if any(h ^ 1 in patch.loop for h in patch.loop)
    }
    taken = {half for half, patch in network.patch_of().items() if patch not in slit}
    empty = {
        half
        for chain in network.chains
        for half in (2 * chain, 2 * chain + 1)
        if half not in taken
        and not network.mark(half)
        and (half ^ 1 in taken or network.mark(half ^ 1))
    }
    following = {half: find_successor(network.nodes, network.chains, half)[0] for half in empty}
    before = {after: half for half, after in following.items() if after in empty}
    found: list[SurfaceBoundary] = []
    done: set[HalfChain] = set()
    # Open ones from where they begin, then the closed ones, in the order of their numbers.
    for half in (*sorted(empty - before.keys()), *sorted(empty)):
        if half not in done:
            row = list(_walk_row(half, following, empty))
            done.update(row)
            found.append(join_half_chains(network, row, closed=following[row[-1]] == half))
    return found


def map_boundaries(
    network: Network, edges: Sequence[SurfaceBoundary], onto: LocalMap
) -> tuple[list[PlanarBoundary], list[PlanarBoundary]]:
    """In the plane of a map, the boundaries, and the chains that are on none of them: strokes in
    the way of new curves. Strokes that the map does not reach are left out."""
    taken = {half >> 1 for edge in edges for half in edge.halves}
    others = [chain for chain in network.chains.values() if chain.id not in taken]
    lines = [*edges, *others]
    if not lines:
        return [], []
    starts = np.cumsum([0, *(len(line.points) for line in lines)])
    points = np.concatenate([line.points for line in lines])
    uv = onto.of_points(points, np.concatenate([line.normals for line in lines]))
    planes = [uv[a:b] for a, b in pairwise(starts.tolist())]
    boundaries = [
        PlanarBoundary(plane, edge.corner, edge.closed)
        for plane, edge in zip(planes, edges, strict=False)
    ]
    strokes = [
        PlanarBoundary(plane, np.zeros(len(plane), np.bool_), chain.is_closed_loop)
        for plane, chain in zip(planes[len(edges) :], others, strict=True)
        if np.isfinite(plane).any()
    ]
    return boundaries, strokes


def measure_coarseness(surface: Surface, seeds: SurfacePoints) -> float:
    """The length of the longest edge at the triangles under feet, or beside these."""
    corners = np.unique(surface.triangles[seeds.triangles])
    start, star = surface.adjacency.star_start, surface.adjacency.star
    longest = 0.0
    for vertex in corners.tolist():
        beside = surface.vertices[star[start[vertex] : start[vertex + 1]]]
        longest = max(
            longest, float(np.linalg.norm(beside - surface.vertices[vertex], axis=1).max())
        )
    return longest


def _walk_row(
    half: HalfChain, following: dict[HalfChain, HalfChain], empty: set[HalfChain]
) -> Iterator[HalfChain]:
    first = half
    while True:
        yield half
        half = following[half]
        if half == first or half not in empty:
            return


def join_half_chains(
    network: Network, row: Sequence[HalfChain], *, closed: bool
) -> SurfaceBoundary:
    """Half-chains in a row as one boundary."""
    points, normals, corner = [], [], []
    starts = [0]
    for half in row:
        chain = network.chains[half >> 1]
        line, up = chain.directed(half)
        # Shared vertices once: each half-chain without its last.
        last = len(line) if chain.is_closed_loop else len(line) - 1
        points.append(line[:last])
        normals.append(up[:last])
        corner.append(np.arange(last) == (-1 if chain.is_closed_loop else 0))
        starts.append(starts[-1] + last)
    if not closed:
        line, up = network.chains[row[-1] >> 1].directed(row[-1])
        points.append(line[-1:])
        normals.append(up[-1:])
        corner.append(np.ones(1, bool))
    return SurfaceBoundary(
        tuple(row),
        tuple(starts),
        closed,
        np.concatenate(points),
        np.concatenate(normals),
        np.concatenate(corner),
    )


def sample_line(line: Points, spacing: float) -> Points:
    """(m, 2) a polyline with points about ``spacing`` apart, its own among them."""
    parts = [line[:1]]
    for a, b in pairwise(line):
        n = max(1, round(float(np.linalg.norm(b - a)) / spacing))
        parts.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
    return np.concatenate(parts)
