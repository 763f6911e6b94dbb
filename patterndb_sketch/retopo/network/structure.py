"""The curve network: nodes, the chains between them, and the patches that they enclose.

A half-chain is a chain in one of its two directions, and is a number: ``2 * chain`` forward,
``2 * chain + 1`` backward. What is on the left of a half-chain belongs to it: its wedges, its
face, its patch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.density import EVEN, Density

HalfChain = int

#: No node: where a closed chain without any would have its ends.
NONE = -1

#: What may be written on a side of a chain that never gets a patch: beyond it is the border of
#: the surface, the plane of symmetry, or a face of a mesh that was given and stays as it is.
BORDER = "border"
SYMMETRY = "symmetry"
FACE = "face"
MARKS = ("", BORDER, SYMMETRY, FACE)


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """A curve from node to node, or a closed one without a node.

    start, end: ids of nodes, which may be the same; both -1 for a closed one without a node.
    points:  (n, 3) float64, read-only, n >= 2, ends included; a closed one without a node has
             n >= 3 and does not repeat its first point.
    normals: (n, 3) float64 unit normals of the surface there, read-only.
    count:   edges of the quad mesh along it; 0 while none is chosen.
    pinned:  was the count chosen by the user?
    marks:   of its left and its right side, seen forwards: "", or why no patch is ever there.
    auto:    did a draft lay it, so that it may move where quads are fitted to the surface?
    """

    id: int
    start: int
    end: int
    points: Points = field(repr=False)
    normals: Points = field(repr=False)
    count: int = 0
    pinned: bool = False
    marks: tuple[str, str] = ("", "")
    auto: bool = False

    def __post_init__(self) -> None:
        self.points.flags.writeable = False
        self.normals.flags.writeable = False

    @property
    def is_closed_loop(self) -> bool:
        """Is it closed, without any node?"""
        return self.start == NONE

    @property
    def marked(self) -> bool:
        """Is one of its sides marked? Such chains are never erased or moved."""
        return self.marks != ("", "")

    @property
    def round(self) -> Points:
        """(m + 1, 3) the points of its m segments; a closed one ends where it begins."""
        return (
            np.concatenate([self.points, self.points[:1]]) if self.is_closed_loop else self.points
        )

    @property
    def round_normals(self) -> Points:
        """(m + 1, 3) the normals of the same."""
        return (
            np.concatenate([self.normals, self.normals[:1]])
            if self.is_closed_loop
            else self.normals
        )

    @property
    def segments(self) -> int:
        return len(self.points) if self.is_closed_loop else len(self.points) - 1

    @property
    def length(self) -> float:
        steps = np.diff(self.round, axis=0)
        return float(np.sqrt(np.einsum("nc,nc->n", steps, steps)).sum())

    def directed(self, half: HalfChain) -> tuple[Points, Points]:
        """(n, 3) points and normals in the direction of one of its halves."""
        if half & 1:
            return self.points[::-1], self.normals[::-1]
        return self.points, self.normals


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """Where chains end: an open end (one chain), a corner or a T-junction.

    point, normal: (3,) float64, read-only; the chains that end here have exactly these there.
    ends:    half-chains that leave it, counter-clockwise seen from outside.
    corner_flags: wedge i lies between ends[i] and the next: is it a corner of the face in it? One
             that is not is passed straight: where others are, this is a T-junction. An open end
             has the one wedge, no corner; all others have a corner.
    cut:     was it made by another curve that met the inside of a chain? If that curve goes,
             so does the node.
    """

    id: int
    point: Points = field(repr=False)
    normal: Points = field(repr=False)
    ends: tuple[HalfChain, ...] = ()
    corner_flags: tuple[bool, ...] = ()
    cut: bool = False

    def __post_init__(self) -> None:
        self.point.flags.writeable = False
        self.normal.flags.writeable = False

    @property
    def open(self) -> bool:
        """Does a single chain end here?"""
        return len(self.ends) == 1

    @property
    def valence(self) -> int:
        return len(self.ends)

    def wedge_after(self, half: HalfChain) -> int:
        """The wedge on the left of one of its ends."""
        return self.ends.index(half)

    def wedge_before(self, half: HalfChain) -> int:
        """The wedge on the right of one of its ends: where a walk that arrives by its twin
        goes on."""
        return (self.ends.index(half) - 1) % len(self.ends)


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A loop of half-chains, counter-clockwise seen from outside, that is filled with quads.

    loop:    the half-chains in order; the first is, of those that leave a corner, the one with
             the lowest number.
    corners: ascending places in ``loop`` of the half-chains that leave a corner; the first is 0.
    choice:  which fill the user or the program took, None before one is. Whatever it is must
             be immutable and compare with ``==``.
    """

    id: int
    loop: tuple[HalfChain, ...]
    corners: tuple[int, ...]
    choice: Any = None

    @property
    def sides(self) -> tuple[tuple[HalfChain, ...], ...]:
        """The half-chains of every side, from corner to corner; more than one where others
        end on it (T-junctions)."""
        ends = (*self.corners[1:], len(self.loop))
        return tuple(self.loop[a:b] for a, b in zip(self.corners, ends, strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Nodes, chains and patches by their ids; immutable: every edit gives another network,
    which shares with the old one what did not change, and undoing is to take the old one.

    next_id: above all ids in use; an id is never used twice within one line of edits.
    longest: a loop longer than this never becomes a patch by itself; the surface's own unit. The
             program of Takayama et al. takes twice the diagonal of the surface.
    surface:  the surface that it lies on, None for a plane. Tools that are given one put it here;
             it is no part of what :func:`.invariants.are_equal` compares, nor of sessions.
    density: how dense its quads shall be, as it is painted.
    """

    nodes: Mapping[int, Node] = field(default_factory=dict)
    chains: Mapping[int, Chain] = field(default_factory=dict)
    patches: Mapping[int, Patch] = field(default_factory=dict)
    next_id: int = 0
    longest: float = math.inf
    surface: Surface | None = field(default=None, repr=False)
    density: Density = EVEN

    def chain(self, chain: int) -> Chain:
        """By id; raises InvalidRetopoError if it is not there (any more)."""
        found = self.chains.get(chain)
        if found is None:
            raise InvalidRetopoError(f"there is no chain {chain} in the network")
        return found

    def node(self, node: int) -> Node:
        """By id; raises InvalidRetopoError if it is not there (any more)."""
        found = self.nodes.get(node)
        if found is None:
            raise InvalidRetopoError(f"there is no node {node} in the network")
        return found

    def origin(self, half: HalfChain) -> int:
        """The node that a half-chain leaves, -1 for none."""
        chain = self.chains[half >> 1]
        return chain.end if half & 1 else chain.start

    def target(self, half: HalfChain) -> int:
        """The node that a half-chain arrives at, -1 for none."""
        return self.origin(half ^ 1)

    def mark(self, half: HalfChain) -> str:
        """The mark on the left of a half-chain."""
        return self.chains[half >> 1].marks[half & 1]

    def patch_of(self) -> dict[HalfChain, int]:
        """The id of the patch on the left of every half-chain that has one."""
        return {half: patch.id for patch in self.patches.values() for half in patch.loop}
