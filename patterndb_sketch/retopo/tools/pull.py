"""The pull tool: a corner, an open end or a place on a chain follows the hand, curves with it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import NEAR_CURVE, Argument, Flag, Vector
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.builder import AtChain, AtNode, NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.joining import FEWEST_ROUND, join_nodes
from patterndb_sketch.retopo.network.samples import (
    find_nearest_among,
    find_nearest_node,
    find_nearest_place,
    take_chain_samples,
    take_samples,
)
from patterndb_sketch.retopo.network.structure import Chain, Network, Node
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.course import even_course, note_crossings
from patterndb_sketch.retopo.tracing.curves import take_to_surface

#: More chains than this end at no node.
MOST_ENDS = 1 << 30


def find_held(
    network: Network, sizes: Sizes, point: ArrayLike, normal: ArrayLike
) -> AtNode | AtChain:
    """What a press takes hold of: the nearest corner or open end within the snap radius, else the
    nearest place on a chain.

    point, normal: (3,) on the surface. Raises RefusedError if nothing is near.
    """
    node = find_nearest_node(network, point, normal, sizes.snap, range(1, MOST_ENDS))
    if node is not None:
        return AtNode(node.id)
    place = find_nearest_place(take_samples(network), point, normal, sizes.snap)
    if place is None:
        raise RefusedError("no curve is near: press closer to one")
    return AtChain(place.chain, place.place)


def pull_held(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    at: AtNode | AtChain,
    point: ArrayLike,
    normal: ArrayLike,
) -> Edit:
    """Move what is held to a point; while the hand moves, always from the network as it was when
    it was pressed.

    point, normal: (3,) on the surface, where the hand is now. The chains of a corner or an open
    end follow by shares that fall evenly to 0 at their other ends; a chain that is held at a
    place (its nearest sample) by shares (1 - t)^4 (4 t + 1), where t grows from 0 there to 1 at
    both of its ends, or, closed without a corner, half-way round. Patches stay patches, with
    their ids and choices.

    Raises RefusedError for a border or the seam of symmetry, and if a curve would have no length;
    InvalidRetopoError for what is not there. Source: the program of Takayama et al. 2013. Differs
    from it: t is by arc length; points are projected along normals that turn with the hand's.
    """
    to, up = _take_to_surface(surface, sizes, point, normal)
    builder = NetworkBuilder(network)
    if isinstance(at, AtNode):
        moved = _chains_of(network, at.node)
        move_node_to(builder, surface, sizes, at.node, to, up)
    else:
        moved = {at.chain}
        _move_place_to(builder, surface, sizes, network.chain(at.chain), at.place, (to, up))
    for chain in moved:
        if not builder.chains[chain].length > 0.0:
            raise RefusedError("a curve would have no length: pull less far")
    after = builder.finish()
    return Edit.of(network, after, note_crossings(network, after, moved, sizes))


def release_held(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    at: AtNode | AtChain,
    point: ArrayLike,
    normal: ArrayLike,
    smooth: bool = False,
) -> Edit:
    """Let go what was pulled: as :func:`pull_held`, and a corner or an open end snaps to what is
    within the snap radius of the point.

    It looks for the nearest open end, else the nearest corner at the far end of one of its own
    chains, which collapses, else another corner, else a side, which is cut there. The two corners
    become one, that which stayed. Curves that lie on each other then (within the snap radius)
    become one, too. Where the two cannot be one, it stays where it was dropped, and a note says
    why; see :func:`~patterndb_sketch.retopo.network.joining.join_nodes`.

    smooth: of two open ends, the curves become one; else there is a corner between.
    Raises as :func:`pull_held` does. Source: the program of Takayama et al. 2013.
    """
    if isinstance(at, AtChain):
        return pull_held(network, surface, sizes, at, point, normal)
    to, up = _take_to_surface(surface, sizes, point, normal)
    moved = _chains_of(network, at.node)
    target = _find_joint(network, sizes, at.node, to, up)
    if target is None:
        return pull_held(network, surface, sizes, at, point, normal)
    builder = NetworkBuilder(network)
    node = builder.end_node(target, to, up)
    move_node_to(
        builder, surface, sizes, at.node, builder.nodes[node].point, builder.nodes[node].normal
    )
    try:
        joined = join_nodes(builder, at.node, node, sizes.snap, smooth)
    except RefusedError as error:
        dropped = pull_held(network, surface, sizes, at, point, normal)
        return Edit.of(network, dropped.network, [f"not joined: {error}", *dropped.notes])
    after = joined.finish()
    return Edit.of(network, after, note_crossings(network, after, moved, sizes))


def _find_joint(
    network: Network, sizes: Sizes, node: int, point: Points, normal: Points
) -> AtNode | AtChain | None:
    """What a node that is let go at a point (3,) snaps to, None for nothing: see
    :func:`release_held`."""
    at = network.nodes[node]
    own = {half >> 1 for half in at.ends}
    far = {network.target(half) for half in at.ends} - {node}
    others = [other for other in network.nodes.values() if other.id != node]
    # Not its own curve's other end, unless the curve goes round: else it would vanish.
    barred = far if at.open and not _goes_round(network, at, sizes) else set[int]()
    for chosen in (
        [o for o in others if o.open and o.id not in barred],
        [o for o in others if o.id in far and not o.open],
        [o for o in others if o.id not in far and not o.open],
    ):
        found = find_nearest_among(chosen, point, normal, sizes.snap)
        if found is not None:
            return AtNode(found.id)
    sides = {chain: line for chain, line in network.chains.items() if chain not in own}
    place = find_nearest_place(take_chain_samples(sides), point, normal, sizes.snap)
    return None if place is None else AtChain(place.chain, place.place)


def _goes_round(network: Network, at: Node, sizes: Sizes) -> bool:
    """Does the curve of an open end, pulled to the end at its other side, leave the snap radius?"""
    points, _ = network.chains[at.ends[0] >> 1].directed(at.ends[0])
    share = np.linspace(1.0, 0.0, len(points))[:, None]
    off = np.linalg.norm(points + share * (points[-1] - points[0]) - points[-1], axis=1)
    return len(points) >= FEWEST_ROUND and bool(off.max() > sizes.snap)


def move_node_to(
    builder: NetworkBuilder,
    surface: Surface,
    sizes: Sizes,
    node: int,
    point: Points,
    normal: Points,
) -> None:
    """Move a node to a point (3,) with its normal; its chains follow by even shares.

    Raises RefusedError if one of them is marked.
    """
    at = builder.nodes[node]
    by = point - at.point, normal - at.normal
    chains = {half >> 1: builder.chains[half >> 1] for half in at.ends}
    _refuse_marked(chains.values())
    builder.move_node(node, point, normal)
    for old in chains.values():
        away = np.linspace(0.0, 1.0, len(old.points))
        share = (old.start == node) * (1.0 - away) + (old.end == node) * away
        _reshape(builder, surface, sizes, old, share, by)


def _move_place_to(
    builder: NetworkBuilder,
    surface: Surface,
    sizes: Sizes,
    line: Chain,
    place: float,
    to: tuple[Points, Points],
) -> None:
    """Move the sample of a chain that is nearest to a place to a point (3,) with its normal; the
    others follow."""
    _refuse_marked([line])
    n = len(line.points)
    if n < 3:
        raise RefusedError("the curve is too short to be bent: pull one of its ends")
    along = arc_length(line.round)
    if line.is_closed_loop:
        k = round(place) % n
        off = np.abs(along[:-1] - along[k])
        t = np.minimum(off, along[-1] - off) / (0.5 * along[-1])
    else:
        k = min(max(round(place), 1), n - 2)
        t = np.where(
            along <= along[k],
            (along[k] - along) / along[k],
            (along - along[k]) / (along[-1] - along[k]),
        )
    share = (1.0 - t) ** 4 * (4.0 * t + 1.0)
    by = to[0] - line.points[k], to[1] - line.normals[k]
    _reshape(builder, surface, sizes, line, share, by)


def _reshape(
    builder: NetworkBuilder,
    surface: Surface,
    sizes: Sizes,
    old: Chain,
    share: NDArray[np.float64],
    by: tuple[Points, Points],
) -> None:
    """Move the samples of a chain by shares (n,) of a move (3,), and their normals by shares of a
    turn (3,)."""
    part = share[:, None]
    points, normals = take_to_surface(
        old.points + part * by[0], units(old.normals + part * by[1]), surface, sizes
    )
    still = share == 0.0
    points[still], normals[still] = old.points[still], old.normals[still]
    if not old.is_closed_loop:
        for k, node in ((0, old.start), (-1, old.end)):
            points[k], normals[k] = builder.nodes[node].point, builder.nodes[node].normal
    builder.reshape_chain(old.id, *even_course(points, normals, surface, sizes, old.is_closed_loop))


def _chains_of(network: Network, node: int) -> set[int]:
    return {half >> 1 for half in network.node(node).ends}


def _refuse_marked(lines: Iterable[Chain]) -> None:
    for line in lines:
        if line.marked:
            raise RefusedError("this is on a border or the seam of symmetry: it stays")


def _take_to_surface(
    surface: Surface, sizes: Sizes, point: ArrayLike, normal: ArrayLike
) -> tuple[Points, Points]:
    points, normals = take_to_surface(
        np.asarray(point, np.float64)[None], np.asarray(normal, np.float64)[None], surface, sizes
    )
    return points[0], normals[0]


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    start, end = work.find_foot(a["at"]), work.find_foot(a["to"])
    at = find_held(work.network, sizes, start.points[0], start.normals[0])
    return work.keep_edit(
        release_held(
            work.network, work.surface, sizes, at, end.points[0], end.normals[0], a["smooth"]
        )
    )


PULL = Tool(
    "pull",
    "Pull a corner, an open end or a curve to another place; its curves follow.",
    {
        "at": NEAR_CURVE,
        "to": Argument(Vector(), "a point of the surface"),
        "smooth": Argument(Flag(), "no corner where an open end joins another", False),
    },
    _act,
    position=150,
    snaps=True,
    control=Control("g", "pull", "drag a corner, an end or a curve", target="corner", brush="snap"),
)
