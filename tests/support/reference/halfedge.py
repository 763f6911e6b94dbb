"""Quads to half-edges, half-edges to vertices."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence

Quads = list[list[int]]
Twin = list[int]
Complex = Mapping[int, int]


def next_edge(h: int) -> int:
    return 4 * (h // 4) + (h + 1) % 4


def prev_edge(h: int) -> int:
    return 4 * (h // 4) + (h + 3) % 4


def as_complex(twin: Iterable[int]) -> dict[int, int]:
    return {h: int(t) for h, t in enumerate(twin)}


def _uses(quads: Quads) -> dict[frozenset[int], list[tuple[int, int]]]:
    """The (quad, edge) that use every edge."""
    uses: dict[frozenset[int], list[tuple[int, int]]] = {}
    for f, quad in enumerate(quads):
        for e in range(4):
            uses.setdefault(frozenset((quad[e], quad[e - 3])), []).append((f, e))
    return uses


def oriented(quads: Sequence[Sequence[int]]) -> Quads:
    """The quads, flipped breadth-first from each component's first so that neighbours agree."""
    result = [list(q) for q in quads]
    uses = _uses(result)
    seen: set[int] = set()
    for root in range(len(result)):
        todo = deque([] if root in seen else [root])
        seen.add(root)
        while todo:
            f = todo.popleft()
            # By the edges as the file gives them, for a flip renumbers them.
            given = list(quads[f])
            for e in range(4):
                edge = uses[frozenset((given[e], given[e - 3]))]
                if len(edge) != 2:
                    continue
                g = next((g for g, _ in edge if g != f), f)
                if g in seen:
                    continue
                seen.add(g)
                todo.append(g)
                if _directed(result[f]) & _directed(result[g]) & _both(given[e], given[e - 3]):
                    result[g].reverse()
    return result


def _directed(quad: list[int]) -> set[tuple[int, int]]:
    return {(quad[e], quad[e - 3]) for e in range(4)}


def _both(a: int, b: int) -> set[tuple[int, int]]:
    return {(a, b), (b, a)}


def twins(quads: Quads) -> Twin:
    """Half-edges of quads as they lie: an edge of two that traverse it in opposite directions
    joins them."""
    twin = [-1] * (4 * len(quads))
    for edge in _uses(quads).values():
        if len(edge) == 2 and edge[0][0] != edge[1][0]:
            (f, e), (g, d) = edge
            if quads[f][e] == quads[g][d - 3]:
                twin[4 * f + e] = 4 * g + d
                twin[4 * g + d] = 4 * f + e
    return twin


def fans(twin: Complex) -> dict[int, int]:
    """The vertex of every corner: corners that meet across a joined edge are one vertex.

    Vertices are numbered by their first corners.
    """
    parent = {h: h for h in twin}

    def root(h: int) -> int:
        while parent[h] != h:
            h = parent[h]
        return h

    for h, t in twin.items():
        if t >= 0:
            a, b = sorted((root(h), root(next_edge(t))))
            parent[b] = a
    number: dict[int, int] = {}
    return {h: number.setdefault(root(h), len(number)) for h in sorted(twin)}


def border_vertices(twin: Complex, vertex: Mapping[int, int]) -> set[int]:
    return {vertex[c] for h, t in twin.items() if t < 0 for c in (h, next_edge(h))}


def components(twin: Complex) -> dict[int, int]:
    """The component of every quad, numbered by their first quads."""
    number: dict[int, int] = {}
    count = 0
    for root in sorted({h // 4 for h in twin}):
        if root in number:
            continue
        todo = [root]
        while todo:
            f = todo.pop()
            if f not in number:
                number[f] = count
                todo += [twin[4 * f + e] // 4 for e in range(4) if twin[4 * f + e] >= 0]
        count += 1
    return number


def border_loop(twin: Complex, start: int) -> list[int]:
    """The border half-edges from ``start`` on, counter-clockwise."""
    vertex = fans(twin)
    leaving = {vertex[h]: h for h, t in twin.items() if t < 0}
    loop = [start]
    while (h := leaving[vertex[next_edge(loop[-1])]]) != start:
        loop.append(h)
    return loop


def is_disk(twin: Complex) -> bool:
    """Edge-connected, one border loop that visits no vertex twice, V - E + F = 1?"""
    vertex = fans(twin)
    border = [h for h, t in twin.items() if t < 0]
    if not border or set(components(twin).values()) != {0}:
        return False
    if any(n > 1 for n in Counter(vertex[h] for h in border).values()):
        return False
    if len(border_loop(twin, border[0])) != len(border):
        return False
    n_edges = (len(twin) + len(border)) // 2
    return len(set(vertex.values())) - n_edges + len(twin) // 4 == 1
