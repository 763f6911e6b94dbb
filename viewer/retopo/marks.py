"""Marks of a network as it is seen: curves that face the viewer, corners, ends, and numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network import Chain, Network, Node, trace_outline
from viewer import style
from viewer.camera import View
from viewer.solid import NOTHING, Triangles, dash_line, make_discs, make_ribbons
from viewer.style import parse_colour

#: Quads by the number of their patch's sides; the last are all others.
SIDES = {2: "#f3bfd0", 3: "#a9cdee", 4: "#f7efdc", 5: "#f0c9a0", 6: "#b9dcb4"}
MORE_SIDES = "#d5c2e8"

#: Quads that are flipped, and patches that have no quads.
WRONG = "#e0362c"

#: Edges of quads, curves, curves that are the surface's border or lie on the plane of symmetry.
EDGE = "#79828f"
CURVE = "#27364a"
MARKED = "#7c5cbf"

#: Curves that are images of others.
IMAGE = "#8b96a8"

#: Nodes: corners, and the rim of what is hollow.
CORNER = "#14202e"

#: What is drawn just now, what it snaps to, what would be made, and its quads.
INK = "#d8237a"
SNAP = "#10a37f"
PREVIEW = "#10a37f"
REMADE = "#eaf7f2"
FLOW = "#8a3ffc"
BRUSH = "#5f6b7a"

#: Faces that were given, and are no patches.
GIVEN = "#b4bcc8"


def choose_side_colour(sides: int) -> str:
    """Choose the colour of a patch with so many sides, or, for 0, of a face that was given."""
    return GIVEN if sides == 0 else SIDES.get(sides, MORE_SIDES)


#: Samples of a curve that are seen this near to each other, in points, are left out.
FINE = 2.5

#: What faces away from the viewer by more than this cosine is hidden by the surface.
AWAY = -0.12

#: Radii in points: of corners, of open ends, and of T-junctions.
CORNER_RADIUS, END_RADIUS, T_RADIUS = 4.2, 4.4, 5.0

#: The line in a patch without quads: how far within its loop, as a part of it, its width and its
#: dashes, in points.
DRAWN_IN, EMPTY_WIDTH, DASH = 0.9, 2.4, 7.0

#: Points of a half disc's rim.
HALF = 13


def project_chains(chains: Iterable[Chain], view: View, *, through: bool) -> list[Points]:
    """Project chains: polylines (k, 3) as they are seen, where they face the viewer; all of them
    where one sees through."""
    found: list[Points] = []
    for chain in chains:
        line = chain.round
        facing = chain.normals @ view.axes[2] > AWAY
        if chain.is_closed_loop:
            facing = np.concatenate([facing, facing[:1]])
        found += cut_runs(view.seen(line), np.ones(len(line), np.bool_) if through else facing)
    return found


def cut_runs(seen: Points, shown: NDArray[np.bool_]) -> list[Points]:
    """Cut a polyline (k, 3) as it is seen into its shown parts, no finer than is of use."""
    if not shown.any():
        return []
    cuts = np.flatnonzero(np.diff(shown.astype(np.int8))) + 1
    parts: list[Points] = []
    for part in np.split(np.arange(len(seen)), cuts):
        if shown[part[0]] and len(part) > 1:
            parts.append(thin_line(seen[part]))
    return parts


def thin_line(line: Points) -> Points:
    """Thin a polyline (k, 3) as it is seen: without the samples that nobody tells apart."""
    length = float(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1).sum())
    most = max(2, int(length / FINE) + 2)
    if len(line) <= most:
        return line
    return line[np.linspace(0, len(line) - 1, most).round().astype(np.int64)]


def make_node_marks(network: Network, view: View, lift: float, *, through: bool) -> list[Triangles]:
    """Make marks of nodes: corners full, T-junctions half, open ends hollow."""
    corners: list[Points] = []
    ends: list[Points] = []
    halves: list[tuple[Points, Points]] = []
    for node in network.nodes.values():
        if not through and node.normal @ view.axes[2] <= AWAY:
            continue
        at = view.seen(node.point)
        if node.open:
            ends.append(at)
        elif all(node.corner_flags):
            corners.append(at)
        else:
            halves.append((at, find_stem(network, node, view)))
    full, hollow = (np.array(places).reshape(-1, 3) for places in (corners, ends))
    half = np.array([at for at, _ in halves]).reshape(-1, 3)
    ways = np.array([way for _, way in halves]).reshape(-1, 2)
    return [
        make_discs(full, style.PAPER, CORNER_RADIUS + 1.0, lift),
        make_discs(full, CORNER, CORNER_RADIUS, lift + 0.5),
        make_discs(hollow, CORNER, END_RADIUS, lift),
        make_discs(hollow, style.PAPER, 0.58 * END_RADIUS, lift + 0.5),
        make_discs(half, CORNER, T_RADIUS, lift),
        make_discs(half, style.PAPER, T_RADIUS - 1.1, lift + 0.5),
        make_half_discs(half, ways, CORNER, T_RADIUS - 0.9, lift + 1.0),
    ]


def make_empty_marks(
    network: Network, empty: Iterable[int], view: View, lift: float, *, through: bool
) -> Triangles:
    """Make a dashed line within the loops of patches that have no quads."""
    dashes: list[Points] = []
    for number in empty:
        points, normals = trace_outline(network, network.patches[number].loop)
        within = points.mean(axis=0) + DRAWN_IN * (points - points.mean(axis=0))
        facing = normals @ view.axes[2] > AWAY
        line = view.seen(np.concatenate([within, within[:1]]))
        for part in cut_runs(line, np.concatenate([facing, facing[:1]]) | through):
            dashes += dash_line(part, DASH)
    return make_ribbons(dashes, WRONG, EMPTY_WIDTH, lift)


def find_stem(network: Network, node: Node, view: View) -> Points:
    """Find (2,) the direction, as it is seen, in which a T-junction's curves end on it."""
    passed = {k for k, flag in enumerate(node.corner_flags) if not flag}
    straight = {k for wedge in passed for k in (wedge, (wedge + 1) % len(node.ends))}
    total = np.zeros(3)
    for k, half in enumerate(node.ends):
        if k in straight and len(straight) < len(node.ends):
            continue
        points, _ = network.chains[half >> 1].directed(half)
        step = points[min(3, len(points) - 1)] - node.point
        total += step / max(float(np.linalg.norm(step)), 1e-300)
    way = (view.axes @ total)[:2]
    size = float(np.hypot(*way))
    return way / size if size > 1e-9 else np.array([0.0, 1.0])


def make_half_discs(
    places: Points, ways: Points, colour: str, radius: float, lift: float
) -> Triangles:
    """Make the halves of discs at places (n, 3) that lie in directions (n, 2), as they are seen."""
    if not len(places):
        return NOTHING
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, HALF)
    left = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
    rim = radius * (
        np.cos(angle)[None, :, None] * ways[:, None] + np.sin(angle)[None, :, None] * left[:, None]
    )
    rim = np.concatenate([rim, np.zeros((*rim.shape[:2], 1))], axis=2)
    at = (places + np.array([0.0, 0.0, lift]))[:, None]
    fan = np.stack(
        [np.broadcast_to(at, rim[:, 1:].shape), at + rim[:, :-1], at + rim[:, 1:]], axis=2
    ).reshape(-1, 3, 3)
    return fan, np.broadcast_to(parse_colour(colour), fan.shape).astype(np.float32)


def make_shapes(places: Points, outline: Points, colour: str, lift: float) -> Triangles:
    """Make a convex outline (k, 2) about places (n, 3), as they are seen."""
    if not len(places):
        return NOTHING
    rim = np.concatenate([outline, np.zeros((len(outline), 1))], axis=1)
    at = (places + np.array([0.0, 0.0, lift]))[:, None]
    one, other = at + rim, at + np.roll(rim, -1, axis=0)
    fan = np.stack([np.broadcast_to(at, one.shape), one, other], axis=2).reshape(-1, 3, 3)
    return fan, np.broadcast_to(parse_colour(colour), fan.shape).astype(np.float32)


def make_valence_marks(places: Points, valence: int, radius: float, lift: float) -> list[Triangles]:
    """Make the markers of irregular vertices of a valence at places (n, 3), with a white rim."""
    shape = style.choose_valence_shape(valence)
    return [
        make_shapes(places, shape * (radius + 1.1), style.PAPER, lift),
        make_shapes(places, shape * radius, style.choose_valence_colour(valence), lift + 0.4),
    ]
