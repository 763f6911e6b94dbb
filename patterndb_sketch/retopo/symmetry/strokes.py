"""Strokes on a half: split at the plane, and joined to the seam there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.ground import Stroke
from patterndb_sketch.retopo.network import SYMMETRY, AtChain, AtNode, Edit, End, Network
from patterndb_sketch.retopo.network.samples import nearest_place, samples_of
from patterndb_sketch.retopo.network.stops import between
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry.cutting import crossing_places, heights_of
from patterndb_sketch.retopo.symmetry.half import Half
from patterndb_sketch.retopo.tools.erase import erase
from patterndb_sketch.retopo.tools.stroke import insert

#: A part of a stroke that begins and ends on the plane is drawn along it, not across the half, if
#: it never is further from it than this part of the snap radius.
ALONG = 0.5

#: A curve from the seam to the seam that is never further from the plane than this many samplings
#: is none.
LEVEL = 0.5

#: A part shorter than this many samplings is what is left of an end on the plane.
SHORTEST = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of a stroke on the half. on: is its start, and its end, on the plane?"""

    stroke: Stroke
    on: tuple[bool, bool]


@dataclass(frozen=True, slots=True, eq=False)
class Parted:
    """What of a stroke is on the half.

    parts: in order; a closed stroke that crosses the plane becomes open ones. beyond: how many
    parts on the other side are left out. along: how many along the plane are.
    """

    parts: tuple[Part, ...]
    beyond: int
    along: int


def parted(stroke: Stroke, half: Half, sizes: Sizes) -> Parted:
    """Split a stroke, cleaned on the whole ground, at the plane.

    What is beyond the plane is dropped. Where it was cut it is exactly on the plane, as near as
    floating point gets, and points nearer to it than ``half.near`` are moved there.
    """
    line, up = stroke.points.copy(), stroke.normals
    height = heights_of(half, line)
    line[height == 0.0] = half.plane.flattened(line[height == 0.0])
    places = crossing_places(height, stroke.closed)
    n = len(line)
    if stroke.closed and places:
        bounds = [*places, places[0] + n]
    elif stroke.closed:
        whole = Part(replace(stroke, points=line), (False, False))
        return Parted((whole,) if (height > 0.0).any() else (), int((height < 0.0).any()), 0)
    else:
        bounds = sorted({0.0, *places, float(n - 1)})
    parts: list[Part] = []
    beyond, along = 0, 0
    for begin, finish in pairwise(bounds):
        inner = np.arange(int(np.floor(begin)) + 1, int(np.ceil(finish)))
        points, normals = between(line, up, np.concatenate([[begin], inner, [finish]]))
        for k, place in ((0, begin), (-1, finish)):
            if stroke.closed or place in places:
                points[k] = half.plane.flattened(points[k][None])[0]
        there = heights_of(half, points)
        on = bool(there[0] == 0.0), bool(there[-1] == 0.0)
        if there.min() < 0.0:
            beyond += 1
        elif _along(points, there.max(), on, sizes):
            along += 1
        else:
            parts.append(Part(Stroke(points, normals, False, stroke.missed), on))
    return Parted(tuple(parts), beyond, along)


def _along(points: Points, highest: float, on: tuple[bool, bool], sizes: Sizes) -> bool:
    """Is a part along the plane, or what is left of an end that touched it?"""
    if all(on) and highest <= ALONG * sizes.snap:
        return True
    return any(on) and float(arc_length(points)[-1]) < SHORTEST * sizes.sampling


def insert_on_half(
    network: Network,
    half: Half,
    sizes: Sizes,
    stroke: Stroke,
    smooth: tuple[bool, bool] = (False, False),
) -> Edit:
    """Add a stroke, cleaned on the whole ground, to a network on half of it.

    It is split at the plane, and what is beyond is dropped and told; parts end on the seam, at a
    node there within the snap radius, else where they cross. See
    :func:`~patterndb_sketch.retopo.tools.stroke.insert` for the rest. Raises RefusedError if nothing of
    it is on the half.
    """
    split = parted(stroke, half, sizes)
    if not split.parts:
        raise RefusedError(
            "the stroke lies on the other side of the plane of symmetry, or along it; draw it "
            "on the side that is worked on"
        )
    notes: list[str] = []
    if split.beyond:
        notes.append(f"{split.beyond} parts of the stroke beyond the plane are left out")
    after = network
    for part in split.parts:
        ends: list[End | None] = [
            _on_seam(after, part, k, sizes) if part.on[k] else None for k in (0, 1)
        ]
        edit = insert(after, half.ground, sizes, part.stroke, ends[0], ends[1], smooth)
        after = _without_level(edit.network, edit.chains, half, sizes)
        notes += [note for note in edit.notes if note not in notes]
    return Edit.of(network, after, notes)


def _without_level(network: Network, chains: tuple[int, ...], half: Half, sizes: Sizes) -> Network:
    """Without new chains along the seam: where a stroke's end is taken to a node, what is next to
    the plane may be taken onto it."""
    level: list[int] = []
    for chain in chains:
        line = network.chains[chain]
        height = heights_of(half, line.points)
        on = not line.loose and height[0] == 0.0 == height[-1]
        if on and not line.marked and height.max() <= LEVEL * sizes.sampling:
            level.append(chain)
    return erase(network, level).network if level else network


def refuse_beyond(stroke: Stroke, half: Half, what: str) -> None:
    """Raise RefusedError if a stroke is partly beyond the plane; ``what`` is drawn, in words."""
    if (heights_of(half, stroke.points) < 0.0).any():
        raise RefusedError(
            f"{what} crosses the plane of symmetry, or is beyond it; draw it on the side that is "
            "worked on"
        )


def _on_seam(network: Network, part: Part, k: int, sizes: Sizes) -> End | None:
    """Where a part's start (0) or end (1) joins the seam."""
    point, normal = part.stroke.points[-k], part.stroke.normals[-k]
    seam = {c: chain for c, chain in network.chains.items() if SYMMETRY in chain.marks}
    nodes = sorted({node for chain in seam.values() for node in (chain.start, chain.end)} - {-1})
    near = [
        (float(np.linalg.norm(network.nodes[node].point - point)), node)
        for node in nodes
        if float(network.nodes[node].normal @ normal) > 0.0
    ]
    if near and min(near)[0] <= sizes.snap:
        return AtNode(min(near)[1])
    place = nearest_place(samples_of(seam), point, normal, sizes.snap)
    return None if place is None else AtChain(place.chain, place.place)
