"""Find the sharp edges of a triangle surface, and add them to a network as creases.

An edge is sharp if its two triangles meet at a large dihedral angle (0 where they are coplanar).
From there a crease continues over edges with a smaller angle: between two sharp vertices, and
straight ahead from an open end. Chains that do not stand out from the edges around them are
roughness of the surface, and short ones are noise (:func:`find_creases`).

In the network a crease is a chain exactly along sharp edges (:func:`add_creases`). Chains lead from
corner to corner. Their nodes and the order of ends around them come from the triangles, so nothing
is searched for and no crease is too close to another. Where a crease ends on a border, it ends in a
node of the border's chain.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.polyline import arc_length, interpolate
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.network import (
    NONE,
    HalfChain,
    Network,
    NetworkBuilder,
    Node,
    find_nearest_place,
)
from patterndb_sketch.retopo.network.samples import take_chain_samples
from patterndb_sketch.retopo.sizes import Sizes

#: Dihedral angles in degrees: edges above the first are sharp; a crease continues over edges above
#: the second. Found on nine CAD bodies and ten organic ones.
SHARP, CONTINUED = 40.0, 25.0

#: A chain is kept if its median dihedral is CONTRAST times the 75 % quantile of the edges next to
#: it that are not sharp, which counts as ROUGH degrees at least, or if it is above CLEAR degrees.
CONTRAST, ROUGH, CLEAR = 4.0, 8.0, 65.0

#: Nor is a chain of edges shorter than a target edge kept if that is below CLEARLY times the median
#: of all other such edges next to it: there the surface is rough at the scale of its triangles. At
#: least FEWEST_SMALL of them for each of its vertices are next to it then: a crease of a machined
#: body meets a few short ones at its ends.
CLEARLY, FEWEST_SMALL = 3.0, 3

#: A chain is noise if it is shorter than this, in target edges: with one open end; with two, and
#: components as a whole; closed. From border to border it is half a closed one, as of a surface
#: that is cut in halves.
SHORT_SPUR, SHORT_ALONE, SHORT_LOOP = 2.0, 4.0, 3.0

#: A crease continues straight ahead if it turns by less than this, in degrees.
STRAIGHT = 40.0

#: Rounds of dropping short chains: each may make a longer chain of two others.
ROUNDS = 4

#: A pair of vertices, the lower first.
Edge = tuple[int, int]


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


@dataclass(frozen=True, slots=True)
class SharpRule:
    """Which edges are sharp.

    angle: dihedral in degrees above which an edge is sharp.
    continued: dihedral in degrees above which a crease continues.
    filtered: are chains dropped that do not stand out from the surface around them?
    """

    angle: float = SHARP
    continued: float = CONTINUED
    filtered: bool = True

    @classmethod
    def above(cls, angle: float) -> SharpRule:
        """Return the rule of a given angle: every edge above it is sharp, rough or not."""
        return cls(angle, angle * CONTINUED / SHARP, False)


#: The rule where none is given.
AUTOMATIC = SharpRule()


def find_sharp_edges(surface: Surface, edge: float, rule: SharpRule = AUTOMATIC) -> frozenset[Edge]:
    """Find the sharp edges of a surface.

    edge: target edge length of the quads, in the surface's unit: what is short is noise for them.
    Edges of which both ends are on a border are left to it; a chain that ends there is not open.
    """
    border = find_border(surface)
    ends, angle = measure_dihedrals(surface)
    sharp = _pair_up(ends[angle > rule.angle])
    weak = _pair_up(ends[angle > rule.continued]) - sharp
    sharp = _join_gaps(sharp, weak)
    sharp = _extend_straight(surface.vertices, sharp, weak - sharp)
    if rule.filtered:
        sharp -= _find_rough(surface.vertices, sharp, ends, angle, edge)
    sharp = {(a, b) for a, b in sharp if not (a in border and b in border)}
    return frozenset(_drop_short(surface.vertices, sharp, edge, border))


def find_border(surface: Surface) -> frozenset[int]:
    """Find the vertices on borders of a surface."""
    sides = surface.adjacency.border
    heads = surface.triangles[sides // 3, (sides % 3 + 1) % 3]
    return frozenset(surface.triangles.ravel()[sides].tolist()) | frozenset(heads.tolist())


def measure_dihedrals(surface: Surface) -> tuple[NDArray[np.integer], Floats]:
    """Return (e, 2) the vertices of the inner edges, the lower first, and (e,) their dihedrals in
    degrees."""
    across = surface.adjacency.across
    side = np.flatnonzero((across >= 0) & (np.arange(len(across)) < across))
    corner = surface.vertices[surface.triangles]
    normal = units(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    cosine = np.einsum("ec,ec->e", normal[side // 3], normal[across[side] // 3])
    tail = surface.triangles.ravel()[side]
    head = surface.triangles[side // 3, (side % 3 + 1) % 3]
    ends = np.sort(np.stack([tail, head], axis=1), axis=1)
    return ends, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def drop_open_chains(edges: Iterable[Edge], border: Collection[int] = ()) -> frozenset[Edge]:
    """Return the edges without chains that have an open end; border: where an end is not open."""
    left = set(edges)
    while True:
        degree = count_degrees(left)
        tips = {v for v, n in degree.items() if n == 1 and v not in border}
        kept = {(a, b) for a, b in left if a not in tips and b not in tips}
        if len(kept) == len(left):
            return frozenset(left)
        left = kept


def count_degrees(edges: Iterable[Edge]) -> dict[int, int]:
    """Count the edges at every vertex that has any."""
    degree: dict[int, int] = {}
    for pair in edges:
        for vertex in pair:
            degree[vertex] = degree.get(vertex, 0) + 1
    return degree


def list_chains(edges: Iterable[Edge], stops: Iterable[int] = ()) -> list[list[int]]:
    """List the chains of some edges as vertices in order.

    A chain ends at stops and where other than two edges meet; a closed one ends where it begins.
    """
    left = set(edges)
    linked: dict[int, list[int]] = {}
    for a, b in sorted(left):
        linked.setdefault(a, []).append(b)
        linked.setdefault(b, []).append(a)
    nodes = {v for v, near in linked.items() if len(near) != 2} | (set(stops) & linked.keys())
    chains: list[list[int]] = []

    def follow(chain: list[int]) -> None:
        while True:
            left.discard(_ordered(chain[-2], chain[-1]))
            if chain[-1] in nodes or chain[-1] == chain[0]:
                chains.append(chain)
                return
            chain.append(next(u for u in linked[chain[-1]] if u != chain[-2]))

    for v in sorted(nodes):
        for u in linked[v]:
            if _ordered(v, u) in left:
                follow([v, u])
    while left:
        follow([*min(left)])
    return chains


def _ordered(a: int, b: int) -> Edge:
    return (a, b) if a < b else (b, a)


def _pair_up(ends: NDArray[np.integer]) -> set[Edge]:
    return {(a, b) for a, b in ends.tolist()}


def _edges_of(chain: list[int]) -> list[Edge]:
    return [_ordered(a, b) for a, b in pairwise(chain)]


def _join_gaps(sharp: set[Edge], weak: set[Edge]) -> set[Edge]:
    """Add the chains of weak edges that lead from one sharp vertex to another."""
    strong = set(count_degrees(sharp))
    found = set(sharp)
    for chain in list_chains(weak, strong):
        if chain[0] != chain[-1] and chain[0] in strong and chain[-1] in strong:
            found.update(_edges_of(chain))
    return found


def _extend_straight(at: Points, sharp: set[Edge], weak: set[Edge]) -> set[Edge]:
    """Continue chains from their open ends straight ahead over weak edges."""
    linked: dict[int, list[int]] = {}
    for a, b in sorted(weak):
        linked.setdefault(a, []).append(b)
        linked.setdefault(b, []).append(a)
    found, degree = set(sharp), count_degrees(sharp)
    back = {v: b if v == a else a for a, b in sharp for v in (a, b) if degree[v] == 1}
    tips = sorted(back)
    least = np.cos(np.radians(STRAIGHT))
    while tips:
        v = tips.pop()
        if degree[v] != 1:
            continue
        ahead = units((at[v] - at[back[v]])[None])[0]
        near = [u for u in linked.get(v, ()) if _ordered(u, v) not in found]
        if not near:
            continue
        cosine = units(at[near] - at[v]) @ ahead
        k = int(cosine.argmax())
        if cosine[k] <= least:
            continue
        found.add(_ordered(near[k], v))
        degree[v] += 1
        degree[near[k]] = degree.get(near[k], 0) + 1
        back[near[k]] = v
        tips.append(near[k])
    return found


def _find_rough(
    at: Points, sharp: set[Edge], ends: NDArray[np.integer], angle: Floats, edge: float
) -> set[Edge]:
    """Find the edges of chains that do not stand out from the edges next to them."""
    if not sharp:
        return set()
    on_chain = np.zeros(len(at), np.bool_)
    on_chain[list(count_degrees(sharp))] = True
    near = on_chain[ends].any(axis=1)
    ends, angle = ends[near], angle[near]
    pairs = [(a, b) for a, b in ends.tolist()]
    # Of edges with the same ends the last counts.
    of = dict(zip(pairs, angle.tolist(), strict=True))
    length = np.linalg.norm(at[ends[:, 0]] - at[ends[:, 1]], axis=1)
    short = dict(zip(pairs, (length < edge).tolist(), strict=True))
    beside: dict[int, list[Edge]] = {}
    for pair in of:
        for vertex in pair:
            beside.setdefault(vertex, []).append(pair)
    rough: set[Edge] = set()
    for chain in list_chains(sharp):
        own = set(_edges_of(chain))
        median = float(np.median([of[pair] for pair in own]))
        around = {pair for v in chain for pair in beside[v]} - own
        blunt = [of[pair] for pair in around if pair not in sharp]
        fine = 2 * sum(short[pair] for pair in own) > len(own)
        small = [of[pair] for pair in around if short[pair]] if fine else []
        usual = float(np.percentile(blunt, 75)) if blunt else 0.0
        unclear = median < CLEAR and median < CONTRAST * max(usual, ROUGH)
        many = len(small) >= FEWEST_SMALL * len(chain)
        if unclear or (many and median < CLEARLY * float(np.median(small))):
            rough.update(own)
    return rough


def _drop_short(at: Points, sharp: set[Edge], edge: float, border: Collection[int]) -> set[Edge]:
    """Return the sharp edges without chains and components that are too short."""
    for _ in range(ROUNDS):
        degree = count_degrees(sharp)
        short: set[Edge] = set()
        for chain in list_chains(sharp, border):
            ends = (chain[0], chain[-1])
            open_ends = sum(degree[v] == 1 and v not in border for v in ends)
            if chain[0] == chain[-1] and degree[chain[0]] == 2:
                least = SHORT_LOOP
            elif all(v in border for v in ends):
                least = 0.5 * SHORT_LOOP
            else:
                least = (0.0, SHORT_SPUR, SHORT_ALONE)[open_ends]
            if measure_chain(at, chain) < least * edge:
                short.update(_edges_of(chain))
        if not short:
            break
        sharp = sharp - short
    return sharp - _find_small(at, sharp, SHORT_ALONE * edge, border)


def measure_chain(at: Points, chain: list[int]) -> float:
    """Return the length of a chain of vertices."""
    return float(np.linalg.norm(np.diff(at[chain], axis=0), axis=1).sum())


def _find_small(at: Points, sharp: set[Edge], least: float, border: Collection[int]) -> set[Edge]:
    """Find the edges of components that are too short as a whole; loops, and chains from border to
    border, are judged as chains."""
    parent: dict[int, int] = {}

    def root(v: int) -> int:
        while parent.setdefault(v, v) != v:
            parent[v] = v = parent[parent[v]]
        return v

    for a, b in sorted(sharp):
        parent[root(a)] = root(b)
    degree = count_degrees(sharp)
    length: dict[int, float] = {}
    simple: dict[int, bool] = {}
    for pair in sharp:
        r = root(pair[0])
        length[r] = length.get(r, 0.0) + measure_chain(at, list(pair))
        passing = all(degree[v] + (v in border) == 2 for v in pair)
        simple[r] = simple.get(r, True) and passing
    return {(a, b) for a, b in sharp if length[root(a)] < least and not simple[root(a)]}


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
    along = arc_length(line)
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
    return interpolate(line, along, place)


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
        points, normals = _sample_path(self.surface, path, self.sizes.sampling)
        if loose:
            points, normals = points[:-1], normals[:-1]
        chain = self.builder.new_chain(NONE, NONE, points, normals)
        if not loose:
            self.leaving.setdefault(path[0], {})[path[1]] = 2 * chain
            self.leaving.setdefault(path[-1], {})[path[-2]] = 2 * chain + 1
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
