"""Found cycles, and what their user must be told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.cycles.closing import find_dangling


@dataclass(frozen=True, slots=True)
class RejectedCycle:
    """A closed cycle that was not taken.

    badness: how much it bends, folds and passes curves by; worst: the most that was allowed.
    """

    cycle: Cycle
    badness: float
    worst: float

    def tell(self, network: CurveNetwork) -> str:
        """Say which curves they are, why they were not taken, and how to keep them."""
        names = ",".join(map(str, network.names(self.cycle)))
        if self.badness <= self.worst:
            why = "another choice was better"
        else:
            why = f"badness {self.badness:.2f}, the most allowed is {self.worst:g}"
        return (
            f"the curves {names} close a cycle that is not taken for a patch ({why}); add it if it "
            f"is one (--keep {names})"
        )


@dataclass(frozen=True, slots=True)
class FoundCycles:
    """The cycles of a network.

    cycles:      the cycles; neighbours walk a shared curve in opposite senses where the surface
                 can be oriented. Walls, which stand on curves of two others, come last.
    dangling:    numbers of curves that end where nothing goes on, and bound nothing.
    unused:      numbers of other curves that bound no cycle.
    once:        numbers of curves that bound one cycle only: the surface's boundary.
    candidates:  how many cycles were considered.
    cut_short:   pairs of curves for which not all closing paths were looked through.
    proven:      is there surely no better choice among the candidates that took part? False too
                 where a choice was mended because it was no surface.
    orientable:  could all cycles be oriented?
    pinches:     nodes around which a surface is closed while other cycles touch it there.
    nearest_miss: the best of the candidates whose curves bound nothing; None without one.
    notes:       the same in words, for what a user should look at; empty if all is well.
    """

    cycles: tuple[Cycle, ...]
    dangling: tuple[int, ...] = ()
    unused: tuple[int, ...] = ()
    once: tuple[int, ...] = ()
    candidates: int = 0
    cut_short: int = 0
    proven: bool = True
    orientable: bool = True
    pinches: tuple[int, ...] = ()
    nearest_miss: RejectedCycle | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)


def describe_cycles(
    network: CurveNetwork,
    cycles: tuple[Cycle, ...],
    twisted: bool,
    candidates: int,
    cut_short: int,
    proven: bool,
    nearest_miss: RejectedCycle | None = None,
) -> FoundCycles:
    """The cycles with what is to be known about them.

    twisted: can they not be oriented? The others as in :class:`FoundCycles`.
    """
    gone = find_dangling(network)
    count = {curve: len(walks) for curve, walks in list_users(cycles).items()}
    living = np.flatnonzero(~gone).tolist()
    unused = tuple(curve for curve in living if curve not in count)
    once = tuple(curve for curve in living if count.get(curve) == 1)
    pinches = tuple(sorted({node for node, _ in find_pinches(network, cycles)}))
    notes: list[str] = []

    def note(number: int, one: str, many: str) -> None:
        if number:
            notes.append(f"1 {one}" if number == 1 else f"{number:,} {many}")

    note(
        int(gone.sum()),
        "curve dangles and bounds no cycle",
        "curves dangle and bound no cycle",
    )
    note(len(unused), "other curve bounds no cycle", "other curves bound no cycle")
    if nearest_miss is not None:
        notes.append(nearest_miss.tell(network))
    note(
        cut_short,
        "pair of curves was not closed in all ways: too many paths",
        "pairs of curves were not closed in all ways: too many paths",
    )
    note(
        len(pinches),
        "node is pinched: a closed surface is touched there by another",
        "nodes are pinched: a closed surface is touched there by another",
    )
    if not proven:
        notes.append(
            "a better choice among the cycles considered may exist: this one is not proven best"
        )
    if twisted:
        notes.append("the surface cannot be oriented: it turns over, as a Moebius strip does")
    return FoundCycles(
        cycles,
        tuple(np.flatnonzero(gone).tolist()),
        unused,
        once,
        candidates,
        cut_short,
        proven,
        not twisted,
        pinches,
        nearest_miss,
        tuple(notes),
    )


@dataclass(frozen=True, slots=True)
class OrientedCycles:
    """Cycles turned so that neighbours walk the curve they share in opposite senses.

    cycles:    the cycles, in order.
    surfaces:  for each the number of the surface that it is part of; neighbours share it.
    twisted:   sets of cycles, each a closed strip that turns over, so that no turning does.
    """

    cycles: tuple[Cycle, ...]
    surfaces: tuple[int, ...]
    twisted: tuple[tuple[int, ...], ...]


def list_users(cycles: Sequence[Cycle]) -> dict[int, list[tuple[int, bool]]]:
    """For every curve that cycles walk: (cycle, backward)."""
    at: dict[int, list[tuple[int, bool]]] = {}
    for i, cycle in enumerate(cycles):
        for curve, backward in cycle.steps:
            at.setdefault(curve, []).append((i, backward))
    return at


def orient_cycles(cycles: Sequence[Cycle]) -> OrientedCycles:
    """The cycles turned like the first of each surface, each curve in at most two of them."""
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in cycles]
    for walks in list_users(cycles).values():
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
    return OrientedCycles(result, tuple(surface), tuple(sorted(twisted)))


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


def find_pinches(
    network: CurveNetwork, cycles: Sequence[Cycle]
) -> list[tuple[int, tuple[int, ...]]]:
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
