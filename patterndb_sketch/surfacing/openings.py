"""What of a network stays open: curves that bound no patch, and the rims of its surface.

A designer who misses a patch looks for it here: a hole is a rim like the outline, mostly a short
one, and a curve that bounds nothing is often all that is left of a patch that was not found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from patterndb_sketch.curvenetwork.network import (
    CurveId,
    CurveNetwork,
    Cycle,
    Step,
    total_length,
    turn_walk,
)


@dataclass(frozen=True, slots=True)
class OpenRim:
    """Curves one after another that bound one patch each.

    steps:  (curve, backward) in the order of the walk, as those of a cycle.
    closed: does it come back to where it began? Always on a surface; not where a rim runs into a
            curve that bounds more than two patches.
    length: of its curves.
    """

    steps: tuple[Step, ...]
    closed: bool
    length: float

    def list_names(self, network: CurveNetwork) -> list[CurveId]:
        """List the ids of the rim's curves in order, parts of one split curve in a row once."""
        return network.names(Cycle(self.steps))


@dataclass(frozen=True, slots=True)
class Openings:
    """What is open in a network when some of its cycles have patches.

    idle: numbers of the curves that bound no patch. rims: the rims of the surface, the shortest
    first.
    """

    idle: tuple[int, ...]
    rims: tuple[OpenRim, ...]

    def name_idle(self, network: CurveNetwork) -> list[CurveId]:
        """List the ids of the curves that bound nothing, each once."""
        return list(dict.fromkeys(network.curves[curve].id for curve in self.idle))

    def count_rim_curves(self) -> int:
        """Count the curves of all rims."""
        return sum(len(rim.steps) for rim in self.rims)


def find_openings(network: CurveNetwork, cycles: Sequence[Cycle]) -> Openings:
    """Find the curves of a network that bound none of some cycles, and the rims that one does.

    A rim goes on, at a node, along the curve that ends the fan of patches which the curve before
    begins: where two parts of a surface touch in a node only, their rims stay apart.
    """
    # Of every cycle and node the curves that it comes and goes by; of every curve its cycles.
    beside: dict[tuple[int, int], tuple[int, int]] = {}
    users: dict[int, list[int]] = {}
    for number, cycle in enumerate(cycles):
        nodes = network.walk(cycle)
        for k, (curve, _) in enumerate(cycle.steps):
            users.setdefault(curve, []).append(number)
            beside[number, nodes[k]] = (cycle.steps[k - 1][0], curve)
    waiting = [curve for curve, own in sorted(users.items()) if len(own) == 1]
    seen: set[int] = set()
    rims: list[OpenRim] = []
    for first in waiting:
        if first in seen:
            continue
        walk, closed = _follow(network, users, beside, (first, False))
        if not closed:
            # It was begun in its middle.
            back, _ = _follow(network, users, beside, (first, True))
            walk = [*turn_walk(back[1:]), *walk]
        curves = [curve for curve, _ in walk]
        seen.update(curves)
        rims.append(OpenRim(tuple(walk), closed, total_length(network, curves)))
    idle = tuple(curve for curve in range(len(network.curves)) if curve not in users)
    return Openings(idle, tuple(sorted(rims, key=lambda rim: (rim.length, rim.steps))))


def _follow(
    network: CurveNetwork,
    users: dict[int, list[int]],
    beside: dict[tuple[int, int], tuple[int, int]],
    first: Step,
) -> tuple[list[Step], bool]:
    """The rim from a step on, and whether it comes back to it."""
    walk = [first]
    while True:
        curve, backward = walk[-1]
        node = network.ends((curve, backward))[1]
        cycle = users[curve][0]
        while True:
            one, other = beside[cycle, node]
            curve = other if one == curve else one
            if len(users[curve]) != 2:
                break
            cycle = next(own for own in users[curve] if own != cycle)
        if len(users[curve]) > 2:
            return walk, False
        step = (curve, network.curves[curve].nodes[0] != node)
        if network.curves[curve].closed:
            step = (curve, walk[-1][1])
        if step == first:
            return walk, True
        walk.append(step)
