"""Collapsing polychords one by one, in any order."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Mapping, Sequence

from tests.support.reference.halfedge import (
    Quads,
    Twin,
    as_complex,
    border_vertices,
    fans,
    next_edge,
    prev_edge,
    twins,
)


def opposite(h: int) -> int:
    return 4 * (h // 4) + (h + 2) % 4


def strip_through(twin: dict[int, int], h: int) -> tuple[list[int], bool]:
    """The half-edges by which the polychord enters its quads, and whether it is a loop."""
    first = h
    while twin[first] >= 0:
        first = opposite(twin[first])
        if first == h:
            break
    strip = [first]
    while (t := twin[opposite(strip[-1])]) >= 0 and t != first:
        strip.append(t)
    return strip, t == first


def may_collapse(
    twin: dict[int, int],
    strip: list[int],
    loop: bool,
    strict: bool,
    vertex: Mapping[int, int] | None = None,
) -> bool:
    """Does it not cross itself, are its chains simple and disjoint, and is one regular?

    strict: as the definition of collapse has it, neither chain repeats a vertex. Otherwise only
    a regular one must not; that is what the definition of dissolving comes to. The two part
    where a strip folds back on itself, about two vertices of valence 2 for instance.
    vertex: the names of vertices by half-edges; by fans if not given.
    """
    if len({h // 4 for h in strip}) < len(strip):
        return False
    vertex = fans(twin) if vertex is None else {h: vertex[h] for h in twin}
    left = [vertex[h] for h in strip]
    right = [vertex[next_edge(h)] for h in strip]
    if not loop:
        left.append(vertex[prev_edge(strip[-1])])
        right.append(vertex[opposite(strip[-1])])
    repeats = len(set(left)) < len(left) or len(set(right)) < len(right)
    if set(left) & set(right) or (strict and repeats):
        return False
    valence = Counter(vertex.values())
    border = border_vertices(twin, vertex)

    def regular(chain: list[int]) -> bool:
        inner = chain if loop else chain[1:-1]
        ends = [] if loop else [chain[0], chain[-1]]
        return (
            len(set(chain)) == len(chain)
            and all(v not in border and valence[v] == 4 for v in inner)
            and all(v in border and valence[v] == 2 for v in ends)
        )

    return regular(left) or regular(right)


def collapse(twin: dict[int, int], strip: list[int]) -> None:
    """Take the strip's quads out and join what lies on its two sides."""
    for h in strip:
        a, b = twin[prev_edge(h)], twin[next_edge(h)]
        if a >= 0:
            twin[a] = b
        if b >= 0:
            twin[b] = a
    for h in strip:
        for e in range(4):
            del twin[4 * (h // 4) + e]


def reduce_disk(half_edges: Sequence[int], order: random.Random, strict: bool = True) -> Twin:
    """Collapse polychords, drawn by ``order``, until none may; quads are numbered anew."""
    twin = as_complex(half_edges)
    while True:
        edges = [h for h in twin if h % 4 < 2]
        order.shuffle(edges)
        for h in edges:
            strip, loop = strip_through(twin, h)
            if may_collapse(twin, strip, loop, strict):
                collapse(twin, strip)
                break
        else:
            break
    place = {q: i for i, q in enumerate(sorted({h // 4 for h in twin}))}
    return [4 * place[t // 4] + t % 4 if t >= 0 else -1 for _, t in sorted(twin.items())]


def prepare_mesh(quads: Quads) -> Quads:
    """Collapse polychords of a whole mesh, that of the smallest quad first, until none may.

    quads: with the vertices' names, neighbours in the same sense. Edges of two quads are joined,
    those that come to lie on each other too. A polychord stays where its collapse would take the
    last quad away, make a quad with a vertex twice, or the first edge of three quads.
    """
    while True:
        twin = as_complex(twins(quads))
        vertex = {h: quads[h // 4][h % 4] for h in twin}
        for h in [h for h in sorted(twin) if h % 4 < 2]:
            strip, loop = strip_through(twin, h)
            if may_collapse(twin, strip, loop, strict=True, vertex=vertex):
                fewer = _merge_names(quads, vertex, strip, loop)
                if _are_sound(fewer) and (not _has_book(fewer) or _has_book(quads)):
                    quads = fewer
                    break
        else:
            return quads


def _merge_names(quads: Quads, vertex: dict[int, int], strip: list[int], loop: bool) -> Quads:
    """Return the quads beyond a strip, what is on its left named as what is on its right."""
    to = {vertex[h]: vertex[next_edge(h)] for h in strip}
    if not loop:
        to[vertex[prev_edge(strip[-1])]] = vertex[opposite(strip[-1])]
    gone = {h // 4 for h in strip}
    return [[to.get(v, v) for v in quad] for i, quad in enumerate(quads) if i not in gone]


def _are_sound(quads: Quads) -> bool:
    """Are quads left, each with four vertices?"""
    return bool(quads) and all(len(set(quad)) == 4 for quad in quads)


def _has_book(quads: Quads) -> bool:
    """Have three quads an edge between the same two vertices?"""
    edges = Counter(frozenset((quad[e], quad[e - 1])) for quad in quads for e in range(4))
    return max(edges.values()) > 2
