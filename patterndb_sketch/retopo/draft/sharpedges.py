"""Find the sharp edges of a triangle surface, without those that are noise.

An edge is sharp if its two triangles meet at a large dihedral angle (0 where they are coplanar).
From there a crease continues over edges with a smaller angle: between two sharp vertices, and
straight ahead from an open end. Chains that do not stand out from the edges around them are
roughness of the surface, and short ones are noise.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.surface import Surface

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
