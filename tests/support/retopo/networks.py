"""Surfaces, strokes and networks that the tests of retopology's network and its tools share."""

from __future__ import annotations

from functools import cache

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network import Network, check_network, walk_face
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve

#: Sizes in the unit that is drawn in.
SIZES = Sizes(snap=0.1, spine=1.0, autocompletion=1.0, brush=1.0, edge=0.2, sampling=0.02)

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))


@cache
def plane() -> Surface:
    """A sheet from -5 to 5 both ways."""
    vertices = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], float)
    return Surface.from_arrays(vertices, [[0, 1, 2], [0, 2, 3]]).orient()


@cache
def sphere() -> Surface:
    """The unit sphere, 5,120 triangles."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


def even(points: ArrayLike, closed: bool = False, step: float = SIZES.sampling) -> Points:
    """(n, 3) a polyline of (k, 2) or (k, 3) points, its own points among the samples."""
    at = np.asarray(points, float)
    if at.shape[1] == 2:
        at = np.c_[at, np.zeros(len(at))]
    ends = np.concatenate([at[1:], at[:1]]) if closed else at[1:]
    parts: list[Points] = []
    for a, b in zip(at, ends, strict=False):
        n = max(1, round(float(np.linalg.norm(b - a)) / step))
        parts.append(a + (b - a) * (np.arange(n) / n)[:, None])
    return np.concatenate(parts if closed else [*parts, at[-1:]])


def up(points: Points) -> Points:
    """(n, 3) the plane's normals."""
    return np.tile([0.0, 0.0, 1.0], (len(points), 1))


def flat(points: ArrayLike, closed: bool = False) -> SurfaceCurve:
    """A stroke on the plane along a polyline of (k, 2) points, whose corners are kept."""
    line = even(points, closed)
    return SurfaceCurve(line, up(line), closed)


def drawn(*strokes: ArrayLike, network: Network | None = None) -> Network:
    """A network of strokes on the plane, each a polyline of (k, 2) points."""
    at = Network() if network is None else network
    for stroke in strokes:
        at = insert_stroke(at, plane(), SIZES, flat(stroke)).network
        check_network(at)
    return at


def square() -> Network:
    """The square as four strokes."""
    return drawn(*(np.array([SQUARE[k - 1], SQUARE[k]]) for k in range(4)))


def node_at(network: Network, x: float, y: float) -> int:
    """The node at a place of the plane."""
    away = {
        node.id: float(np.hypot(node.point[0] - x, node.point[1] - y))
        for node in network.nodes.values()
    }
    node = min(away, key=away.__getitem__)
    assert away[node] < 1e-6, away[node]
    return node


def chain_between(network: Network, one: tuple[float, float], two: tuple[float, float]) -> int:
    """The chain between two places of the plane."""
    ends = {node_at(network, *one), node_at(network, *two)}
    (chain,) = [c.id for c in network.chains.values() if {c.start, c.end} == ends]
    return chain


def faces(network: Network) -> list[tuple[int, ...]]:
    """All loops of half-chains."""
    seen: set[int] = set()
    found: list[tuple[int, ...]] = []
    for chain in network.chains:
        for half in (2 * chain, 2 * chain + 1):
            if half not in seen:
                found.append(walk_face(network.nodes, network.chains, half)[0])
                seen.update(found[-1])
    return found


def parts(network: Network) -> int:
    """How many connected parts it has, by a search of its own."""
    left = {("node", k) for k in network.nodes}
    left |= {("chain", k) for k in network.chains}
    count = 0
    while left:
        count += 1
        stack = [left.pop()]
        while stack:
            kind, k = stack.pop()
            if kind == "node":
                beside = {("chain", half >> 1) for half in network.nodes[k].ends}
            else:
                ends = {network.chains[k].start, network.chains[k].end} - {-1}
                beside = {("node", node) for node in ends}
            stack += beside & left
            left -= beside
    return count


def genus(network: Network) -> int:
    """By Euler's formula: 0 if the order of ends around all nodes is that of a drawing on a
    plane or sphere."""
    loose = sum(chain.is_closed_loop for chain in network.chains.values())
    euler = len(network.nodes) + loose - len(network.chains) + len(faces(network))
    assert (2 * parts(network) - euler) % 2 == 0
    return (2 * parts(network) - euler) // 2


def is_drawn_within(network: Network) -> bool:
    """Does no chain lie beyond a border, the seam, or another marked side?"""
    return all(
        bool(network.mark(one)) == bool(network.mark(two ^ 1))
        for node in network.nodes.values()
        for one, two in zip(node.ends, node.ends[1:] + node.ends[:1], strict=True)
        if not node.open
    )
