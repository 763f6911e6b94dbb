"""Add the creases of a surface to a network, as chains exactly along sharp edges.

Chains lead from corner to corner. Their nodes and the order of ends around them come from the
triangles, so nothing is searched for and no crease is too close to another. Where a crease ends on
a border, it ends in a node of the border's chain.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.sharpedges import (
    Edge,
    SharpRule,
    count_degrees,
    drop_open_chains,
    find_border,
    find_sharp_edges,
    list_chains,
)
from patterndb_sketch.retopo.network import (
    Chain,
    HalfChain,
    Network,
    NetworkBuilder,
    Node,
    find_nearest_place,
)
from patterndb_sketch.retopo.network.samples import take_chain_samples
from patterndb_sketch.retopo.sizes import Sizes

#: A chain has a corner where it turns by more than this, in degrees, as seen over REACH target
#: edges on both sides, or over this share of its length if that is shorter.
CORNER, REACH, REACH_SHARE = 50.0, 0.5, 0.2

#: Length of sharp edges on one squared target edge of surface, in target edges: a surface with more
#: is rough everywhere.
CROWDED = 1.2

#: Creases keep this far, in target edges, from curves that are drawn.
CLEARANCE = 0.75

#: A crease has at least this many samples.
FEWEST_SAMPLES = 7


@dataclass(frozen=True, slots=True, eq=False)
class Creases:
    """A network with chains along creases.

    half: by the end vertices of a side of the surface, the half-chain that runs there.
    clipped: (n, 3) points of creases that were left out because a drawn curve is there.
    """

    network: Network
    half: dict[tuple[int, int], HalfChain]
    clipped: Points


def find_creases(surface: Surface, edge: float, rule: SharpRule) -> frozenset[Edge]:
    """Find the sharp edges that quads of a target edge length can keep; none where all is rough."""
    edges = find_sharp_edges(surface, edge, rule)
    if rule.filtered and edges:
        ends = surface.vertices[np.array(sorted(edges))]
        length = float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum())
        if length * edge > CROWDED * float(surface.areas.sum()):
            return frozenset()
    return edges


def add_creases(
    network: Network, surface: Surface, sizes: Sizes, rule: SharpRule, *, closed: bool = False
) -> Creases | None:
    """Add chains along all creases of the surface; return None where it has none.

    closed: leave out those with an open end. Sharp edges along a border are left to it.
    """
    edges = find_creases(surface, sizes.edge, rule)
    edges, clipped = _keep_clear(network, surface, edges, CLEARANCE * sizes.edge)
    border = find_border(surface)
    if closed:
        edges = drop_open_chains(edges, border)
    if not edges:
        return None
    stops = {v for pair in edges for v in pair} & border
    for chain in list_chains(edges):
        stops.update(_find_corners(surface.vertices, chain, REACH * sizes.edge))
    return _CreaseBuilder(network, surface, sizes).build(edges, stops, clipped)


def _keep_clear(
    network: Network, surface: Surface, edges: frozenset[Edge], clearance: float
) -> tuple[frozenset[Edge], Points]:
    """Leave out the edges that come near to a drawn curve; also return where those are."""
    drawn = [chain.points for chain in network.chains.values() if not chain.marked]
    if not drawn or not edges:
        return edges, np.empty((0, 3))
    vertices = sorted(count_degrees(edges))
    away, _ = KDTree(np.concatenate(drawn)).query(surface.vertices[vertices])
    near = {v for v, far in zip(vertices, away.tolist(), strict=True) if far < clearance}
    kept = frozenset((a, b) for a, b in edges if a not in near and b not in near)
    return kept, surface.vertices[sorted(near)]


def _find_corners(at: Points, chain: list[int], reach: float) -> list[int]:
    """Find the vertices where a chain turns sharply, those that turn most first."""
    closed = chain[0] == chain[-1]
    line = at[chain]
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    total = float(along[-1])
    reach = min(reach, REACH_SHARE * total)
    inner = np.arange(0 if closed else 1, len(chain) - 1)
    ahead = _interpolate(line, along, along[inner] + reach, closed) - line[inner]
    back = line[inner] - _interpolate(line, along, along[inner] - reach, closed)
    turn = np.degrees(np.arccos(np.clip(np.einsum("nc,nc->n", units(back), units(ahead)), -1, 1)))
    corners: list[int] = []
    for k in np.argsort(-turn, kind="stable").tolist():
        if turn[k] < CORNER:
            break
        gaps = np.abs(along[inner[corners]] - along[inner[k]])
        if closed:
            gaps = np.minimum(gaps, total - gaps)
        if not len(gaps) or gaps.min() > 1.5 * reach:
            corners.append(k)
    return [chain[inner[k]] for k in corners]


def _interpolate(line: Points, along: Floats, place: Floats, closed: bool) -> Points:
    total = along[-1]
    place = place % total if closed else np.clip(place, 0.0, total)
    return np.stack([np.interp(place, along, line[:, c]) for c in range(3)], axis=1)


class _CreaseBuilder:
    """The steps of :func:`add_creases` that change the network."""

    def __init__(self, network: Network, surface: Surface, sizes: Sizes) -> None:
        self.builder = NetworkBuilder(network, surface)
        self.surface = surface
        self.sizes = sizes
        self.mesh = TangentFrames.of(surface)
        self.half: dict[tuple[int, int], HalfChain] = {}
        #: By vertex, the half-chains that leave it, by the vertex that they lead to.
        self.leaving: dict[int, dict[int, HalfChain]] = {}

    def build(self, edges: Iterable[Edge], stops: set[int], clipped: Points) -> Creases:
        """Lay chains between the stops, and make their nodes."""
        degree = count_degrees(edges)
        for chain in list_chains(edges, stops):
            closed = chain[0] == chain[-1]
            self._lay(chain, closed and chain[0] not in stops and degree[chain[0]] == 2)
        for vertex, out in self.leaving.items():
            self._make_node(vertex, self._order_around(vertex, out))
        # Regions between creases become patches when lines cut them.
        return Creases(replace(self.builder.finish(), patches={}), self.half, clipped)

    def _lay(self, path: list[int], loose: bool) -> None:
        chain = self.builder.new_id()
        points, normals = _sample_path(self.surface, path, self.sizes.sampling)
        if loose:
            points, normals = points[:-1], normals[:-1]
        else:
            self.leaving.setdefault(path[0], {})[path[1]] = 2 * chain
            self.leaving.setdefault(path[-1], {})[path[-2]] = 2 * chain + 1
        self.builder.chains[chain] = Chain(chain, -1, -1, points, normals)
        self.builder.touched_chains.add(chain)
        for a, b in pairwise(path):
            self.half[a, b], self.half[b, a] = 2 * chain, 2 * chain + 1

    def _order_around(self, vertex: int, out: dict[int, HalfChain]) -> list[HalfChain]:
        """Order the half-chains that leave a vertex counter-clockwise, as its triangles are."""
        triangles = self.surface.triangles
        sides = self.mesh.list_ring(vertex)
        ring = [int(triangles[s // 3, (s % 3 + 1) % 3]) for s in sides]
        ring.append(int(triangles[sides[-1] // 3, (sides[-1] % 3 + 2) % 3]))
        return [out[u] for u in dict.fromkeys(ring) if u in out]

    def _make_node(self, vertex: int, ends: list[HalfChain]) -> None:
        if self.mesh.on_border[vertex]:
            node = self._add_to_border(vertex, ends)
        else:
            node = Node(
                self.builder.new_id(),
                self.surface.vertices[vertex].copy(),
                self.surface.normals[vertex].copy(),
                tuple(ends),
                (len(ends) > 1,) * len(ends),
            )
        self.builder.set_node(node)
        for half in ends:
            chain = self.builder.chains[half >> 1]
            points, normals = chain.points.copy(), chain.normals.copy()
            points[-(half & 1)], normals[-(half & 1)] = node.point, node.normal
            end = {"end" if half & 1 else "start": node.id}
            self.builder.chains[chain.id] = replace(chain, points=points, normals=normals, **end)

    def _add_to_border(self, vertex: int, ends: list[HalfChain]) -> Node:
        """Return the node of the border at a vertex, with ends of creases in its inner wedge."""
        at, up = self.surface.vertices[vertex], self.surface.normals[vertex]
        borders = {c: chain for c, chain in self.builder.chains.items() if chain.marked}
        found = find_nearest_place(take_chain_samples(borders), at, up, np.inf)
        assert found is not None
        node = self.builder.nodes[self.builder.cut_chain(found.chain, found.place, (at, up))]
        # Of its two ends the surface lies on the left of the first, and on the right of the last.
        forth = next(h for h in node.ends if self.builder.chains[h >> 1].marks[h & 1] == "")
        k = node.ends.index(forth)
        before, after = node.ends[: k + 1], node.ends[k + 1 :]
        wedge = node.wedge_after(forth)
        flags = (
            *node.corner_flags[:wedge],
            *(True,) * (len(ends) + 1),
            *node.corner_flags[wedge + 1 :],
        )
        return replace(node, ends=(*before, *ends, *after), corner_flags=flags)


def _sample_path(surface: Surface, path: list[int], sampling: float) -> tuple[Points, Points]:
    """Return points and normals along a path of vertices, each of which is one of them."""
    at, up = surface.vertices[path], surface.normals[path]
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(at, axis=0), axis=1) / sampling), 1)
    least = np.ceil((FEWEST_SAMPLES - 1) / len(steps))
    parts = np.maximum(steps, least).astype(np.int64)
    start = np.repeat(np.arange(len(parts)), parts)
    share = np.concatenate([np.arange(n) / n for n in parts.tolist()])[:, None]
    points = (1.0 - share) * at[start] + share * at[start + 1]
    normals = (1.0 - share) * up[start] + share * up[start + 1]
    return np.concatenate([points, at[-1:]]), units(np.concatenate([normals, up[-1:]]))
