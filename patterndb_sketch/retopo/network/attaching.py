"""A new chain's two ends among those of its nodes: both in one face, so that it crosses nothing.

Directions, gaps and crossings each say where around a node a curve goes, and where curves nearly
lie on each other they do not agree. What decides is the network itself: a chain between two
nodes of one part of it crosses no other if both its ends go into one face. So the network stays
a drawing on its surface (Euler's formula), whatever is measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.network.attaching import find_departure, measure_turn
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.faces import (
    count_genus,
    count_handles,
    find_joined_chains,
    list_face,
)
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Network, Node

#: Curves that leave within this angle of each other, in radians, are compared further out.
TOO_CLOSE = 0.1

#: What a curve is looked at aside by, as a part of its segments, so that it lies on none that is
#: there: far above rounding, far below what one sees.
ASIDE = 1e-6

#: The direction of that: any that no axis, diagonal or regular grid has.
TOWARDS = np.array([0.5377, 0.7243, 0.4318])

#: How often, each time twice as far out.
FURTHER = 5

#: Directions in which curves leave a node are taken over this many samples.
SAMPLES_AHEAD = 2.0

#: The polyline (n, 3) of a curve that leaves a node, and whether it leaves from its last point.
Departure = tuple[Points, bool]


def measure_reach(lines: Iterable[Chain]) -> float:
    """The arc length over which the directions of chains that meet are taken."""
    return SAMPLES_AHEAD * max(line.length / line.segments for line in lines)


def list_departures(chains: Mapping[int, Chain], ends: Iterable[HalfChain]) -> list[Departure]:
    """How the half-chains that leave a node run."""
    return [(chains[end >> 1].points, bool(end & 1)) for end in ends]


def find_wedge(
    normal: NDArray[np.float64],
    ends: Sequence[Departure],
    new: Departure,
    reach: float,
    wedges: Sequence[int],
) -> int:
    """Which of some wedges of a node a new curve goes into.

    A curve that runs along one that is there is as far aside of it as when crossings were looked
    for.

    ends: those that leave the node, in its order; new: the new curve. Directions are taken over an
    arc length ``reach``, and further out while the nearest two are too close. wedges: numbers,
    wedge i is between end i and the next.
    """
    best = wedges[0]
    if len(wedges) == 1:
        return best
    bounds = sorted({*wedges, *((w + 1) % len(ends) for w in wedges)})
    for _ in range(FURTHER):
        ahead = find_departure(*new, reach)
        ahead += ASIDE * np.linalg.norm(ahead) * TOWARDS
        turns = {i: measure_turn(normal, find_departure(*ends[i], reach), ahead) for i in bounds}
        # The narrowest that holds the new curve: of two ends that lie on each other the angles
        # may be in another order than the ends are, and what is between them seems to be wide.
        widths = {w: (turns[w] - turns[(w + 1) % len(ends)]) % (2.0 * math.pi) for w in wedges}
        best = min(wedges, key=lambda w: (turns[w] >= widths[w], widths[w], turns[w]))
        if min(min(t, 2.0 * math.pi - t) for t in turns.values()) >= TOO_CLOSE:
            break
        reach *= 2.0
    return best


@dataclass(frozen=True, slots=True)
class Gap:
    """Where around a node a new curve goes, if that is known without looking at angles.

    half: an end of the node; left: the new curve is next to it on its left, else on its right.
    off:  how far along ``half`` the curve crosses it, if it was taken to the node from there:
          of several curves in one gap, those that cross further off are nearer to ``half``.
    """

    half: HalfChain
    left: bool
    off: float = 0.0


def _wedge_beside(
    at: Node,
    gap: Gap,
    given: Mapping[HalfChain, Gap],
    now: Callable[[HalfChain], HalfChain],
) -> int:
    """The wedge that a gap is: beyond the ends that are in it and nearer to its half-chain.

    given: the gaps of ends that were put there by one. now: the half-chain that one of before
    a cut is.
    """
    n = at.valence
    half = now(gap.half)
    step = 1 if gap.left else -1
    j = at.ends.index(half)
    for _ in range(n):
        other = given.get(at.ends[(j + step) % n])
        if other is None or other.left != gap.left or other.off <= gap.off:
            break
        if now(other.half) != half:
            break
        j = (j + step) % n
    return j if gap.left else (j - 1) % n


def _wedge_pointed_into(
    at: Node,
    half: HalfChain,
    reach: float,
    chains: Mapping[int, Chain],
    given: Mapping[HalfChain, Gap],
    now: Callable[[HalfChain], HalfChain],
) -> int:
    """The wedge that a half-chain points into, over an arc length ``reach``.

    Ends whose gaps were given say nothing by their directions: they were led to the node from
    a little off it, and lie beside the half-chains that they cross.
    """
    old = [h for h in at.ends if h not in given]
    # The left of an end: never beyond the border of the surface.
    free = [j for j, h in enumerate(old) if not chains[h >> 1].marks[h & 1]]
    ends, (new,) = list_departures(chains, old), list_departures(chains, [half])
    j = find_wedge(at.normal, ends, new, reach, free or range(len(old)))
    return _wedge_beside(at, Gap(old[j], True, -1.0), given, now)


#: What each end that is passed costs beside the angle to it, in radians: of two ways of the same
#: angle that past fewer ends is taken.
PASSED = 1e-3

#: On a surface with a handle a chain may lead from a face to another of the same part. It does not
#: where ends nearer than this, in radians, are all that is between: they lie on each other.
SLIGHT = 0.35

Gaps = tuple[Gap | None, Gap | None]


class SeparatedError(RefusedError):
    """Between two nodes there is no way that crosses nothing."""


class Attachable(Protocol):
    """What is needed of a network that is built, a
    :class:`~patterndb_sketch.retopo.network.builder.NetworkBuilder`."""

    before: Network
    nodes: dict[int, Node]
    chains: dict[int, Chain]
    gaps: dict[HalfChain, Gap]
    touched_chains: set[int]

    def set_node(self, node: Node) -> None:
        """Put a changed node in the place of the one with its id."""

    def half_now(self, half: HalfChain) -> HalfChain:
        """The half-chain that one of before a cut is."""
        ...


@dataclass(frozen=True, slots=True)
class _Wedges:
    """Where an end of a new chain may go around its node.

    node:   with its ends so far. wanted: the wedge that measures tell.
    costs:  of every wedge, what it takes to come there from the wanted one: the angles, in
            radians, between the new chain and the ends that are passed.
    """

    node: Node
    wanted: int
    costs: tuple[float, ...]


def attach_chain(builder: Attachable, chain: int, reach: float, gaps: Gaps = (None, None)) -> None:
    """Put a chain's halves among the ends of its nodes, with corners on either side.

    reach: arc length over which directions are taken; gaps: where its start and its end go, if
    that is known. Of the wedges of one face those nearest to that are taken.
    Raises SeparatedError if there are none; the chain is taken from the open network then.
    """
    line = builder.chains[chain]
    one = _price_wedges(builder, line.start, 2 * chain, reach, gaps[0])
    if line.start == line.end:
        inside: set[HalfChain] = {2 * chain}
        if one.node.ends:
            inside.update(list_face(builder.nodes, builder.chains, one.node.ends[one.wanted]))
        before = {**builder.nodes}
        _put_end(builder, one.node.id, 2 * chain, one.wanted, gaps[0])
        two = _price_wedges(builder, line.end, 2 * chain + 1, reach, gaps[1])
        wedge = two.wanted
        if two.node.ends[wedge] not in inside and not _has_spare_handle(builder, before):
            around = (k for k, half in enumerate(two.node.ends) if half in inside)
            wedge = min(around, key=two.costs.__getitem__)
        _put_end(builder, line.end, 2 * chain + 1, wedge, gaps[1])
        return
    two = _price_wedges(builder, line.end, 2 * chain + 1, reach, gaps[1])
    found = _find_common_face(builder, one, two)
    if found is None:
        del builder.chains[chain]
        builder.touched_chains.discard(chain)
        raise SeparatedError(
            "the curve would pass through others without a crossing, where curves lie over each "
            "other; pull them apart or clean the knot there, or draw elsewhere"
        )
    _put_end(builder, line.start, 2 * chain, found[0], gaps[0])
    _put_end(builder, line.end, 2 * chain + 1, found[1], gaps[1])


def _find_common_face(builder: Attachable, one: _Wedges, two: _Wedges) -> tuple[int, int] | None:
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
                face.update(dict.fromkeys(list_face(builder.nodes, builder.chains, end), end))
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
        part = find_joined_chains(builder.nodes, builder.chains, one.node.ends[0] >> 1)
        if two.node.ends[0] >> 1 not in part:
            return wanted
    if best[0] > SLIGHT and _has_spare_handle(builder, builder.nodes):
        return wanted
    return None if math.isinf(best[0]) else best[1:]


def _has_spare_handle(builder: Attachable, nodes: Mapping[int, Node]) -> bool:
    """Has the surface a handle that the network does not go round yet? The last chain, which is
    not among the ends of these nodes, does not count."""
    surface = builder.before.surface
    handles = 0 if surface is None else count_handles(surface)
    if not handles:
        return False
    ends = {half >> 1 for node in nodes.values() for half in node.ends}
    chains = {c: line for c, line in builder.chains.items() if line.is_closed_loop or c in ends}
    return count_genus(nodes, chains) < handles


def _price_wedges(
    builder: Attachable, node: int, half: HalfChain, reach: float, gap: Gap | None
) -> _Wedges:
    """Where around its node a half-chain goes by its direction, or by the gap that is given."""
    at = builder.nodes[node]
    n = at.valence
    if n == 0:
        return _Wedges(at, 0, (0.0,))
    chains = builder.chains
    if gap is None:
        wanted = _wedge_pointed_into(at, half, reach, chains, builder.gaps, builder.half_now)
    else:
        wanted = _wedge_beside(at, gap, builder.gaps, builder.half_now)
    new, *ways = (find_departure(*one, reach) for one in list_departures(chains, (half, *at.ends)))
    angles: list[float] = []
    for way in ways:
        angle = measure_turn(at.normal, way, new)
        angles.append(PASSED + min(angle, 2.0 * math.pi - angle))
    costs = [math.inf] * n
    costs[wanted] = left = right = 0.0
    for step in range(1, n):
        left += angles[(wanted + step) % n]
        right += angles[(wanted - step + 1) % n]
        for wedge, cost in (((wanted + step) % n, left), ((wanted - step) % n, right)):
            costs[wedge] = min(costs[wedge], cost)
    beyond = [bool(chains[end >> 1].marks[end & 1]) for end in at.ends]
    if chains[half >> 1].marked or all(beyond):
        return _Wedges(at, wanted, tuple(costs))
    # Nothing is drawn beyond a marked side. A gap was told by a crossing, and where curves lie on
    # a border or the seam that may be on either side of it.
    costs = [math.inf if out else cost for out, cost in zip(beyond, costs, strict=True)]
    return _Wedges(at, min(range(n), key=costs.__getitem__), tuple(costs))


def _put_end(builder: Attachable, node: int, half: HalfChain, wedge: int, gap: Gap | None) -> None:
    """A half-chain into a wedge of a node, with a corner on either side of it."""
    at = builder.nodes[node]
    if not at.ends:
        builder.set_node(replace(at, ends=(half,), corner_flags=(False,)))
        return
    if gap is not None:
        builder.gaps[half] = gap
    builder.set_node(
        replace(
            at,
            ends=(*at.ends[: wedge + 1], half, *at.ends[wedge + 1 :]),
            corner_flags=(*at.corner_flags[:wedge], True, True, *at.corner_flags[wedge + 1 :]),
        )
    )
