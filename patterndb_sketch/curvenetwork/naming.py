"""Cycles by name: which walk around the network the ids of its curves mean."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from patterndb_sketch.curvenetwork.network import (
    CurveId,
    CurveNetwork,
    Cycle,
    InvalidNetworkError,
    Step,
    turn_walk,
)

#: For every curve id, the walks along the network that the drawn curves of that name became.
Walks = Mapping[CurveId, Sequence[Sequence[Step]]]


@dataclass(frozen=True, slots=True)
class NamedCurve:
    """A curve in a cycle, by name.

    curve:    the id of the curve.
    backward: whether it is walked from its end to its beginning; None: whichever closes.
    part:     of the parts that nodes split it into, the only one walked, counted from 0 along
              the curve; None: those between where it meets its neighbours in the cycle.
    """

    curve: CurveId
    backward: bool | None = None
    part: int | None = None


def walks_of(network: CurveNetwork) -> dict[CurveId, list[list[Step]]]:
    """The walks that curves of one id make, as far as each continues the one before."""
    walks: dict[CurveId, list[list[Step]]] = {}
    for number, curve in enumerate(network.curves):
        of_id = walks.setdefault(curve.id, [])
        if of_id and network.ends(of_id[-1][-1])[1] == curve.nodes[0]:
            of_id[-1].append((number, False))
        else:
            of_id.append([(number, False)])
    return walks


def named_cycle(
    network: CurveNetwork, names: Sequence[CurveId | NamedCurve], walks: Walks | None = None
) -> Cycle:
    """The cycle that passes the curves of these names in this order.

    names: ids of curves, or their texts ("7" for 7). Of a curve that nodes split, the parts
    are taken between where it meets its neighbours in the cycle; where several choices close,
    the shortest walk. walks: what the ids stand for, by default :func:`walks_of`.

    Raises InvalidNetworkError for an id that is not there, for neighbours that do not meet,
    and for curves that do not close or pass a node twice.
    """
    walks = walks_of(network) if walks is None else walks
    entries = [name if isinstance(name, NamedCurve) else NamedCurve(name) for name in names]
    if not entries:
        raise InvalidNetworkError("a cycle needs at least one curve")
    options = [_CurveWalks(network, entry, walks) for entry in entries]
    joints = [sorted(options[i - 1].nodes & options[i].nodes) for i in range(len(options))]
    for i, shared in enumerate(joints):
        if not shared:
            raise InvalidNetworkError(
                f"curves {entries[i - 1].curve!r} and {entries[i].curve!r} do not meet; name "
                "curves in the order of a closed walk"
            )
    best: tuple[float, tuple[Step, ...]] | None = None
    for start in joints[0]:
        reached: dict[int, tuple[float, tuple[Step, ...]]] = {start: (0.0, ())}
        for i, option in enumerate(options):
            ends = joints[i + 1] if i + 1 < len(options) else [start]
            following: dict[int, tuple[float, tuple[Step, ...]]] = {}
            for end in ends:
                ways = [
                    (length + more, (*steps, *added))
                    for node, (length, steps) in reached.items()
                    for more, added in option.between(node, end)
                ]
                if ways:
                    following[end] = min(ways)
            reached = following
        if start in reached and (best is None or reached[start] < best):
            best = reached[start]
    if best is None:
        raise InvalidNetworkError(
            f"the curves {[entry.curve for entry in entries]} do not close; name curves in the "
            "order of a closed walk"
        )
    cycle = Cycle(best[1])
    network.walk(cycle)
    return cycle


class _CurveWalks:
    """The walks along one named curve."""

    __slots__ = ("_backward", "_chains", "_network", "nodes")

    def __init__(self, network: CurveNetwork, entry: NamedCurve, walks: Walks) -> None:
        chains = [list(walk) for walk in _walks_named(entry.curve, walks)]
        if entry.part is not None:
            parts = [step for chain in chains for step in chain]
            if not 0 <= entry.part < len(parts):
                raise InvalidNetworkError(
                    f"curve {entry.curve!r} has {len(parts)} parts, and no part {entry.part}; "
                    "parts are counted from 0"
                )
            chains = [[parts[entry.part]]]
        self._network = network
        self._chains = chains
        self._backward = entry.backward
        self.nodes = {node for chain in chains for step in chain for node in network.ends(step)}

    def between(self, first: int, last: int) -> list[tuple[float, tuple[Step, ...]]]:
        """All walks from node to node, each with its length."""
        found: list[tuple[float, tuple[Step, ...]]] = []
        for chain in self._chains:
            if not self._backward:
                found += self._along(chain, first, last)
            if self._backward is not False:
                found += self._along(turn_walk(chain), first, last)
        return found

    def _along(
        self, chain: Sequence[Step], first: int, last: int
    ) -> list[tuple[float, tuple[Step, ...]]]:
        passed = [self._network.ends(step)[0] for step in chain]
        passed.append(self._network.ends(chain[-1])[1])
        steps = chain
        n = len(chain)
        if passed[0] == passed[-1]:
            # Closed: a walk may pass where the chain begins, and is once around at most.
            passed = passed[:-1] + passed
            steps = (*chain, *chain)
        starts = [i for i in range(n) if passed[i] == first]
        found: list[tuple[float, tuple[Step, ...]]] = []
        for i in starts:
            for j in range(i + 1, min(i + n, len(steps)) + 1):
                if passed[j] == last:
                    walk = tuple(steps[i:j])
                    curves = self._network.curves
                    found.append((sum(curves[curve].length for curve, _ in walk), walk))
        return found


def _walks_named(name: CurveId, walks: Walks) -> Sequence[Sequence[Step]]:
    if name in walks:
        return walks[name]
    alike = [known for known in walks if str(known) == name]
    if len(alike) == 1:
        return walks[alike[0]]
    known = ", ".join(repr(one) for one in list(walks)[:8]) + (", …" if len(walks) > 8 else "")
    raise InvalidNetworkError(f"there is no curve {name!r}; curves are {known or 'none'}")


def list_parts(network: CurveNetwork, names: Iterable[CurveId]) -> dict[CurveId, list[int]]:
    """List for every name the numbers of the curves that have it as their id."""
    parts: dict[CurveId, list[int]] = {name: [] for name in names}
    for number, curve in enumerate(network.curves):
        parts[curve.id].append(number)
    return parts


def parts_of(network: CurveNetwork) -> list[int | None]:
    """For every curve, which part of its id it is, None where the id is its own alone."""
    numbers: dict[CurveId, list[int]] = {}
    for number, curve in enumerate(network.curves):
        numbers.setdefault(curve.id, []).append(number)
    parts: list[int | None] = [None] * len(network.curves)
    for of_id in numbers.values():
        if len(of_id) > 1:
            for part, number in enumerate(of_id):
                parts[number] = part
    return parts
