"""The borders of the surface as marked chains of the network."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import units
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.structure import BORDER, Network


def with_borders(network: Network, ground: Ground, sampling: float) -> Network:
    """The network with every border of the ground as a closed chain, marked beyond it.

    sampling: greatest distance of neighbouring samples; the border's vertices are among them.
    The surface is on the left of the chains, and never a patch on their right. From then on the
    network knows the ground.
    """
    draft = Draft(network, ground)
    for loop in border_loops(ground):
        corners, up = ground.vertices[loop], ground.normals[loop]
        after, up_after = np.roll(corners, -1, axis=0), np.roll(up, -1, axis=0)
        lengths = np.linalg.norm(after - corners, axis=1)
        parts = [max(1, math.ceil(length / sampling)) for length in lengths]
        edge = np.repeat(np.arange(len(loop)), parts)
        share = np.concatenate([np.arange(k) / k for k in parts])[:, None]
        draft.add_loop(
            corners[edge] + share * (after - corners)[edge],
            units(up[edge] + share * (up_after - up)[edge]),
            marks=("", BORDER),
        )
    return draft.finished()


def border_loops(ground: Ground) -> list[Int32Array]:
    """(k,) the vertices around every border of the ground, the surface on the left.

    At a vertex that several borders pass, each goes on along the triangles that it came by.
    Where neighbouring triangles are turned against each other, the first side tells the left.
    Borders of two sides, which only triangles on top of each other have, are left out.
    """
    across, triangles = ground.topology.across, ground.triangles
    seen: set[int] = set()
    loops: list[Int32Array] = []
    for first in ground.topology.border:
        if int(first) in seen:
            continue
        side, along = int(first), True
        loop: list[int] = []
        while True:
            seen.add(side)
            f, e = divmod(side, 3)
            loop.append(int(triangles[f, e if along else (e + 1) % 3]))
            head = triangles[f, (e + 1) % 3 if along else e]
            side, along = _next(across, triangles, side, head)
            if side == first:
                break
        if len(loop) >= 3:
            loops.append(np.array(loop, np.int32))
    return loops


def _next(across: Int32Array, triangles: Int32Array, side: int, head: int) -> tuple[int, bool]:
    """The border's side after one, around the vertex at its head, and does its triangle run so?"""
    while True:
        f, e = divmod(side, 3)
        # The other side of this triangle at the vertex.
        k = (e + 1) % 3 if triangles[f, (e + 1) % 3] == head else (e + 2) % 3
        other = 3 * f + k
        if across[other] < 0:
            return other, bool(triangles[f, k] == head)
        side = int(across[other])
