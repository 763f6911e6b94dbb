"""Places on chains: their points as flat arrays, what is near a point, cuts and joints there."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.retopo.network.samples import find_nearest
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, as_points, units
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network.structure import NONE, Chain, HalfChain, Network, Node


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Of m samples; chains in ascending order of their ids, each in its direction.

    points, normals: (m, 3) float64. chain: (m,) int32 ids. place: (m,) float64, the sample's
    number on its chain. node: (m,) int32, its node at an end of a chain, else -1: a node
    is there once for every end.
    ids: (c,) int32, starts: (c + 1,) int32: the samples of chain ids[k] are those from starts[k]
    to starts[k + 1]. is_closed_loop: (c,) bool, is it closed, without a node?
    """

    points: Points
    normals: Points
    chain: Int32Array
    place: NDArray[np.float64]
    node: Int32Array
    ids: Int32Array
    starts: Int32Array
    is_closed_loop: NDArray[np.bool_]


def take_samples(network: Network) -> Samples:
    """The samples of all chains of a network."""
    return take_chain_samples(network.chains)


def take_chain_samples(lines: Mapping[int, Chain]) -> Samples:
    """The samples of chains by their ids."""
    ids = sorted(lines)
    chains = [lines[k] for k in ids]
    sizes = np.array([len(chain.points) for chain in chains], np.int64)
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    empty = np.empty((0, 3))
    node = np.full(starts[-1], NONE, np.int32)
    node[starts[:-1]] = [chain.start for chain in chains]
    node[starts[1:] - 1] = [chain.end for chain in chains]
    return Samples(
        np.concatenate([empty, *(chain.points for chain in chains)]),
        np.concatenate([empty, *(chain.normals for chain in chains)]),
        np.repeat(np.array(ids, np.int32), sizes),
        np.arange(starts[-1], dtype=np.float64) - np.repeat(starts[:-1], sizes),
        node,
        np.array(ids, np.int32),
        starts,
        np.array([chain.is_closed_loop for chain in chains], bool),
    )


@dataclass(frozen=True, slots=True)
class ChainPlace:
    """A place on a chain, in samples, and how far it is off."""

    chain: int
    place: float
    distance: float


def find_nearest_node(
    network: Network, point: ArrayLike, normal: ArrayLike, radius: float, valences: range
) -> Node | None:
    """The nearest node within a radius whose valence is among some, and whose normal agrees.

    range(1, 2) for open ends, range(2, 3) for corners between two chains, and so on.
    """
    some = (node for node in network.nodes.values() if node.valence in valences)
    return find_nearest_among(some, point, normal, radius)


def find_nearest_among(
    some: Iterable[Node], point: ArrayLike, normal: ArrayLike, radius: float
) -> Node | None:
    """The nearest of some nodes within a radius whose normal agrees."""
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    nodes = list(some)
    if not nodes:
        return None
    away = np.linalg.norm(np.array([node.point for node in nodes]) - at, axis=1)
    agree = np.array([node.normal for node in nodes]) @ up > 0.0
    away = np.where(agree, away, np.inf)
    best = int(np.argmin(away))
    return nodes[best] if away[best] <= radius else None


def find_nearest_place(
    of: Samples, point: ArrayLike, normal: ArrayLike, radius: float
) -> ChainPlace | None:
    """The nearest place on a chain within a radius, where the surface's normal agrees."""
    k, share, away = find_nearest(
        of.points,
        of.normals,
        of.starts,
        of.is_closed_loop,
        np.ascontiguousarray(point, np.float64),
        np.ascontiguousarray(normal, np.float64),
    )
    if k < 0 or away > radius:
        return None
    return ChainPlace(int(of.chain[k]), float(of.place[k] + share), away)


def interpolate_places(
    points: Points, normals: Points, places: NDArray[np.float64]
) -> tuple[Points, Points]:
    """(k, 3) points and normals of a polyline at places in samples; a closed one goes round."""
    k = np.floor(places).astype(np.int64)
    share = (places - k)[:, None]
    n = len(points)
    one, two = k % n, np.where(share[:, 0] > 0.0, k + 1, k) % n
    at = (1.0 - share) * points[one] + share * points[two]
    return at, units((1.0 - share) * normals[one] + share * normals[two])


#: A cut this near to a sample, as a part of the segment, is made at the sample: chains get no
#: tiny segments, and a cut and a merge give the chain that was.
AT_SAMPLE = 0.1


def check_line(points: ArrayLike, normals: ArrayLike) -> tuple[Points, Points]:
    """A chain's points and normals (n, 3) as new arrays; InvalidRetopoError if they are none."""
    line = as_points(points, "a chain's points", InvalidRetopoError)
    up = as_points(normals, "a chain's normals", InvalidRetopoError)
    if len(line) < 2 or len(up) != len(line):
        raise InvalidRetopoError(
            f"a chain of {len(line)} points with {len(up)} normals; give two or more, one each"
        )
    return line, up


@dataclass(frozen=True, slots=True)
class Cut:
    """Where a chain was cut, and what became of it.

    place:  in samples. at, share: the sample at or before it, and the part of the segment from
            there; 0 if the cut is at the sample itself.
    pieces: ids of the new chains, in the old one's direction; one, of a closed chain without
            a node.
    samples: how many the old chain had.
    """

    at: int
    share: float
    pieces: tuple[int, ...]
    samples: int

    @property
    def place(self) -> float:
        return self.at + self.share

    def move_place(self, place: float) -> tuple[int, float]:
        """The new chain, and the place on it, of a place on the old one."""
        if len(self.pieces) == 2 and place <= self.place:
            return self.pieces[0], self._before(place, self.at)
        if place < self.place:
            place += self.samples
        if len(self.pieces) == 2:
            return self.pieces[1], self._after(place)
        last = self.at + self.samples
        if place > last:
            return self.pieces[0], self._before(place, last) - self.at
        return self.pieces[0], self._after(place)

    def _before(self, place: float, at: int) -> float:
        """Among the samples up to the cut, the last segment of which became shorter."""
        if place <= at or self.share == 0.0:
            return min(place, float(at))
        return at + min((place - at) / self.share, 1.0)

    def _after(self, place: float) -> float:
        """Among the samples from the cut on, the first segment of which became shorter."""
        if place >= self.at + 1:
            return place - self.at
        return max((place - self.place) / (1.0 - self.share), 0.0)


def locate_place(chain: Chain, place: float) -> tuple[int, float]:
    """The sample at or before a place, and the part of the segment from there; 0 near samples.

    Raises InvalidRetopoError for a place that is not on the chain.
    """
    last = chain.segments
    if not 0.0 <= place <= last:
        raise InvalidRetopoError(
            f"place {place} is not on chain {chain.id}, whose places run from 0 to {last}"
        )
    at = min(math.floor(place), last - 1)
    share = place - at
    if share < AT_SAMPLE:
        share = 0.0
    elif share > 1.0 - AT_SAMPLE:
        at, share = at + 1, 0.0
    if chain.is_closed_loop:
        at %= last
    return at, share


def point_at_place(chain: Chain, at: int, share: float) -> tuple[Points, Points]:
    """(3,) point and normal of a place."""
    if share == 0.0:
        return chain.points[at], chain.normals[at]
    after = (at + 1) % len(chain.points)
    point = (1.0 - share) * chain.points[at] + share * chain.points[after]
    normal = (1.0 - share) * chain.normals[at] + share * chain.normals[after]
    return point, units(normal[None])[0]


def open_chain(chain: Chain, cut: Cut, node: int, point: Points, normal: Points) -> Chain:
    """A closed chain without a node after its first cut: from the node to the node."""
    first = cut.at if cut.share == 0.0 else cut.at + 1
    points = np.roll(chain.points, -first, axis=0)
    normals = np.roll(chain.normals, -first, axis=0)
    if cut.share == 0.0:
        points, normals = points[1:], normals[1:]
    return replace(
        chain,
        id=cut.pieces[0],
        start=node,
        end=node,
        points=np.concatenate([point[None], points, point[None]]),
        normals=np.concatenate([normal[None], normals, normal[None]]),
    )


def split_chain(
    chain: Chain, cut: Cut, node: int, point: Points, normal: Points
) -> tuple[Chain, Chain]:
    """A chain from node to node after a cut between them; the count is split by length."""
    before, after = cut.at + (cut.share > 0.0), cut.at + 1
    point, normal = point[None], normal[None]
    one = np.concatenate([chain.points[:before], point])
    two = np.concatenate([point, chain.points[after:]])
    steps = [np.linalg.norm(np.diff(part, axis=0), axis=1).sum() for part in (one, two)]
    counts, pinned = split_count(chain.count, float(steps[0]), float(steps[1])), chain.pinned
    pinned = pinned and sum(counts) == chain.count
    return (
        replace(
            chain,
            id=cut.pieces[0],
            end=node,
            points=one,
            normals=np.concatenate([chain.normals[:before], normal]),
            count=counts[0],
            pinned=pinned,
        ),
        replace(
            chain,
            id=cut.pieces[1],
            start=node,
            points=two,
            normals=np.concatenate([normal, chain.normals[after:]]),
            count=counts[1],
            pinned=pinned,
        ),
    )


def split_count(count: int, one: float, two: float) -> tuple[int, int]:
    """A count in proportion to two lengths, each part at least 1; a single edge becomes two."""
    if count == 0:
        return 0, 0
    if count == 1:
        return 1, 1
    first = min(max(round(count * one / (one + two)), 1), count - 1)
    return first, count - first


def join_chains(
    first: Chain, last: Chain, arriving: HalfChain, leaving: HalfChain, new: int
) -> Chain:
    """One chain from the two that meet at a node, in the directions given.

    first: the chain of the half ``arriving`` at the node, last: of the half ``leaving`` it; their
    marks agree. The same chain twice becomes a closed one without a node. Counts add; the sum
    is pinned if both are, and not chosen if one is not.
    """
    points, normals = first.directed(arriving)
    left, right = first.marks
    marks = (right, left) if arriving & 1 else (left, right)
    if first.id == last.id:
        return replace(
            first,
            id=new,
            start=NONE,
            end=NONE,
            points=points[:-1].copy(),
            normals=normals[:-1].copy(),
            marks=marks,
        )
    more, above = last.directed(leaving)
    known = first.count > 0 and last.count > 0
    return Chain(
        new,
        first.end if arriving & 1 else first.start,
        last.start if leaving & 1 else last.end,
        np.concatenate([points, more[1:]]),
        np.concatenate([normals, above[1:]]),
        first.count + last.count if known else 0,
        known and first.pinned and last.pinned,
        marks,
        first.auto and last.auto,
    )
