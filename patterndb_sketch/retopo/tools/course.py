"""Mend the course of a chain after it moved: even samples, and what it crosses now."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from patterndb._native.retopo.network.attaching import find_departure, measure_turn
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network.attaching import list_departures, measure_reach
from patterndb_sketch.retopo.network.crossings import find_crossings, find_self_crossings
from patterndb_sketch.retopo.network.samples import interpolate_places, take_chain_samples
from patterndb_sketch.retopo.network.structure import Chain, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tracing.curves import take_to_surface

#: Samples that are more than this many samplings apart, or in the mean less than one part in as
#: many, are set anew: until then a chain keeps the samples it has.
UNEVEN = 2.0


def even_course(
    points: Points, normals: Points, surface: Surface, sizes: Sizes, closed: bool
) -> tuple[Points, Points]:
    """A course (n, 3) with samples at equal arc length if they have come too far apart, or too
    near; else as it is. The ends of an open one stay exactly; a closed one repeats no point."""
    line = np.concatenate([points, points[:1]]) if closed else points
    along = arc_length(line)
    steps = np.diff(along)
    if steps.max() <= UNEVEN * sizes.sampling and steps.mean() >= sizes.sampling / UNEVEN:
        return points, normals
    edges = max(3 if closed else 2, round(along[-1] / sizes.sampling))
    wanted = np.linspace(0.0, along[-1], edges + 1)[: edges if closed else edges + 1]
    places = np.interp(wanted, along, np.arange(len(along)))
    up = interpolate_places(points, normals, places)[1]
    even, up = take_to_surface(at_lengths(line, wanted), up, surface, sizes)
    if not closed:
        even[[0, -1]], up[[0, -1]] = points[[0, -1]], normals[[0, -1]]
    return even, up


def find_crossed(network: Network, chains: Iterable[int], near: float) -> set[int]:
    """The chains that some chains cross, these among them where they cross themselves or each
    other. Where two meet in a node, what is within ``near`` of it is no crossing."""
    found: set[int] = set()
    for chain in sorted(set(chains)):
        line = network.chains[chain]
        others = {k: other for k, other in network.chains.items() if k != chain}
        met = find_crossings(
            line.points, line.normals, line.is_closed_loop, take_chain_samples(others)
        )
        where = interpolate_places(line.points, line.normals, met.along)[0]
        for k, other in enumerate(met.chain):
            if not _is_at_node(network, line, network.chains[int(other)], where[k], near):
                found.add(int(other))
        own = find_self_crossings(line.points, line.normals, line.is_closed_loop)
        where = interpolate_places(line.points, line.normals, own.along)[0]
        if any(not _is_at_node(network, line, line, at, near) for at in where):
            found.add(chain)
    return found


def note_crossings(
    before: Network, network: Network, chains: Iterable[int], sizes: Sizes
) -> list[str]:
    """What to say if chains that moved cross others now, and did not before."""
    moved = [chain for chain in set(chains) if chain in network.chains]
    kept = [chain for chain in moved if chain in before.chains]
    notes: list[str] = []
    now = find_crossed(network, moved, sizes.sampling)
    new = now - find_crossed(before, kept, sizes.sampling) if now else now
    if new:
        notes.append(
            f"the curve crosses {len(new)} others, or itself, now: move it back, or erase what it "
            "crosses"
        )
    turned = _find_disordered(network, moved)
    if turned and turned - _find_disordered(before, kept):
        notes.append(
            "the curve crosses another right at the corner where both end: move it back, or "
            "erase one"
        )
    return notes


def _find_disordered(network: Network, chains: Iterable[int]) -> set[int]:
    """Nodes at which some chains end, around which curves leave in another order than they are
    kept in: one was moved past another there."""
    found: set[int] = set()
    nodes = {node for k in chains for node in (network.chains[k].start, network.chains[k].end)}
    for node in nodes & network.nodes.keys():
        at = network.nodes[node]
        reach = measure_reach(network.chains[half >> 1] for half in at.ends)
        ways = [find_departure(*one, reach) for one in list_departures(network.chains, at.ends)]
        turns = [measure_turn(at.normal, ways[k - 1], way) for k, way in enumerate(ways)]
        if len(ways) > 2 and sum(turns) > 3.0 * math.pi:
            found.add(node)
    return found


def _is_at_node(network: Network, one: Chain, two: Chain, point: Points, near: float) -> bool:
    shared = {one.start, one.end} & {two.start, two.end}
    nodes = [network.nodes[node] for node in shared if node in network.nodes]
    return any(np.linalg.norm(node.point - point) <= near for node in nodes)
