"""A layout with counts: how many quads it gives, and how good it is, before any is filled."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from patterndb_sketch.retopo.filling import choose_counts
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.network import Network


@dataclass(frozen=True, slots=True)
class DraftSetting:
    """alignment: how much directions of curvature weigh. merging: singularities of opposed
    indices nearer than this, in target edges, are cancelled. finer: edges are so many times as
    long as asked for, where those come too far off the surface."""

    alignment: float
    merging: float
    finer: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class DraftedNetwork:
    """A draft: a network with counts on every chain. laid: the chains that are the draft's own.
    kept: the patches that are not. singular: irregular vertices of its field. edge: of its counts.
    """

    network: Network
    laid: frozenset[int]
    kept: frozenset[int]
    singular: int
    edge: float


#: Quads are as many as wanted within this share, as far as rounds of scaling the edge come to it.
NEAR_ENOUGH, SCALINGS = 0.03, 6

#: Neighbourhoods in which counts of the draft that is made are improved.
SEARCHED = 4


def count_quads(network: Network) -> float:
    """About how many quads the fills of a network with counts have."""
    total = 0.0
    for patch in network.patches.values():
        n = side_lengths(network, patch)
        total += 0.25 * (n[0] + n[2]) * (n[1] + n[3]) if len(n) == 4 else (sum(n) / 4.0) ** 2
    return total


def scale_counts(network: Network, edge: float, wanted: float) -> tuple[Network, float]:
    """The network with counts for about so many quads: bounds that curvature sets go with the edge,
    so that a coarse mesh is not finer than it is to be; in the end they fall."""
    best: tuple[float, Network, float] | None = None
    low, high = 0.0, np.inf
    for _ in range(SCALINGS):
        counted, _ = choose_counts(network, edge, searches=0)
        ratio = count_quads(counted) / wanted
        if best is None or abs(np.log(ratio)) < best[0]:
            best = abs(float(np.log(ratio))), counted, edge
        if abs(ratio - 1.0) < NEAR_ENOUGH:
            break
        if ratio > 1.0:
            low = max(low, edge)
        else:
            high = min(high, edge)
        edge *= float(np.sqrt(ratio))
        if not low < edge < high:
            edge = float(np.sqrt(low * high)) if np.isfinite(high) and low else edge
    assert best is not None
    return best[1], best[2]


def improve_counts(draft: DraftedNetwork, wanted: float) -> DraftedNetwork:
    """With better counts, which take long to find, where there are as many quads then."""
    better, _ = choose_counts(draft.network, draft.edge, searches=SEARCHED)
    if abs(float(np.log(count_quads(better) / wanted))) > 2.0 * NEAR_ENOUGH:
        return draft
    return replace(draft, network=better)


def measure_layout(draft: DraftedNetwork) -> tuple[float, float]:
    """About how many irregular vertices a draft will have, and how uneven its edges will be."""
    network = draft.network
    odd = 0
    for patch in network.patches.values():
        n = side_lengths(network, patch)
        odd += len(n) != 4 or n[0] != n[2] or n[1] != n[3]
    count = np.array([chain.count for chain in network.chains.values()], float)
    length = np.array([chain.length for chain in network.chains.values()])
    used = count > 0
    mean = length[used].sum() / count[used].sum()
    off = np.sqrt(np.average((length[used] / count[used] / mean - 1.0) ** 2, weights=count[used]))
    return draft.singular + 2.0 * odd, float(off)


#: So many irregular vertices in a thousand quads weigh as much as edges that differ by so much.
ODD_IN_THOUSAND, UNEVEN = 20.0, 0.2


def price_layout(draft: DraftedNetwork) -> float:
    odd, uneven = measure_layout(draft)
    return 1000.0 * odd / count_quads(draft.network) / ODD_IN_THOUSAND + uneven / UNEVEN
