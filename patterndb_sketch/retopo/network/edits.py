"""Edit a network once, by a function; several edits at once take a :class:`NetworkBuilder`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.builder import End, Free, NetworkBuilder
from patterndb_sketch.retopo.network.structure import BORDER, Network


@dataclass(frozen=True, slots=True, eq=False)
class Edit:
    """What a tool did.

    network: as it is now. notes: what the user should know, in words.
    nodes, chains, patches: ids of those that are there now and were not before.
    """

    network: Network = field(repr=False)
    notes: tuple[str, ...]
    nodes: tuple[int, ...]
    chains: tuple[int, ...]
    patches: tuple[int, ...]

    @classmethod
    def of(cls, before: Network, after: Network, notes: Iterable[str] = ()) -> Edit:
        """By comparing two networks."""
        return cls(
            after,
            tuple(notes),
            tuple(after.nodes.keys() - before.nodes.keys()),
            tuple(after.chains.keys() - before.chains.keys()),
            tuple(after.patches.keys() - before.patches.keys()),
        )


def add_chain(
    network: Network,
    points: ArrayLike,
    normals: ArrayLike,
    start: End = Free(),  # noqa: B008 (immutable)
    end: End = Free(),  # noqa: B008
) -> tuple[Network, int]:
    """With a chain that crosses no other; its id. See :meth:`NetworkBuilder.add_chain`."""
    builder = NetworkBuilder(network)
    chain = builder.add_chain(points, normals, start, end)
    return builder.finish(), chain


def add_loop(network: Network, points: ArrayLike, normals: ArrayLike) -> tuple[Network, int]:
    """With a closed chain that crosses no other; its id. See :meth:`NetworkBuilder.add_loop`."""
    builder = NetworkBuilder(network)
    chain = builder.add_loop(points, normals)
    return builder.finish(), chain


def cut_chain(
    network: Network, chain: int, place: float, at: tuple[Points, Points] | None = None
) -> tuple[Network, int]:
    """With a chain cut by a corner (on both sides) at a place; the node."""
    builder = NetworkBuilder(network)
    node = builder.cut_chain(chain, place, at)
    if node not in network.nodes:
        for half in builder.nodes[node].ends:
            builder.flag(half, True)
    return builder.finish(), node


def set_count(network: Network, chain: int, count: int, pinned: bool = False) -> Network:
    """With a number of edges along a chain, 0 for not chosen."""
    if count < 0 or (pinned and count == 0):
        raise InvalidRetopoError(f"a chain of {count} edges; give 1 or more, or 0 to let choose")
    new = replace(network.chain(chain), count=count, pinned=pinned)
    return replace(network, chains={**network.chains, chain: new})


def set_choice(network: Network, patch: int, choice: Any) -> Network:
    """With a fill chosen for a patch, or None."""
    if patch not in network.patches:
        raise InvalidRetopoError(f"there is no patch {patch} in the network")
    new = replace(network.patches[patch], choice=choice)
    return replace(network, patches={**network.patches, patch: new})


def add_borders(network: Network, surface: Surface, sampling: float) -> Network:
    """The network with every border of the surface as a closed chain, marked beyond it.

    sampling: greatest distance of neighbouring samples; the border's vertices are among them.
    The surface is on the left of the chains, and never a patch on their right. From then on the
    network knows the surface.
    """
    builder = NetworkBuilder(network, surface)
    for loop in trace_borders(surface):
        corners, up = surface.vertices[loop], surface.normals[loop]
        after, up_after = np.roll(corners, -1, axis=0), np.roll(up, -1, axis=0)
        lengths = np.linalg.norm(after - corners, axis=1)
        parts = [max(1, math.ceil(length / sampling)) for length in lengths]
        edge = np.repeat(np.arange(len(loop)), parts)
        share = np.concatenate([np.arange(k) / k for k in parts])[:, None]
        builder.add_loop(
            corners[edge] + share * (after - corners)[edge],
            units(up[edge] + share * (up_after - up)[edge]),
            marks=("", BORDER),
        )
    return builder.finish()


def trace_borders(surface: Surface) -> list[Int32Array]:
    """(k,) the vertices around every border of the surface, the surface on the left.

    At a vertex that several borders pass, each goes on along the triangles that it came by.
    Where neighbouring triangles are turned against each other, the first side tells the left.
    Borders of two sides, which only triangles on top of each other have, are left out.
    """
    across, triangles = surface.adjacency.across, surface.triangles
    seen: set[int] = set()
    loops: list[Int32Array] = []
    for first in surface.adjacency.border:
        if int(first) in seen:
            continue
        side, along = int(first), True
        loop: list[int] = []
        while True:
            seen.add(side)
            f, e = divmod(side, 3)
            loop.append(int(triangles[f, e if along else (e + 1) % 3]))
            head = triangles[f, (e + 1) % 3 if along else e]
            side, along = _find_next_side(across, triangles, side, head)
            if side == first:
                break
        if len(loop) >= 3:
            loops.append(np.array(loop, np.int32))
    return loops


def _find_next_side(
    across: Int32Array, triangles: Int32Array, side: int, head: int
) -> tuple[int, bool]:
    """The border's side after one, around the vertex at its head, and does its triangle run so?"""
    while True:
        f, e = divmod(side, 3)
        # The other side of this triangle at the vertex.
        k = (e + 1) % 3 if triangles[f, (e + 1) % 3] == head else (e + 2) % 3
        other = 3 * f + k
        if across[other] < 0:
            return other, bool(triangles[f, k] == head)
        side = int(across[other])
