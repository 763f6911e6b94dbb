"""A network's curves in an order and sense of their own, whatever those they were given in.

Among equally good choices the solver takes what its numbers happen to favour. With numbers that
follow from the points alone, the same curves give the same cycles in whatever order they come.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.network import Curve, Cycle, Network, curves_at


@dataclass(frozen=True, slots=True)
class Renamed:
    """A network in its own order.

    network: the network; it has no cycles.
    curves:  for each of its curves the number in the network it came from.
    turned:  whether it runs the other way there.
    """

    network: Network
    curves: tuple[int, ...]
    turned: tuple[bool, ...]

    def there(self, cycle: Cycle) -> Cycle:
        """A cycle of this network in the one it came from."""
        return Cycle(tuple((self.curves[c], back != self.turned[c]) for c, back in cycle.steps))

    def here(self, cycle: Cycle) -> Cycle:
        """A cycle of the network it came from in this one."""
        place = {old: new for new, old in enumerate(self.curves)}
        steps = ((place[c], back) for c, back in cycle.steps)
        return Cycle(tuple((c, back != self.turned[c]) for c, back in steps))


def in_own_order(network: Network) -> Renamed:
    """The network with nodes and curves ordered, and curves turned, by their points."""
    used = [node for node, steps in enumerate(curves_at(network)) if steps]
    order = sorted(used, key=lambda node: (tuple(network.nodes[node]), node))
    place = {old: new for new, old in enumerate(order)}
    made: list[tuple[object, Curve, int, bool]] = []
    for number, curve in enumerate(network.curves):
        first, last = (place[node] for node in curve.nodes)
        forth, back = _flat(curve.points), _flat(curve.points[::-1])
        turned = (last, back) < (first, forth)
        points = np.ascontiguousarray(curve.points[::-1]) if turned else curve.points
        nodes = (last, first) if turned else (first, last)
        key = (nodes, min(forth, back), number)
        made.append((key, Curve(points, nodes, curve.id, curve.stroke), number, turned))
    made.sort(key=lambda one: one[0])  # type: ignore[arg-type, return-value]
    return Renamed(
        Network(tuple(curve for _, curve, _, _ in made), network.nodes[order]),
        tuple(number for _, _, number, _ in made),
        tuple(turned for _, _, _, turned in made),
    )


def _flat(points: Points) -> tuple[float, ...]:
    return tuple(points.ravel().tolist())
