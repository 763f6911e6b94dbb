"""The corner tool: corners are set on curves and taken away, or switched to T-junctions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import units
from patterndb_sketch.retopo.arguments import AT, Argument, Vector
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.attaching import find_wedge, list_departures, measure_reach
from patterndb_sketch.retopo.network.builder import NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.patches import FEWEST_CORNERS
from patterndb_sketch.retopo.network.samples import (
    find_nearest_node,
    find_nearest_place,
    take_samples,
)
from patterndb_sketch.retopo.network.structure import HalfChain, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork


def toggle_corner(network: Network, sizes: Sizes, point: ArrayLike, normal: ArrayLike) -> Edit:
    """Switch both wedges of what is pressed: the nearest corner between two chains within the
    snap radius, else the nearest place on a chain.

    point, normal: (3,) on the surface. A place on a chain becomes a corner on both sides; a corner
    on both sides goes, and its chains become one, their counts added. Raises RefusedError if
    nothing is near, and if a patch would be left with fewer than 2 corners.
    """
    corner = find_nearest_node(network, point, normal, sizes.snap, range(2, 3))
    builder = NetworkBuilder(network)
    if corner is None:
        place = find_nearest_place(take_samples(network), point, normal, sizes.snap)
        if place is None:
            raise RefusedError("no curve is near: press closer to one")
        node = builder.cut_chain(place.chain, place.place)
        if node in network.nodes:
            raise RefusedError(
                "several curves meet here, or one ends: a wedge of them is switched by drawing "
                "from within it to the corner"
            )
        for half in builder.nodes[node].ends:
            builder.flag(half, True)
        return Edit.of(network, builder.finish())
    patches = network.patch_of()
    for half, flagged in zip(corner.ends, corner.corner_flags, strict=True):
        if flagged:
            _refuse_below(network, patches, half)
    marks = [network.mark(half) for half in corner.ends]
    marks_behind = [network.mark(half ^ 1) for half in corner.ends]
    if all(corner.corner_flags) and marks != marks_behind[::-1]:
        raise RefusedError("a border ends at this corner: it cannot go")
    for half, flagged in zip(corner.ends, corner.corner_flags, strict=True):
        builder.flag(half, not flagged)
    return Edit.of(network, builder.finish())


def flip_wedge(
    network: Network, sizes: Sizes, pressed: ArrayLike, point: ArrayLike, normal: ArrayLike
) -> Edit:
    """Switch one wedge of a node between corner and straight passage (T-junction).

    pressed: (3,) where the stroke began: beside the node, in the wedge that is meant.
    point, normal: (3,) where it ended: on the node, within the snap radius.
    Raises RefusedError if no node with several chains is there, if the wedge is the node's last
    corner, or if its patch would be left with fewer than 2 corners.
    """
    node = find_nearest_node(network, point, normal, sizes.snap, range(2, 1 << 30))
    if node is None:
        raise RefusedError("the stroke ends at no corner: draw from within the wedge to it")
    towards = np.asarray(pressed, np.float64) - node.point
    flat = towards - (towards @ node.normal) * node.normal
    if not np.linalg.norm(flat) > 0.0:
        raise RefusedError("the stroke begins on the corner itself: begin within the wedge")
    ray = np.stack([node.point, node.point + np.linalg.norm(towards) * units(flat[None])[0]])
    reach = measure_reach(network.chains[half >> 1] for half in node.ends)
    ends = list_departures(network.chains, node.ends)
    wedge = find_wedge(node.normal, ends, (ray, False), reach, range(node.valence))
    flags = list(node.corner_flags)
    if flags[wedge]:
        if sum(flags) == 1:
            raise RefusedError("this is the last corner of the node: one must stay")
        _refuse_below(network, network.patch_of(), node.ends[wedge])
    builder = NetworkBuilder(network)
    builder.flag(node.ends[wedge], not flags[wedge])
    return Edit.of(network, builder.finish())


def _refuse_below(network: Network, patches: dict[HalfChain, int], half: HalfChain) -> None:
    """Refuse to take a corner from the patch on the left of a half-chain if it has just enough."""
    patch = patches.get(half)
    if patch is not None and len(network.patches[patch].corners) <= FEWEST_CORNERS:
        raise RefusedError(f"a patch keeps at least {FEWEST_CORNERS} corners; set another first")


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    foot = work.find_foot(a["at"])
    point, normal = foot.points[0], foot.normals[0]
    if a["wedge"] is None:
        return work.keep_edit(toggle_corner(work.network, work.state.sizes, point, normal))
    pressed = work.find_foot(a["wedge"]).points[0]
    return work.keep_edit(flip_wedge(work.network, work.state.sizes, pressed, point, normal))


CORNER = Tool(
    "corner",
    "Add or delete a corner; with wedge, switch that wedge between corner and T-junction.",
    {"at": AT, "wedge": Argument(Vector(), "a point in the wedge", None)},
    _act,
    position=80,
    snaps=True,
    control=Control(
        "j",
        "corner",
        "click: add or delete a corner    drag from a wedge to its corner: switch it",
        "corner",
        "corner",
        brush="snap",
    ),
)
