"""Layers of a network: its curves, corners and ends, and what marks empty patches."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network import Chain, Network, Node, trace_outline
from viewer import style
from viewer.camera import View
from viewer.stage import Curves, Layer, Lift, LineLook, Marks, make_discs

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


#: Radii in points: of corners, of open ends, and of T-junctions.
CORNER_RADIUS, END_RADIUS, T_RADIUS = 4.2, 4.4, 5.0

#: The line in a patch without quads: how far within its loop, as a part of it, its width and its
#: dashes, in points.
DRAWN_IN, EMPTY_WIDTH, EMPTY_DASH = 0.9, 2.4, 7.0

#: Points of a half disc's rim.
HALF = 13


def make_chain_curves(
    name: str, chains: Iterable[Chain], look: LineLook, *, through: bool
) -> Curves:
    """Make the curves of chains, where they face the viewer; all of them where one sees through."""
    lines: list[Points] = []
    normals: list[Points] = []
    for chain in chains:
        lines.append(chain.round)
        closed = chain.normals[:1] if chain.is_closed_loop else chain.normals[:0]
        normals.append(np.concatenate([chain.normals, closed]))
    return Curves.of(name, lines, look, None if through else normals)


def make_node_marks(network: Network, view: View, lift: Lift, *, through: bool) -> list[Layer]:
    """Make marks of nodes: corners full, T-junctions half, open ends hollow."""
    corners: list[Node] = []
    ends: list[Node] = []
    halves: list[Node] = []
    for node in network.nodes.values():
        (ends if node.open else corners if all(node.corner_flags) else halves).append(node)
    layers: list[Layer] = []
    for name, nodes, discs in (
        ("corners", corners, ((style.PAPER, CORNER_RADIUS + 1.0), (CORNER, CORNER_RADIUS))),
        ("ends", ends, ((CORNER, END_RADIUS), (style.PAPER, 0.58 * END_RADIUS))),
        ("T-junctions", halves, ((CORNER, T_RADIUS), (style.PAPER, T_RADIUS - 1.1))),
    ):
        places = np.array([node.point for node in nodes]).reshape(-1, 3)
        normals = None if through else np.array([node.normal for node in nodes]).reshape(-1, 3)
        layers += [
            make_discs(f"{name} {k}", places, colour, radius, lift.above(0.5 * k), normals)
            for k, (colour, radius) in enumerate(discs)
        ]
        if nodes is halves and halves:
            ways = np.array([find_stem(network, node, view) for node in halves])
            rims = make_half_discs(ways, T_RADIUS - 0.9)
            layers.append(Marks("stems", places, rims, CORNER, lift.above(1.0), normals))
    return layers


def make_empty_marks(
    network: Network, empty: Iterable[int], look: LineLook, *, through: bool
) -> Curves:
    """Make a dashed line within the loops of patches that have no quads."""
    lines: list[Points] = []
    normals: list[Points] = []
    for number in empty:
        points, up = trace_outline(network, network.patches[number].loop)
        within = points.mean(axis=0) + DRAWN_IN * (points - points.mean(axis=0))
        lines.append(np.concatenate([within, within[:1]]))
        normals.append(np.concatenate([up, up[:1]]))
    return Curves.of("empty", lines, look, None if through else normals)


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


def make_half_discs(ways: Points, radius: float) -> Points:
    """Make (n, k, 2) the outlines of the halves of discs that lie in directions (n, 2)."""
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, HALF)
    left = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
    return radius * (
        np.cos(angle)[None, :, None] * ways[:, None] + np.sin(angle)[None, :, None] * left[:, None]
    )
