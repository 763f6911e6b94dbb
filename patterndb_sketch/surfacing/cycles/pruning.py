"""Dangling curves: those that end where nothing goes on, and so bound nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.surfacing.network import Network


def curve_ends(network: Network) -> NDArray[np.int64]:
    """(m, 2) the nodes where every curve begins and ends."""
    return np.array([curve.nodes for curve in network.curves], np.int64).reshape(-1, 2)


def dangling(network: Network) -> NDArray[np.bool_]:
    """(m,) bool: which curves dangle, also after others that dangle are gone.

    A closed curve never does.
    """
    ends = curve_ends(network)
    gone = np.zeros(len(ends), bool)
    while True:
        degree = np.bincount(ends[~gone].ravel(), minlength=len(network.nodes))
        more = ~gone & (degree[ends] == 1).any(axis=1)
        if not more.any():
            return gone
        gone |= more


def components(network: Network, alive: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The curves (m,) bool that are alive, in groups that hang together by nodes."""
    parent = np.arange(len(network.nodes))

    def root(node: int) -> int:
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = int(parent[node])
        return node

    ends = curve_ends(network)
    for a, b in ends[alive].tolist():
        parent[root(b)] = root(a)
    groups: dict[int, list[int]] = {}
    for curve in np.flatnonzero(alive).tolist():
        groups.setdefault(root(int(ends[curve, 0])), []).append(curve)
    return [np.array(group, np.int64) for group in groups.values()]
