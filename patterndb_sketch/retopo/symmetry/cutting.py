"""A network cut by the plane of symmetry: what lies beyond it goes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network import BORDER, Chain, Draft
from patterndb_sketch.retopo.network.stops import between
from patterndb_sketch.retopo.symmetry.half import Half


@dataclass(frozen=True, slots=True, eq=False)
class Parting:
    """What became of a network's chains.

    level: chains that lie in the plane, as they are now. beyond: how many curves lay beyond the
    plane as a whole, and are gone; borders of the surface do not count. cut: how many were cut.
    """

    level: tuple[int, ...]
    beyond: int
    cut: int


def part(draft: Draft, half: Half) -> Parting:
    """Cut the chains of a draft where they cross the plane, and drop what lies beyond it.

    Chains in the plane stay, for the caller to use or drop.
    """
    level: list[int] = []
    beyond, cut = 0, 0
    for chain in sorted(draft.chains):
        old = draft.chains[chain]
        height = heights_of(half, old.points)
        if not height.any():
            level.append(chain)
            continue
        if not (height > 0.0).any():
            draft.remove_chain(chain)
            beyond += BORDER not in old.marks
            continue
        places = crossing_places(height, old.loose)
        for place in places:
            points, normals = between(old.points, old.normals, np.array([place]))
            draft.cut_chain(chain, place, (half.plane.flattened(points)[0], normals[0]))
        cut += bool(places) and BORDER not in old.marks
        for piece in sorted(draft.pieces([chain])):
            there = heights_of(half, draft.chains[piece].points)
            if not there.any():
                level.append(piece)
            elif there.sum() < 0.0:
                draft.remove_chain(piece)
    return Parting(tuple(level), beyond, cut)


def heights_of(half: Half, points: Points) -> NDArray[np.float64]:
    """(n,) heights of (n, 3) points above the plane, 0 for those on it."""
    height = half.plane.heights(points)
    height[np.abs(height) <= half.near] = 0.0
    return height


def crossing_places(height: NDArray[np.float64], closed: bool) -> list[float]:
    """Where a polyline with these heights (n,) crosses the plane or comes to run in it, or leaves
    it: places in samples, ascending. One that only touches it with a sample goes on."""
    off = np.flatnonzero(height)
    n = len(height)
    if not len(off):
        return []
    found: list[float] = []
    if not closed and off[0] > 1:
        found.append(float(off[0] - 1))
    follower = np.r_[off[1:], off[0] + n] if closed else off[1:]
    for i, j in zip(off[: len(follower)].tolist(), follower.tolist(), strict=True):
        one, two = float(height[i]), float(height[j % n])
        if j == i + 1:
            if (one > 0.0) != (two > 0.0):
                found.append(i + one / (one - two))
        elif j > i + 2:
            found += [float((i + 1) % n), float((j - 1) % n)]
        elif (one > 0.0) != (two > 0.0):
            found.append(float((i + 1) % n))
    if not closed and off[-1] < n - 2:
        found.append(float(off[-1] + 1))
    return sorted(set(found))


def on_plane(draft: Draft, half: Half) -> list[int]:
    """The nodes of a draft that are on the plane."""
    ids = sorted(node for node, at in draft.nodes.items() if at.ends)
    if not ids:
        return []
    points: Points = np.array([draft.nodes[node].point for node in ids])
    return [
        node for node, h in zip(ids, heights_of(half, points).tolist(), strict=True) if h == 0.0
    ]


def runs_alike(one: Chain, line: Points) -> bool:
    """Does a chain run as a polyline (n, 3) between the same places does, seen at its middle?"""
    middle, there = one.points[len(one.points) // 2], line[len(line) // 2]
    step = float(np.linalg.norm(np.diff(line, axis=0), axis=1).max()) if len(line) > 1 else 0.0
    gaps = np.linalg.norm(line - middle, axis=1)
    back = np.linalg.norm(one.points - there, axis=1)
    return bool(gaps.min() <= step and back.min() <= step)
