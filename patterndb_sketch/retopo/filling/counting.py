"""Counting: the numbers of edges of a network's chains, chosen and changed."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts import CountsProblem, choose
from patterndb_sketch.retopo.counts import changed as changed_counts
from patterndb_sketch.retopo.counts.evening import Stuck, fewest_changes
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.bending import fewest_edges
from patterndb_sketch.retopo.network import Chain, Network, Patch

#: Edges around a patch, at least.
FEWEST = 4


@dataclass(frozen=True, slots=True, eq=False)
class Numbering:
    """A network's counts as a problem of :mod:`patterndb_sketch.retopo.counts`.

    chains: (c,) ids of the chains in the order of the problem. patches: ids, the same.
    """

    problem: CountsProblem
    chains: tuple[int, ...]
    patches: tuple[int, ...]

    @classmethod
    def of(
        cls,
        network: Network,
        edge: float,
        patches: Collection[int] | None = None,
        pinned: Mapping[int, int] | None = None,
        *,
        anew: bool = False,
    ) -> Numbering:
        """Of some patches, or all, and their chains.

        edge: target length of an edge. pinned: counts of chains by id to hold beside those that
        the user has pinned. anew: shall all other chains have the edges that their shapes need?
        Else only those do that have them already, and few are to change.
        """
        chosen = [
            network.patches[p] for p in sorted(network.patches if patches is None else patches)
        ]
        chains = sorted({half >> 1 for patch in chosen for half in patch.loop})
        number = {chain: k for k, chain in enumerate(chains)}
        held = dict(pinned or {})
        held.update({c: network.chains[c].count for c in chains if network.chains[c].pinned})
        problem = CountsProblem.of(
            [max(network.chains[c].length / edge, 1e-6) for c in chains],
            [[[number[half >> 1] for half in side] for side in patch.sides] for patch in chosen],
            [held.get(c, 0) for c in chains],
            least=[_least(network.chains[c], edge, anew) for c in chains],
        )
        return cls(problem, tuple(chains), tuple(patch.id for patch in chosen))

    def counts(self, network: Network) -> Int32Array:
        """(c,) the network's own."""
        return np.array([network.chains[c].count for c in self.chains], np.int32)

    def put(self, network: Network, counts: Int32Array) -> Network:
        """The network with these counts."""
        new = {
            c: replace(network.chains[c], count=int(n))
            for c, n in zip(self.chains, counts, strict=True)
            if network.chains[c].count != n
        }
        return replace(network, chains={**network.chains, **new}) if new else network

    def told(self, stuck: Iterable[Stuck]) -> tuple[str, ...]:
        """What cannot be, in words with the network's ids."""
        return tuple(
            str(
                replace(
                    one,
                    patches=tuple(self.patches[p] for p in one.patches),
                    pinned=tuple(self.chains[c] for c in one.pinned),
                )
            )
            for one in stuck
        )


def perimeter(network: Network, patch: Patch) -> int:
    """Edges around a patch."""
    return sum(network.chains[half >> 1].count for half in patch.loop)


def lengths(network: Network, patch: Patch) -> tuple[int, ...]:
    """Edges of every side of a patch."""
    return tuple(sum(network.chains[half >> 1].count for half in side) for side in patch.sides)


def counted(network: Network, edge: float) -> tuple[Network, tuple[str, ...]]:
    """The network with a count for every chain of a patch, all patches even; and notes.

    edge: target length of an edge. Chains that have a count keep it, and those without are
    chosen for the patches that they are in; only if that leaves a patch odd are as few others
    changed as can be. Pinned counts stay; what they make impossible is in the notes.
    """
    new = {
        patch.id
        for patch in network.patches.values()
        if any(network.chains[half >> 1].count == 0 for half in patch.loop)
    }
    if new:
        settled = {c: chain.count for c, chain in network.chains.items() if chain.count}
        part = Numbering.of(network, edge, new, settled, anew=True)
        network = part.put(network, choose(part.problem).counts)
    if all(_sound(network, patch) for patch in network.patches.values()):
        return network, ()
    whole = Numbering.of(network, edge)
    evened = fewest_changes(whole.problem, whole.counts(network))
    return whole.put(network, evened.counts), whole.told(evened.stuck)


def chosen_anew(network: Network, edge: float) -> tuple[Network, tuple[str, ...]]:
    """The network with all counts but pinned ones chosen anew, as near to the target edge and as
    regular as can be; and notes."""
    whole = Numbering.of(network, edge, anew=True)
    found = choose(whole.problem)
    return whole.put(network, found.counts), whole.told(found.stuck)


def changed(
    network: Network, edge: float, chains: Mapping[int, int], *, pin: bool = True
) -> tuple[Network, tuple[str, ...]]:
    """The network with the counts of some chains changed by the user; and notes.

    chains: new counts, 1 or more, by id; pin: later choices leave them as they are. Others
    change where a patch would be odd, as few as can be. Raises InvalidRetopoError for a chain
    that is not there, and RefusedError for a count below 1.
    """
    for chain, count in chains.items():
        network.chain(chain)
        if count < 1:
            raise RefusedError(f"chain {chain} would have {count} edges; the least is 1")
    used = {half >> 1 for patch in network.patches.values() for half in patch.loop}
    lone = {c: n for c, n in chains.items() if c not in used}
    if lone:
        network = _with_counts(network, lone, pin)
    asked = {c: n for c, n in chains.items() if c in used}
    notes: tuple[str, ...] = ()
    if len(asked) == 1:
        # One alone is made room for around it.
        ((chain, count),) = asked.items()
        network, _ = counted(network, edge)
        whole = Numbering.of(network, edge)
        made = changed_counts(
            whole.problem, whole.counts(network), whole.chains.index(chain), count
        )
        network, notes = whole.put(network, made.counts), whole.told(made.stuck)
    elif asked:
        network, _ = counted(network, edge)
        held = Numbering.of(network, edge, None, asked)
        evened = fewest_changes(held.problem, held.counts(network))
        network, notes = held.put(network, evened.counts), held.told(evened.stuck)
    return _with_counts(network, asked, pin), notes


def freed(network: Network, chains: Iterable[int]) -> Network:
    """The network with some counts no longer pinned; they stay until they are chosen anew."""
    new = {c: replace(network.chain(c), pinned=False) for c in chains}
    return replace(network, chains={**network.chains, **new})


def strip(network: Network, chain: int) -> tuple[int, ...]:
    """The chains on the strip of quads through a chain: opposite sides of four-sided patches, from
    patch to patch both ways, where each is one chain. The chain itself is the first.
    """
    network.chain(chain)
    taken = network.patch_of()
    found = {chain: None}
    queue = [2 * chain, 2 * chain + 1]
    while queue:
        half = queue.pop()
        patch = taken.get(half)
        if patch is None:
            continue
        sides = network.patches[patch].sides
        at = next(k for k, side in enumerate(sides) if half in side)
        if len(sides) != 4 or len(sides[at]) != 1 or len(sides[at - 2]) != 1:
            continue
        over = sides[at - 2][0]
        if over >> 1 not in found:
            found[over >> 1] = None
            queue.append(over ^ 1)
    return tuple(found)


def _least(chain: Chain, edge: float, anew: bool) -> int:
    """The fewest edges that a chain may get so as to keep its shape."""
    needed = fewest_edges(chain, edge)
    return needed if anew else min(needed, chain.count)


def _sound(network: Network, patch: Patch) -> bool:
    edges = perimeter(network, patch)
    if edges % 2 or edges < FEWEST:
        return False
    # A side of one edge has no strict fill but where there are four.
    alone = [side[0] >> 1 for side in patch.sides if len(side) == 1]
    return len(patch.sides) == 4 or all(
        network.chains[c].count > 1 or network.chains[c].pinned for c in alone
    )


def _with_counts(network: Network, counts: Mapping[int, int], pin: bool) -> Network:
    new = {
        c: replace(network.chains[c], count=n, pinned=pin or network.chains[c].pinned)
        for c, n in counts.items()
    }
    return replace(network, chains={**network.chains, **new})
