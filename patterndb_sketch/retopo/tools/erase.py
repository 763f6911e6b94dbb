"""The eraser: chains that a scribble crosses, some by name, or all that hang loose."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from patterndb._native.retopo.network.attaching import find_departure, measure_turn
from patterndb_sketch.retopo.arguments import Argument, Flag, PointList, Vector
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network.attaching import list_departures, measure_reach
from patterndb_sketch.retopo.network.builder import NetworkBuilder
from patterndb_sketch.retopo.network.crossings import find_crossings
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.samples import take_samples
from patterndb_sketch.retopo.network.structure import Network, Node
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tracing import SurfaceCurve

#: Two chains run straight through a node if they bend by less than this, in radians there.
STRAIGHT = math.radians(30.0)


def erase_crossed_chains(network: Network, scribble: SurfaceCurve) -> Edit:
    """Erase every chain that a scribble crosses, but marked ones; see :func:`erase_chains`.

    Raises RefusedError if it crosses none that can be erased.
    """
    found = find_crossings(
        scribble.points, scribble.normals, scribble.closed, take_samples(network)
    )
    chains = {int(chain) for chain in found.chain}
    if not chains:
        raise RefusedError("the scribble crosses no curve: draw it across what is to go")
    return erase_chains(network, chains)


def erase_chains(network: Network, chains: Iterable[int]) -> Edit:
    """Erase chains by their ids; marked ones, the borders and the seam of symmetry, stay.

    What an erased curve had cut is one chain again: where it had ended on another, which passes
    the T-junction however it bends; where it had crossed one, both sides of it gone; and where
    it had met several, if the two that are left run straight (STRAIGHT). Corners that were
    drawn as such stay. Chains that no patch uses any more, but one did, lose their counts, unless
    the user chose them.

    Raises RefusedError if nothing can be erased, InvalidRetopoError for ids that are not there.
    Source: the program of Takayama et al. 2013. Differs from it: it leaves a corner wherever
    a curve ended; it forgets counts that the user chose, too.
    """
    lines = [network.chain(chain) for chain in sorted(set(chains))]
    gone = [line for line in lines if not line.marked]
    if not gone:
        raise RefusedError("nothing to erase here: borders and the seam of symmetry stay")
    kept = len(lines) - len(gone)
    notes = [f"{kept} chains of borders or the seam stay"] if kept else []
    builder = NetworkBuilder(network)
    left: list[int] = []
    for line in gone:
        left += builder.remove_chain(line.id)
    # All are looked at before any goes: then ends have other names.
    joints = [
        node
        for node in dict.fromkeys(left)
        if node in builder.nodes
        and (
            _is_one_curve(builder, network.nodes[node])
            or (builder.nodes[node].cut and is_straight(builder, node))
        )
    ]
    for node in joints:
        builder.merge(node)
    return Edit.of(network, builder.finish(forget=True), notes)


def _is_one_curve(builder: NetworkBuilder, before: Node) -> bool:
    """Are the two ends that are left at a node one curve that passed it?

    That is so if its other side passed it straight, and if it crossed the one that is gone.
    """
    left = set(builder.nodes[before.id].ends)
    n = before.valence
    if len(left) != 2:
        return False
    one, two = sorted(before.ends.index(half) for half in left)
    if before.cut and n == 4 and two - one == 2:
        return True
    return (two - one == 1 and not before.corner_flags[one]) or (
        two - one == n - 1 and not before.corner_flags[two]
    )


def erase_open_chains(network: Network) -> Edit:
    """Erase all chains with an open end, and those that get one by that, until none is open.

    Raises RefusedError if none is.
    """
    gone: set[int] = set()
    ends = {node.id: set(node.ends) for node in network.nodes.values()}
    loose = [node for node, halves in ends.items() if len(halves) == 1]
    while loose:
        node = loose.pop()
        if len(ends[node]) != 1:
            continue
        (half,) = ends[node]
        if network.chains[half >> 1].marked:
            continue
        gone.add(half >> 1)
        ends[node].discard(half)
        other = network.target(half)
        ends[other].discard(half ^ 1)
        if len(ends[other]) == 1:
            loose.append(other)
    if not gone:
        raise RefusedError("no curve has an open end that could be erased")
    return erase_chains(network, gone)


def is_straight(builder: NetworkBuilder, node: int) -> bool:
    """Do just two chains end at a node, and does one continue the other?"""
    at: Node = builder.nodes[node]
    if at.valence != 2:
        return False
    reach = measure_reach(builder.chains[half >> 1] for half in at.ends)
    one, two = (find_departure(*end, reach) for end in list_departures(builder.chains, at.ends))
    return abs(measure_turn(at.normal, one, two) - math.pi) < STRAIGHT


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    ways = [
        name for name in ("points", "at", "open") if a[name] is not None and a[name] is not False
    ]
    if len(ways) != 1:
        raise InvalidRetopoError("erase needs one of points, at and open")
    if ways == ["open"]:
        return work.keep_edit(erase_open_chains(work.network))
    if ways == ["at"]:
        return work.keep_edit(erase_chains(work.network, [work.find_chain(a["at"])]))
    return work.keep_edit(erase_crossed_chains(work.network, work.clean_stroke(a["points"], False)))


ERASE = Tool(
    "erase",
    "Erase the curves that a scribble crosses, the one at a point, or all with open ends.",
    {
        "points": Argument(PointList(), "the scribble", None),
        "at": Argument(Vector(), "a point near the curve", None),
        "open": Argument(Flag(), "all with open ends", False, option=False),
    },
    _act,
    position=60,
    snaps=True,
    control=Control("e", "erase", "scribble over curves, or click one", "scribble", "chain"),
)
