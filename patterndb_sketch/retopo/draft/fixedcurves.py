"""Curves that a draft keeps, creases and borders among them: vertices slide along them.

Chains that continue each other straight through T-junctions are one curve, so that a vertex at such
a junction slides, too. A vertex never passes its neighbours, and corners stay.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.polyline import arc_length, interpolate
from patterndb_sketch.retopo.network import FACE, Chain, HalfChain, Network

#: Two chains continue each other if the cosine of the angle between them is above this.
STRAIGHT = 0.85

#: A vertex slides by at most this share of the gap to its neighbour in a round.
SLIDE = 0.4

#: The tangent is taken over this share of the curve's length.
TANGENT = 1e-3

#: A vertex that is nearer than this share of the length to where it was to slide has come there.
CAME = 1e-9

#: A piece has at least so many points.
FEWEST_POINTS = 5


@dataclass(slots=True, eq=False)
class FixedCurve:
    """A curve with the vertices on it.

    vertices: (n,) in order; the last is the first of a closed one. along: (n,) where they are, as
    lengths along the curve. line, normals: (m, 3) the curve's points. place: (m,) their lengths.
    pieces: for each half-chain of it, the first and the last of its vertices' numbers in the order.
    """

    vertices: NDArray[np.signedinteger[Any]]
    along: Floats
    line: Points
    normals: Points
    place: Floats
    closed: bool
    pieces: list[tuple[HalfChain, int, int]]

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """(n,) which vertices slide: all but the ends."""
        found = np.ones(len(self.vertices), np.bool_)
        if not self.closed:
            found[[0, -1]] = False
        return found

    def locate(self, along: Floats) -> tuple[Points, Points]:
        """Return (k, 3) points and unit normals at lengths (k,) along the curve."""
        total = self.place[-1]
        along = along % total if self.closed else np.clip(along, 0.0, total)
        up = interpolate(self.normals, self.place, along)
        return interpolate(self.line, self.place, along), units(up)

    def propose(self, move: Points) -> Floats:
        """Return (n,) lengths where vertices slide to by moves (v, 3), none past a neighbour."""
        step = TANGENT * self.place[-1]
        tangent = units(self.locate(self.along + step)[0] - self.locate(self.along - step)[0])
        by = np.einsum("nc,nc->n", move[self.vertices], tangent)
        gap = np.diff(self.along)
        before = np.r_[gap[-1] if self.closed else 0.0, gap]
        after = np.r_[gap, gap[0]]
        by = np.clip(by, -SLIDE * before, SLIDE * after)
        by[~self.sliding] = 0.0
        if self.closed:
            by[-1] = by[0]
        return self.along + by

    def settle(self, wanted: Floats, at: Points) -> None:
        """Take over the lengths of those vertices that came where they were wanted; at: (v, 3)."""
        points, _ = self.locate(wanted)
        came = np.linalg.norm(points - at[self.vertices], axis=1) < CAME * self.place[-1]
        self.along = np.where(came, wanted, self.along)

    def piece(self, low: int, high: int) -> tuple[Points, Points]:
        """Return the points and normals from one of the vertices to another; the curve's own points
        are among them, as they are."""
        first, last = self.along[low], self.along[high]
        place, number = self.place, np.arange(len(self.place))
        if self.closed:
            place = np.concatenate([place[:-1] - place[-1], place, place[1:] + place[-1]])
            number = np.concatenate([number[:-1], number, number[1:]])
        inner = (place > first) & (place < last)
        place, number = place[inner], number[inner]
        wanted = np.unique(np.r_[first, place, last, np.linspace(first, last, FEWEST_POINTS)])
        points, normals = self.locate(wanted)
        own = np.searchsorted(wanted, place)
        points[own], normals[own] = self.line[number], self.normals[number]
        return points, normals


def find_fixed_curves(
    network: Network,
    laid: Collection[int],
    kept: Collection[int],
    list_along: Callable[[Chain], list[int]],
) -> list[FixedCurve]:
    """Find the curves that stay: chains that no draft laid, joined where they continue each other.

    laid: ids of the chains that may move. kept: patches whose vertices stay, on their borders, too.
    list_along: gives the mesh's vertices along a chain, none where no patch has quads.
    """
    still = {half >> 1 for patch in kept for half in network.patches[patch].loop}
    fixed = {
        c: chain
        for c, chain in network.chains.items()
        if not (c in laid or c in still or FACE in chain.marks or chain.is_closed_loop)
    }
    ends: dict[int, list[HalfChain]] = {}
    for c, chain in fixed.items():
        ends.setdefault(chain.start, []).append(2 * c)
        ends.setdefault(chain.end, []).append(2 * c + 1)
    follows: dict[HalfChain, HalfChain] = {}
    for node, halves in ends.items():
        # Where patches are kept, all nodes of curves that stay do, too.
        joined = len(halves) == 2 and not kept and network.nodes[node].cut
        if joined and _is_straight(network, *halves):
            one, two = halves
            follows[one ^ 1], follows[two ^ 1] = two, one
    found: list[FixedCurve] = []
    left = set(fixed)
    while left:
        halves, closed = _follow(2 * min(left), follows)
        left -= {half >> 1 for half in halves}
        vertices = [list_along(network.chains[half >> 1]) for half in halves]
        if all(vertices):
            found.append(_join(network, halves, vertices, closed))
    return found


def _is_straight(network: Network, one: HalfChain, two: HalfChain) -> bool:
    """Do two half-chains that leave the same node go opposite ways?"""
    away: list[Points] = []
    for half in (one, two):
        line, _ = network.chains[half >> 1].directed(half)
        away.append(line[min(2, len(line) - 1)] - line[0])
    lengths = np.linalg.norm(away[0]) * np.linalg.norm(away[1])
    return bool(away[0] @ away[1] < -STRAIGHT * lengths)


def _follow(half: HalfChain, follows: dict[HalfChain, HalfChain]) -> tuple[list[HalfChain], bool]:
    """Return the half-chains of the curve through one, in order, and whether it is closed."""
    halves = [half]
    while (after := follows.get(halves[-1])) is not None:
        if after == half:
            return halves, True
        halves.append(after)
    while (before := follows.get(halves[0] ^ 1)) is not None:
        halves.insert(0, before ^ 1)
    return halves, False


def _join(
    network: Network, halves: list[HalfChain], vertices: list[list[int]], closed: bool
) -> FixedCurve:
    numbers: list[int] = []
    along: list[Floats] = []
    lines: list[Points] = []
    normals: list[Points] = []
    pieces: list[tuple[HalfChain, int, int]] = []
    far = 0.0
    for half, own in zip(halves, vertices, strict=True):
        chain = network.chains[half >> 1]
        line, up = chain.directed(half)
        pieces.append((half, len(numbers), len(numbers) + len(own) - 1))
        along.append(far + chain.length * np.linspace(0.0, 1.0, len(own))[:-1])
        numbers += (own[::-1] if half & 1 else own)[:-1]
        lines.append(line[:-1])
        normals.append(up[:-1])
        far += chain.length
    numbers.append(vertices[-1][0 if halves[-1] & 1 else -1])
    last_line, last_up = network.chains[halves[-1] >> 1].directed(halves[-1])
    line = np.concatenate([*lines, last_line[-1:]])
    up = np.concatenate([*normals, last_up[-1:]])
    place = arc_length(line)
    lengths = np.concatenate([*along, [far]])
    return FixedCurve(np.array(numbers), lengths, line, up, place, closed, pieces)
