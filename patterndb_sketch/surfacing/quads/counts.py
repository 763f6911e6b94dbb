"""Edge counts: how many edges every curve gets, so that cycles have regular quad meshes.

A disk of quads has an even boundary, of four edges or more; one with four corners has no irregular
vertex only if opposite sides have equal numbers. A curve between two patches counts for both, so
that the counts of a network must be chosen together: as those of a network in retopology are
(:mod:`patterndb_sketch.retopo.counts`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.retopo.counts import FLOW_REGULARITY, CountsProblem, solve_counts
from patterndb_sketch.surfacing.quads.bridge import find_sides
from patterndb_sketch.surfacing.sampling import (
    Sampling,
    check_spacing,
    default_spacing,
    edges_at,
    loop_of,
    sample,
    stretches,
)
from patterndb_sketch.surfacing.tessellation import minimal_area

#: A chain of a problem of counts is a side of two patches at most.
MOST_PATCHES = 2


@dataclass(frozen=True, slots=True)
class EvenEdges:
    """Edge counts with which every cycle is even.

    edges:     edges of every stretch of every curve, as
               :func:`patterndb_sketch.surfacing.sampling.sample` takes them.
    irregular: places of the cycles that have no regular fill with these counts: more irregular
               vertices than their number of sides asks for.
    """

    edges: tuple[tuple[int, ...], ...]
    irregular: tuple[int, ...]


def count_even_edges(
    network: CurveNetwork, cycles: Sequence[Cycle], spacing: float | None = None
) -> EvenEdges:
    """Choose edges for every stretch of every curve such that each cycle has an even number, >= 4.

    The counts are near the spacing, and regular where the network allows it: an edge too many or
    too few has a price, and so has a cycle without a regular fill, as
    :func:`patterndb_sketch.retopo.counts.solve_counts` weighs them. No count is below the fewest
    edges that keep a stretch's shape (:func:`edges_at`). The sides of a cycle are those that fills
    have (:func:`.bridge.find_sides`); of cycles with reflex corners only evenness is asked for. A
    stretch in more than two cycles always gets an even number.

    Parameters
    ----------
    network : CurveNetwork
    cycles : sequence of Cycle
        Walks along curves of the network; a curve may be in any number of them.
    spacing : float, optional
        About how long an edge is to be, by default :func:`default_spacing`.

    Raises
    ------
    InvalidNetworkError
        For a spacing that is not above 0, a network without curves, and cycles that
        :meth:`CurveNetwork.walk` refuses.
    """
    spacing = default_spacing(network) if spacing is None else spacing
    check_spacing(spacing)
    for cycle in cycles:
        network.walk(cycle)
    fewest = [edges_at(curve, math.inf) for curve in network.curves]
    wanted = [
        [
            max(float(arc_length(part)[-1]) / spacing, float(few))
            for part, few in zip(stretches(curve), of_curve, strict=True)
        ]
        for curve, of_curve in zip(network.curves, fewest, strict=True)
    ]
    counts = [[_round(length) for length in of_curve] for of_curve in wanted]
    first = [0, *accumulate(len(of_curve) for of_curve in counts)]
    chosen, irregular = _solve(
        _list_sides(network, cycles, first, counts, spacing),
        [length for of_curve in wanted for length in of_curve],
        [few for of_curve in fewest for few in of_curve],
        [count for of_curve in counts for count in of_curve],
    )
    return EvenEdges(tuple(tuple(chosen[a:b]) for a, b in pairwise(first)), irregular)


def _round(wanted: float) -> int:
    """Round a number >= 1 to the whole number nearest to it in proportion."""
    below = int(wanted)
    return below if wanted * wanted <= below * (below + 1) else below + 1


def _solve(
    patches: Sequence[Sequence[Sequence[int]]],
    wanted: Sequence[float],
    fewest: Sequence[int],
    counts: Sequence[int],
) -> tuple[list[int], tuple[int, ...]]:
    """Choose the counts of all stretches; those in no patch keep theirs.

    patches: for every one its sides, as stretches. Returns the patches without a regular fill, too.
    """
    uses = [0] * len(wanted)
    for stretch in (s for sides in patches for side in sides for s in side):
        uses[stretch] += 1
    of_chain: list[int] = []
    pinned: list[int] = []
    chain_of: dict[int, int] = {}

    def name(stretch: int) -> int:
        if stretch not in chain_of or uses[stretch] > MOST_PATCHES:
            chain_of[stretch] = len(of_chain)
            of_chain.append(stretch)
            # An even count suits any cycle; copies of one stretch must agree.
            even = max(2 * _round(max(wanted[stretch] / 2.0, 1.0)), 2 * -(-fewest[stretch] // 2))
            pinned.append(even if uses[stretch] > MOST_PATCHES else 0)
        return chain_of[stretch]

    chains = [[[name(stretch) for stretch in side] for side in sides] for sides in patches]
    problem = CountsProblem.of(
        [wanted[stretch] for stretch in of_chain],
        chains,
        pinned,
        least=[fewest[stretch] for stretch in of_chain],
        regularity=FLOW_REGULARITY,
    )
    found = solve_counts(problem)
    assert not found.stuck, "stretches that are pinned have even counts"
    chosen = list(counts)
    for stretch, count in zip(of_chain, found.counts.tolist(), strict=True):
        chosen[stretch] = count
    return chosen, tuple(found.irregular.tolist())


def _list_sides(
    network: CurveNetwork,
    cycles: Sequence[Cycle],
    first: Sequence[int],
    counts: Sequence[Sequence[int]],
    spacing: float,
) -> list[list[list[int]]]:
    """List for every cycle its sides, as numbers of stretches: first[curve] is a curve's first.

    Corners are looked for on the least surface of the cycle, sampled about as it will be.
    """
    # Two edges or more each: every cycle encloses something then.
    about = [[max(count, 2) for count in of_curve] for of_curve in counts]
    sampling = sample(network, spacing, about)
    return [_part_cycle(network, sampling, cycle, first, about) for cycle in cycles]


def _part_cycle(
    network: CurveNetwork,
    sampling: Sampling,
    cycle: Cycle,
    first: Sequence[int],
    about: Sequence[Sequence[int]],
) -> list[list[int]]:
    walked: list[int] = []
    edges: list[int] = []
    for curve, backward in cycle.steps:
        sense = -1 if backward else 1
        walked += range(first[curve], first[curve + 1])[::sense]
        edges += about[curve][::sense]
    loop = loop_of(network, sampling, cycle)
    try:
        convex, reflex = find_sides(loop, loop.points, minimal_area(loop.points)[0])
    except InvalidNetworkError:
        # Of a loop that is too long for that only evenness is asked for.
        return [walked]
    begins = [0, *accumulate(edges[:-1])]
    corners = [k for k, at in enumerate(begins) if convex[at]]
    if reflex.any() or not corners:
        return [walked]
    turned = walked[corners[0] :] + walked[: corners[0]]
    cuts = [k - corners[0] for k in corners] + [len(walked)]
    return [turned[a:b] for a, b in pairwise(cuts)]
