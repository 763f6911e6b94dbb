"""The stroke tool: a drawn curve joins the network; ends snap, and crossings become corners.

While symmetry is on a stroke is split at the plane, and its parts end on the seam
(:func:`insert_stroke_on_half`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import POINTS, Argument, Flag
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import SYMMETRY
from patterndb_sketch.retopo.network.builder import AtChain, AtNode, End, Free, NetworkBuilder
from patterndb_sketch.retopo.network.edits import Edit
from patterndb_sketch.retopo.network.insertion import Nearness, Project, insert_curve
from patterndb_sketch.retopo.network.joining import remove_doubles
from patterndb_sketch.retopo.network.patches import find_long_loops
from patterndb_sketch.retopo.network.samples import (
    Samples,
    find_nearest_node,
    find_nearest_place,
    take_chain_samples,
    take_samples,
)
from patterndb_sketch.retopo.network.structure import Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry.half import Half, measure_heights, split_stroke
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.erase import erase_chains
from patterndb_sketch.retopo.tracing import SurfaceCurve
from patterndb_sketch.retopo.tracing.curves import take_to_surface

#: A crossing this near to a node, in samplings along the chain, is at the node.
NODE_NEAR = 0.5

#: More chains than this end at no node.
MOST_ENDS = 1 << 30

#: A stroke that runs between the ends of a curve lies on it, and is the same, within this part of
#: the snap radius: less, so that thin patches of two sides can be drawn between ends that snap.
DOUBLED = 0.5


def insert_stroke(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    stroke: SurfaceCurve,
    start: End | None = None,
    end: End | None = None,
    smooth: tuple[bool, bool] = (False, False),
) -> Edit:
    """Add a stroke, cleaned before.

    start, end: what its ends are joined to where that is known; None to look for the nearest
    open end, else corner, else side within the snap radius; ``Free()`` for neither. A joined
    end takes the stroke along: all of it moves by a share that falls to 0 at the other end,
    and is projected again.
    smooth: at an end that meets an open end, the two curves become one; else their joint is a
    corner.

    Where it crosses chains or itself, both are cut, and all four wedges become corners. A
    closed stroke crosses only. What runs beyond a marked side is left out.

    Raises RefusedError if nothing is left of it, InvalidRetopoError for ends that are not there.
    Source: Takayama et al. 2013, section 5.1, and their program. Differs from them: all
    crossings count, those of the stroke with itself too, and only on the same side of a sheet;
    crossings next to a node are at the node.
    """
    if stroke.closed and not (start is None and end is None):
        raise InvalidRetopoError("a closed stroke has no ends to join; leave start and end out")
    builder = NetworkBuilder(network, surface)
    same = min(NODE_NEAR * sizes.sampling, 0.25 * sizes.snap)
    near = Nearness(same, (sizes.snap, sizes.snap), sizes.snap)

    def project(points: Points, normals: Points) -> tuple[Points, Points]:
        return take_to_surface(points, normals, surface, sizes)

    joints: list[int] = []
    ends: list[End] = [Free(), Free()]
    if not stroke.closed:
        of = take_samples(network)
        for k, known in enumerate((start, end)):
            point, normal = stroke.points[-k], stroke.normals[-k]
            joint = find_end(network, of, point, normal, sizes.snap) if known is None else known
            if isinstance(joint, AtNode):
                wanted = smooth[k] or joint.smooth
                if wanted and network.node(joint.node).open:
                    joints.append(joint.node)
            if not isinstance(joint, Free):
                ends[k] = AtNode(builder.end_node(joint, point, normal))
        stroke = drag_to_ends(stroke, builder, ends, project)
    made = insert_curve(builder, stroke, ends[0], ends[1], near, project)
    drawn, made = made, remove_doubles(builder, made, DOUBLED * sizes.snap)
    if not made:
        raise RefusedError(
            "nothing of the stroke is left: it lies on a curve that is there, within half the "
            "snap radius; draw it further off, or with a smaller snap radius"
            if drawn
            else "nothing of the stroke is left: it begins and ends at one corner, or lies beyond "
            "the border of the surface; draw it longer"
        )
    for node in map(builder.node_now, joints):
        if node in builder.nodes:
            builder.merge(node)
    notes: list[str] = []
    if stroke.missed:
        notes.append(f"{stroke.missed} points of the stroke had no surface along their normals")
    after = builder.finish()
    new = sorted(after.chains.keys() - network.chains.keys())
    notes += [
        f"the loop that it closes is {length:.4g} long, and none above {network.longest:.4g} "
        "becomes a patch by itself: the tool patch makes it one"
        for length in find_long_loops(after, new)
    ]
    return Edit.of(network, after, notes)


def find_end(
    network: Network, of: Samples, point: ArrayLike, normal: ArrayLike, snap: float
) -> End:
    """What an end of a stroke snaps to: the nearest open end within the snap radius, else the
    nearest corner, else the nearest side, else nothing. Normals must agree.

    of: the network's samples. Differs from the program of Takayama et al. 2013: a side is met at
    its nearest point, not at its nearest vertex.
    """
    for valences in (range(1, 2), range(2, MOST_ENDS)):
        node = find_nearest_node(network, point, normal, snap, valences)
        if node is not None:
            return AtNode(node.id)
    place = find_nearest_place(of, point, normal, snap)
    return Free() if place is None else AtChain(place.chain, place.place)


def drag_to_ends(
    stroke: SurfaceCurve, builder: NetworkBuilder, ends: Sequence[End], project: Project
) -> SurfaceCurve:
    """A stroke taken along to the nodes that its ends are joined to.

    Points move by what their end moves, times a share that falls from 1 there to 0 at the other
    end by arc length, and are projected again.
    """
    line, up = stroke.points, stroke.normals
    along = arc_length(line)
    share = (along / along[-1])[:, None]
    moved = np.zeros_like(line)
    targets: list[tuple[int, Points, Points]] = []
    for k, joint in enumerate(ends):
        if isinstance(joint, AtNode):
            node = builder.nodes[joint.node]
            moved += (share if k else 1.0 - share) * (node.point - line[-k])
            targets.append((-k, node.point, node.normal))
    if not moved.any():
        return stroke
    line, up = project(line + moved, up)
    for k, point, normal in targets:
        line[k], up[k] = point, normal
    return replace(stroke, points=line, normals=up)


#: A curve from the seam to the seam that is never further from the plane than this many samplings
#: is none.
LEVEL = 0.5


def insert_stroke_on_half(
    network: Network,
    half: Half,
    sizes: Sizes,
    stroke: SurfaceCurve,
    smooth: tuple[bool, bool] = (False, False),
) -> Edit:
    """Add a stroke, cleaned on the whole surface, to a network on half of it.

    It is split at the plane, and what is beyond is dropped and told; parts end on the seam, at a
    node there within the snap radius, else where they cross. See
    :func:`~patterndb_sketch.retopo.tools.stroke.insert_stroke` for the rest. Raises RefusedError
    if nothing of it is on the half.
    """
    parts, beyond = split_stroke(stroke, half, sizes)
    if not parts:
        raise RefusedError(
            "the stroke lies on the other side of the plane of symmetry, or along it; draw it "
            "on the side that is worked on"
        )
    notes: list[str] = []
    if beyond:
        notes.append(f"{beyond} parts of the stroke beyond the plane are left out")
    after = network
    for part in parts:
        on = (measure_heights(half, part.points[[0, -1]]) == 0.0) & (not part.closed)
        ends = [_find_on_seam(after, part, k, sizes) if on[k] else None for k in (0, 1)]
        edit = insert_stroke(after, half.surface, sizes, part, ends[0], ends[1], smooth)
        after = _erase_level(edit.network, edit.chains, half, sizes)
        notes += [note for note in edit.notes if note not in notes]
    return Edit.of(network, after, notes)


def _erase_level(network: Network, chains: tuple[int, ...], half: Half, sizes: Sizes) -> Network:
    """Without new chains along the seam: where a stroke's end is taken to a node, what is next to
    the plane may be taken onto it."""
    level: list[int] = []
    for chain in chains:
        line = network.chains[chain]
        height = measure_heights(half, line.points)
        on = not line.is_closed_loop and height[0] == 0.0 == height[-1]
        if on and not line.marked and height.max() <= LEVEL * sizes.sampling:
            level.append(chain)
    return erase_chains(network, level).network if level else network


def _find_on_seam(network: Network, part: SurfaceCurve, k: int, sizes: Sizes) -> End | None:
    """Where a part's start (0) or end (1) joins the seam."""
    point, normal = part.points[-k], part.normals[-k]
    seam = {c: chain for c, chain in network.chains.items() if SYMMETRY in chain.marks}
    nodes = sorted({node for chain in seam.values() for node in (chain.start, chain.end)} - {-1})
    near = [
        (float(np.linalg.norm(network.nodes[node].point - point)), node)
        for node in nodes
        if float(network.nodes[node].normal @ normal) > 0.0
    ]
    if near and min(near)[0] <= sizes.snap:
        return AtNode(min(near)[1])
    place = find_nearest_place(take_chain_samples(seam), point, normal, sizes.snap)
    return None if place is None else AtChain(place.chain, place.place)


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    drawn = work.clean_stroke(a["points"], a["closed"])
    smooth = (a["smooth"], a["smooth"])
    if work.half is not None:
        return work.keep_edit(
            insert_stroke_on_half(work.network, work.half, work.state.sizes, drawn, smooth)
        )
    return work.keep_edit(
        insert_stroke(work.network, work.surface, work.state.sizes, drawn, smooth=smooth)
    )


STROKE = Tool(
    "stroke",
    "Draw a curve; its ends snap, and where it crosses others both are cut.",
    {
        "points": POINTS,
        "closed": Argument(Flag(), "is it closed? By itself if its ends are near", None),
        "smooth": Argument(Flag(), "no corner where it goes on from an open end", False),
    },
    _act,
    position=10,
    snaps=True,
    control=Control("d", "draw", "draw a curve on the surface; its ends snap", brush="snap"),
)
