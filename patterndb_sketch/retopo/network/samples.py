"""All points of all chains as flat arrays, and what of a network is near a point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.retopo.network.samples import find_nearest
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.network.structure import NONE, Chain, Network, Node


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Of m samples; chains in ascending order of their ids, each in its direction.

    points, normals: (m, 3) float64. chain: (m,) int32 ids. place: (m,) float64, the sample's
    number on its chain. node: (m,) int32, its node at an end of a chain, else -1: a node
    is there once for every end.
    ids: (c,) int32, starts: (c + 1,) int32: the samples of chain ids[k] are those from starts[k]
    to starts[k + 1]. loose: (c,) bool, is it closed, without a node?
    """

    points: Points
    normals: Points
    chain: Int32Array
    place: NDArray[np.float64]
    node: Int32Array
    ids: Int32Array
    starts: Int32Array
    loose: NDArray[np.bool_]


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
        np.array([chain.loose for chain in chains], bool),
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
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    nodes = [node for node in network.nodes.values() if node.valence in valences]
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
        of.loose,
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
