"""Choose and change how many edges every chain of a network has.

:class:`NumberedCounts` is a network as a problem of :mod:`patterndb_sketch.retopo.counts`. How
many edges a chain needs at least to keep its shape follows from its curvature
(:func:`count_fewest_edges`): an edge of length e cuts a sagitta of e^2 kappa / 8 off a curve of
curvature kappa. Counts are chosen near length / target edge, but strips tie opposite sides of
patches together, and a round end may get half of that, which flattens it. Where density is painted,
a chain's target edge is the mean of what is asked for along it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from patterndb._native.retopo.filling.edgecounts import count_bend_edges
from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts import (
    FLOW_REGULARITY,
    MOST_NEIGHBOURHOODS,
    CountsProblem,
    Stuck,
    change_count,
    even_by_fewest_changes,
    solve_counts,
)
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Chain, Density, Network, Patch

#: Edges around a patch, at least.
FEWEST = 4


@dataclass(frozen=True, slots=True, eq=False)
class NumberedCounts:
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
    ) -> NumberedCounts:
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
        asked = [_measure_density(network.chains[c], network.density) for c in chains]
        problem = CountsProblem.of(
            [
                max(network.chains[c].length * dense / edge, 1e-6)
                for c, dense in zip(chains, asked, strict=True)
            ],
            [[[number[half >> 1] for half in side] for side in patch.sides] for patch in chosen],
            [held.get(c, 0) for c in chains],
            least=[
                _count_least(network.chains[c], edge / dense, anew)
                for c, dense in zip(chains, asked, strict=True)
            ],
            # What was painted was meant: an edge amiss costs no less than on a bare chain, and
            # more the further it is from bare. Else nothing but regular grids would come of it.
            urgency=[max(dense, 1.0) * (1.0 + abs(math.log2(dense))) for dense in asked],
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

    def describe_stuck(self, stuck: Iterable[Stuck]) -> tuple[str, ...]:
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


def count_perimeter(network: Network, patch: Patch) -> int:
    """Edges around a patch."""
    return sum(network.chains[half >> 1].count for half in patch.loop)


def side_lengths(network: Network, patch: Patch) -> tuple[int, ...]:
    """Edges of every side of a patch."""
    return tuple(sum(network.chains[half >> 1].count for half in side) for side in patch.sides)


def complete_counts(network: Network, edge: float) -> tuple[Network, tuple[str, ...]]:
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
        part = NumberedCounts.of(network, edge, new, settled, anew=True)
        network = part.put(network, solve_counts(part.problem).counts)
    if all(_is_sound(network, patch) for patch in network.patches.values()):
        return network, ()
    whole = NumberedCounts.of(network, edge)
    evened = even_by_fewest_changes(whole.problem, whole.counts(network))
    return whole.put(network, evened.counts), whole.describe_stuck(evened.stuck)


def choose_counts(
    network: Network,
    edge: float,
    held: Collection[int] = (),
    searches: int = MOST_NEIGHBOURHOODS,
) -> tuple[Network, tuple[str, ...]]:
    """The network with all counts but pinned ones chosen anew, as near to the target edge and as
    regular as can be; and notes. held: chains that keep theirs for once, too. Networks that a draft
    laid curves of are to be regular above all."""
    kept = {c: network.chains[c].count for c in held if network.chains[c].count}
    whole = NumberedCounts.of(network, edge, None, kept, anew=True)
    drafted = any(chain.auto for chain in network.chains.values())
    problem = whole.problem.with_regularity(FLOW_REGULARITY) if drafted else whole.problem
    found = solve_counts(problem, searches)
    return whole.put(network, found.counts), whole.describe_stuck(found.stuck)


def change_counts(
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
        network = _put_counts(network, lone, pin)
    asked = {c: n for c, n in chains.items() if c in used}
    notes: tuple[str, ...] = ()
    if len(asked) == 1:
        # One alone is made room for around it.
        ((chain, count),) = asked.items()
        network, _ = complete_counts(network, edge)
        whole = NumberedCounts.of(network, edge)
        made = change_count(whole.problem, whole.counts(network), whole.chains.index(chain), count)
        network, notes = whole.put(network, made.counts), whole.describe_stuck(made.stuck)
    elif asked:
        network, _ = complete_counts(network, edge)
        held = NumberedCounts.of(network, edge, None, asked)
        evened = even_by_fewest_changes(held.problem, held.counts(network))
        network, notes = held.put(network, evened.counts), held.describe_stuck(evened.stuck)
    return _put_counts(network, asked, pin), notes


def free_counts(network: Network, chains: Iterable[int]) -> Network:
    """The network with some counts no longer pinned; they stay until they are chosen anew."""
    new = {c: replace(network.chain(c), pinned=False) for c in chains}
    return replace(network, chains={**network.chains, **new})


def find_strip(network: Network, chain: int) -> tuple[int, ...]:
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


def _measure_density(chain: Chain, density: Density) -> float:
    """The mean of the density along a chain; exactly 1 where nothing is painted."""
    lengths, measured = density.measure(chain.round, chain.round_normals)
    return 1.0 if measured is lengths else float(measured[-1] / lengths[-1])


def _count_least(chain: Chain, edge: float, anew: bool) -> int:
    """The fewest edges that a chain may get so as to keep its shape."""
    needed = count_fewest_edges(chain, edge)
    return needed if anew else min(needed, chain.count)


def _is_sound(network: Network, patch: Patch) -> bool:
    edges = count_perimeter(network, patch)
    if edges % 2 or edges < FEWEST:
        return False
    # A side of one edge has no strict fill but where there are four.
    alone = [side[0] >> 1 for side in patch.sides if len(side) == 1]
    return len(patch.sides) == 4 or all(
        network.chains[c].count > 1 or network.chains[c].pinned for c in alone
    )


def _put_counts(network: Network, counts: Mapping[int, int], pin: bool) -> Network:
    new = {
        c: replace(network.chains[c], count=n, pinned=pin or network.chains[c].pinned)
        for c, n in counts.items()
    }
    return replace(network, chains={**network.chains, **new})


#: An edge may cut so much off a curve, in target edges. A ring of four edges of the target length
#: around a limb cuts off 0.21, one of six 0.13.
SAGITTA = 0.125

#: No edge is longer than so many target edges: then the surface between curves leaves the quads,
#: however straight the curves are. Below 1.5 irregular vertices multiply.
STRETCH = 1.6

#: Steps in which curvature is measured, to a target edge: finer ones measure the surface's
#: triangles.
STEPS = 4

#: Steps of a short curve, at least.
FEWEST_STEPS = 8


def count_fewest_edges(chain: Chain, edge: float) -> int:
    """The fewest edges, 1 or more, with which a chain keeps its shape.

    edge: target length. Where curvature is even, every edge then cuts off SAGITTA at most; where it
    is not, edges are as dense as each part asks for, on the average: e = sqrt(8 SAGITTA edge /
    kappa). A sharp corner asks for none, as no number of edges cuts little off it.
    """
    in_edges = chain.length / edge
    steps = max(FEWEST_STEPS, math.ceil(STEPS * in_edges))
    bends = count_bend_edges(np.ascontiguousarray(chain.round), chain.is_closed_loop, steps, edge)
    # A full circle's edges are a whole number but for rounding.
    return max(1, math.ceil(max(bends, in_edges / STRETCH) - 1e-9))
