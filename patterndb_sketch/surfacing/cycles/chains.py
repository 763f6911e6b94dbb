"""The network that cycles are looked for in: curves that go on into each other as one, in an order
that depends on their geometry alone.

A node at which two curves go on into each other, where nothing else meets them, tells nothing
about the surface: it is where a stroke was lifted, or where a stroke drawn twice ended. Measures
that look at nodes must not count it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.curvenetwork.network import (
    Curve,
    CurveNetwork,
    Cycle,
    Step,
    list_steps_at_nodes,
    turn_walk,
)
from patterndb_sketch.surfacing.cycles.closing import curve_ends

#: Curves that turn at a node by no more than this go on into each other; in radians.
SMOOTH = np.radians(30)


@dataclass(frozen=True, slots=True)
class ChainedNetwork:
    """A network whose curves are chains of curves of another one.

    network: the network; it has no cycles.
    chains:  for each of its curves the steps along the other network that it is.
    """

    network: CurveNetwork
    chains: tuple[tuple[Step, ...], ...]

    def there(self, cycle: Cycle) -> Cycle:
        """Return a cycle of the chained network as one of the network it came from."""
        steps: list[Step] = []
        for chain, backward in cycle.steps:
            steps += turn_walk(self.chains[chain]) if backward else self.chains[chain]
        return Cycle(tuple(steps))

    def here(self, cycle: Cycle) -> Cycle:
        """Return a cycle of the network it came from as one of the chained network."""
        of = {c: (k, b) for k, walk in enumerate(self.chains) for c, b in walk}
        steps: list[Step] = []
        for curve, backward in cycle.steps:
            chain, way = of[curve]
            step = (chain, way != backward)
            if not steps or steps[-1] != step or len(self.chains[chain]) == 1:
                steps.append(step)
        if len(steps) > 1 and steps[0] == steps[-1] and len(self.chains[steps[0][0]]) > 1:
            steps.pop()
        return Cycle(tuple(steps))


def chain_curves(network: CurveNetwork, gone: NDArray[np.bool_]) -> ChainedNetwork:
    """Make one curve of those that go on into each other. gone: which dangle, and do not count."""
    ends = curve_ends(network)
    at: list[list[Step]] = [[] for _ in network.nodes]
    for curve in np.flatnonzero(~gone).tolist():
        first, last = ends[curve].tolist()
        at[first].append((curve, False))
        at[last].append((curve, True))
    follows: dict[Step, Step] = {}
    for leaving in at:
        if len(leaving) != 2 or leaving[0][0] == leaving[1][0]:
            continue
        (a, from_a), (b, from_b) = leaving
        if _leave(network.curves[a], from_a) @ _leave(network.curves[b], from_b) > -np.cos(SMOOTH):
            continue
        # To come along a into the node is to leave along b.
        follows[a, not from_a] = b, from_b
        follows[b, not from_b] = a, from_a
    used: set[int] = set()
    chains: list[tuple[Step, ...]] = []
    curves: list[Curve] = []
    for curve in range(len(network.curves)):
        if curve in used:
            continue
        step = (curve, False)
        # Back to where the chain begins, or once around.
        before = {b: a for a, b in follows.items()}
        start = step
        while start in before and before[start] != step:
            start = before[start]
            if start[0] == curve:
                break
        walk = [start]
        while walk[-1] in follows and follows[walk[-1]] != start:
            walk.append(follows[walk[-1]])
        used.update(c for c, _ in walk)
        chains.append(tuple(walk))
        if len(walk) == 1:
            curves.append(network.curves[curve])
            continue
        parts = [network.curves[c].points[:: -1 if b else 1] for c, b in walk]
        points = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        first = network.curves[walk[0][0]].nodes[walk[0][1]]
        last = network.curves[walk[-1][0]].nodes[not walk[-1][1]]
        longest = max(walk, key=lambda s: network.curves[s[0]].length)[0]
        name = network.curves[longest]
        curves.append(Curve(points, (first, last), name.id, name.stroke))
    return ChainedNetwork(CurveNetwork(tuple(curves), network.nodes), tuple(chains))


def order_chains(chained: ChainedNetwork) -> ChainedNetwork:
    """Order nodes and curves, and turn curves, by their points; nodes without a curve go."""
    network = chained.network
    used = [node for node, steps in enumerate(list_steps_at_nodes(network)) if steps]
    order = sorted(used, key=lambda node: (tuple(network.nodes[node]), node))
    place = {old: new for new, old in enumerate(order)}
    made: list[tuple[object, Curve, tuple[Step, ...]]] = []
    for number, (curve, walk) in enumerate(zip(network.curves, chained.chains, strict=True)):
        first, last = (place[node] for node in curve.nodes)
        forth, back = (tuple(curve.points[::way].ravel().tolist()) for way in (1, -1))
        turned = (last, back) < (first, forth)
        points = np.ascontiguousarray(curve.points[::-1]) if turned else curve.points
        nodes = (last, first) if turned else (first, last)
        key = (nodes, min(forth, back), number)
        curve = Curve(points, nodes, curve.id, curve.stroke)
        made.append((key, curve, turn_walk(walk) if turned else walk))
    made.sort(key=lambda one: one[0])  # type: ignore[arg-type, return-value]
    curves = tuple(curve for _, curve, _ in made)
    ordered = CurveNetwork(curves, network.nodes[order])
    return ChainedNetwork(ordered, tuple(walk for _, _, walk in made))


def _leave(curve: Curve, backward: bool) -> NDArray[np.float64]:
    points = curve.points[::-1] if backward else curve.points
    # Over a tenth of the curve: its first edge may be a short one beside the node.
    steps = np.linalg.norm(points - points[0], axis=1)
    k = int(np.argmax(steps >= 0.1 * curve.length)) or 1
    step = points[k] - points[0]
    size = float(np.linalg.norm(step))
    return step / size if size > 0 else step
