"""A new chain's two ends among those of its nodes: both in one face, so that it crosses nothing.

Directions, gaps and crossings each say where around a node a curve goes, and where curves nearly
lie on each other they do not agree. What decides is the network itself: a chain between two
nodes of one part of it crosses no other if both its ends go into one face. So the network stays
a drawing on its surface (Euler's formula), whatever is measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.gaps import Gap, beside, pointed_into
from patterndb_sketch.retopo.network.handles import genus_of, handles_of
from patterndb_sketch.retopo.network.order import departure, turn
from patterndb_sketch.retopo.network.structure import HalfChain, Node
from patterndb_sketch.retopo.network.tables import Tables
from patterndb_sketch.retopo.network.walks import joined_chains, walked

#: What each end that is passed costs beside the angle to it, in radians: of two ways of the same
#: angle that past fewer ends is taken.
PASSED = 1e-3

#: On a surface with a handle a chain may lead from a face to another of the same part. It does not
#: where ends nearer than this, in radians, are all that is between: they lie on each other.
SLIGHT = 0.35

Gaps = tuple[Gap | None, Gap | None]


class SeparatedError(RefusedError):
    """Between two nodes there is no way that crosses nothing."""


@dataclass(frozen=True, slots=True)
class Wedges:
    """Where an end of a new chain may go around its node.

    node:   with its ends so far. wanted: the wedge that measures tell.
    costs:  of every wedge, what it takes to come there from the wanted one: the angles, in
            radians, between the new chain and the ends that are passed.
    """

    node: Node
    wanted: int
    costs: tuple[float, ...]


def attach(tables: Tables, chain: int, reach: float, gaps: Gaps = (None, None)) -> None:
    """Put a chain's halves among the ends of its nodes, with corners on either side.

    reach: arc length over which directions are taken; gaps: where its start and its end go, if
    that is known. Of the wedges of one face those nearest to that are taken.
    Raises SeparatedError if there are none; the chain is taken from the tables then.
    """
    line = tables.chains[chain]
    one = _wedges(tables, line.start, 2 * chain, reach, gaps[0])
    if line.start == line.end:
        inside: set[HalfChain] = {2 * chain}
        if one.node.ends:
            inside.update(walked(tables.nodes, tables.chains, one.node.ends[one.wanted]))
        before = {**tables.nodes}
        _put(tables, one.node.id, 2 * chain, one.wanted, gaps[0])
        two = _wedges(tables, line.end, 2 * chain + 1, reach, gaps[1])
        wedge = two.wanted
        if two.node.ends[wedge] not in inside and not _spare_handle(tables, before):
            around = (k for k, half in enumerate(two.node.ends) if half in inside)
            wedge = min(around, key=two.costs.__getitem__)
        _put(tables, line.end, 2 * chain + 1, wedge, gaps[1])
        return
    two = _wedges(tables, line.end, 2 * chain + 1, reach, gaps[1])
    found = _in_one_face(tables, one, two)
    if found is None:
        del tables.chains[chain]
        tables.touched_chains.discard(chain)
        raise SeparatedError(
            "the curve would pass through others without a crossing, where curves lie over each "
            "other; pull them apart or clean the knot there, or draw elsewhere"
        )
    _put(tables, line.start, 2 * chain, found[0], gaps[0])
    _put(tables, line.end, 2 * chain + 1, found[1], gaps[1])


def _in_one_face(tables: Tables, one: Wedges, two: Wedges) -> tuple[int, int] | None:
    """The two wedges nearest to the wanted ones that are of one face; None if there are none.

    The wanted ones themselves if the nodes are of different parts of the network.
    """
    wanted = one.wanted, two.wanted
    if not one.node.ends or not two.node.ends:
        return wanted
    face: dict[HalfChain, HalfChain] = {}
    for at in (one.node, two.node):
        for end in at.ends:
            if end not in face:
                face.update(dict.fromkeys(walked(tables.nodes, tables.chains, end), end))
    of, other = ([face[end] for end in at.node.ends] for at in (one, two))
    if of[one.wanted] == other[two.wanted]:
        return wanted
    best = min(
        (
            (cost + also, j, k)
            for j, cost in enumerate(one.costs)
            for k, also in enumerate(two.costs)
            if of[j] == other[k]
        ),
        default=(math.inf, 0, 0),
    )
    if math.isinf(best[0]):
        part = joined_chains(tables.nodes, tables.chains, one.node.ends[0] >> 1)
        if two.node.ends[0] >> 1 not in part:
            return wanted
    if best[0] > SLIGHT and _spare_handle(tables, tables.nodes):
        return wanted
    return None if math.isinf(best[0]) else best[1:]


def _spare_handle(tables: Tables, nodes: Mapping[int, Node]) -> bool:
    """Has the ground a handle that the network does not go round yet? The last chain, which is
    not among the ends of these nodes, does not count."""
    ground = tables.before.ground
    handles = 0 if ground is None else handles_of(ground)
    if not handles:
        return False
    ends = {half >> 1 for node in nodes.values() for half in node.ends}
    chains = {c: line for c, line in tables.chains.items() if line.loose or c in ends}
    return genus_of(nodes, chains) < handles


def _wedges(tables: Tables, node: int, half: HalfChain, reach: float, gap: Gap | None) -> Wedges:
    """Where around its node a half-chain goes by its direction, or by the gap that is given."""
    at = tables.nodes[node]
    n = at.valence
    if n == 0:
        return Wedges(at, 0, (0.0,))
    chains = tables.chains
    if gap is None:
        wanted = pointed_into(at, half, reach, chains, tables.gaps, tables.half_now)
    else:
        wanted = beside(at, gap, tables.gaps, tables.half_now)
    new = departure(chains[half >> 1].points, bool(half & 1), reach)
    angles: list[float] = []
    for end in at.ends:
        angle = turn(at.normal, departure(chains[end >> 1].points, bool(end & 1), reach), new)
        angles.append(PASSED + min(angle, 2.0 * math.pi - angle))
    costs = [math.inf] * n
    costs[wanted] = left = right = 0.0
    for step in range(1, n):
        left += angles[(wanted + step) % n]
        right += angles[(wanted - step + 1) % n]
        for wedge, cost in (((wanted + step) % n, left), ((wanted - step) % n, right)):
            costs[wedge] = min(costs[wedge], cost)
    return Wedges(at, wanted, tuple(costs))


def _put(tables: Tables, node: int, half: HalfChain, wedge: int, gap: Gap | None) -> None:
    """A half-chain into a wedge of a node, with a corner on either side of it."""
    at = tables.nodes[node]
    if not at.ends:
        tables.set_node(replace(at, ends=(half,), flagged=(False,)))
        return
    if gap is not None:
        tables.gaps[half] = gap
    tables.set_node(
        replace(
            at,
            ends=(*at.ends[: wedge + 1], half, *at.ends[wedge + 1 :]),
            flagged=(*at.flagged[:wedge], True, True, *at.flagged[wedge + 1 :]),
        )
    )
