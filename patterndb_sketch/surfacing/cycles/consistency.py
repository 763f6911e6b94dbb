"""Are chosen cycles the patches of a surface: orientable, and one sheet at every node?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from patterndb_sketch.surfacing.network import Cycle, Network


@dataclass(frozen=True, slots=True)
class Oriented:
    """Cycles turned so that neighbours walk the curve they share in opposite senses.

    cycles:    the cycles, in order.
    surfaces:  for each the number of the surface that it is part of; neighbours share it.
    twisted:   sets of cycles, each a closed strip that turns over, so that no turning does.
    """

    cycles: tuple[Cycle, ...]
    surfaces: tuple[int, ...]
    twisted: tuple[tuple[int, ...], ...]


def users(cycles: Sequence[Cycle]) -> dict[int, list[tuple[int, bool]]]:
    """For every curve that cycles walk: (cycle, backward)."""
    at: dict[int, list[tuple[int, bool]]] = {}
    for i, cycle in enumerate(cycles):
        for curve, backward in cycle.steps:
            at.setdefault(curve, []).append((i, backward))
    return at


def oriented(cycles: Sequence[Cycle]) -> Oriented:
    """The cycles turned like the first of each surface, each curve in at most two of them."""
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in cycles]
    for walks in users(cycles).values():
        if len(walks) == 2 and walks[0][0] != walks[1][0]:
            (i, sense), (j, other) = walks
            neighbours[i].append((j, sense == other))
            neighbours[j].append((i, sense == other))
    surface = [-1] * len(cycles)
    turned = [False] * len(cycles)
    before = [-1] * len(cycles)
    twisted: set[tuple[int, ...]] = set()
    for first in range(len(cycles)):
        if surface[first] >= 0:
            continue
        surface[first] = first
        waiting = [first]
        for i in waiting:  # grows as it is walked through: breadth first
            for j, turn in neighbours[i]:
                if surface[j] < 0:
                    surface[j], turned[j], before[j] = first, turned[i] != turn, i
                    waiting.append(j)
                elif turned[j] != (turned[i] != turn):
                    twisted.add(_strip(before, i, j))
    result = tuple(c.turned if t else c for c, t in zip(cycles, turned, strict=True))
    return Oriented(result, tuple(surface), tuple(sorted(twisted)))


def _strip(before: Sequence[int], i: int, j: int) -> tuple[int, ...]:
    """The closed strip that two neighbours make with their ways to where these part."""
    ways: list[list[int]] = []
    for k in (i, j):
        way = [k]
        while before[way[-1]] >= 0:
            way.append(before[way[-1]])
        ways.append(way[::-1])
    common = 0
    while common < min(map(len, ways)) and ways[0][common] == ways[1][common]:
        common += 1
    return tuple(sorted({*ways[0][max(common - 1, 0) :], *ways[1][max(common - 1, 0) :]}))


def pinched(network: Network, cycles: Sequence[Cycle]) -> list[tuple[int, tuple[int, ...]]]:
    """Where a surface is closed around a node, and yet other cycles pass it: a pinch.

    Returns (node, cycles around it) for every closed ring of cycles beside which there is
    another cycle at the node.
    """
    corners: dict[int, list[tuple[int, int, int]]] = {}
    for i, cycle in enumerate(cycles):
        for node, before, step in zip(
            network.walk(cycle), (cycle.steps[-1], *cycle.steps), cycle.steps, strict=False
        ):
            if len(cycle.steps) > 1:
                corners.setdefault(node, []).append((before[0], step[0], i))
    found: list[tuple[int, tuple[int, ...]]] = []
    for node, at in sorted(corners.items()):
        around: dict[int, list[tuple[int, int]]] = {}
        for a, b, i in at:
            around.setdefault(a, []).append((b, i))
            around.setdefault(b, []).append((a, i))
        waiting = sorted(around)
        seen: set[int] = set()
        for first in waiting:
            if first in seen:
                continue
            ring, stack = {first}, [first]
            while stack:
                for other, _ in around[stack.pop()]:
                    if other not in ring:
                        ring.add(other)
                        stack.append(other)
            seen |= ring
            members = {i for curve in ring for _, i in around[curve]}
            if all(len(around[curve]) == 2 for curve in ring) and len(members) < len(at):
                found.append((node, tuple(sorted(members))))
    return found
