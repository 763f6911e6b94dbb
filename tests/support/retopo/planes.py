"""Patches drawn in the plane, as networks on the surface."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network import AtNode, Network, NetworkBuilder
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tracing import SurfaceCurve
from tests.support.retopo.surfaces import grid

#: Of the cases in the plane.
SIZES = Sizes(snap=0.25, spine=1.0, autocompletion=1.0, brush=1.0, edge=0.5, sampling=0.05)


@cache
def plane_surface(half: float = 8.0, spacing: float = 0.1) -> Surface:
    """A square of the plane z = 0 around the origin, seen from above; its grid is jittered, so
    that nothing lies along it."""
    n = round(2 * half / spacing)
    flat, faces = grid(n, n, spacing, 7, (-half, -half))
    return Surface.from_arrays(np.c_[flat, np.zeros(len(flat))], faces).orient()


def line(*corners: tuple[float, float], spacing: float = 0.05) -> np.ndarray:
    """(n, 3) points of the plane along a polyline."""
    found = [np.array([corners[0]], np.float64)]
    for a, b in pairwise(corners):
        n = max(1, round(float(np.hypot(b[0] - a[0], b[1] - a[1])) / spacing))
        found.append(np.array(a) + np.arange(1, n + 1)[:, None] / n * np.subtract(b, a))
    points = np.concatenate(found)
    return np.c_[points, np.zeros(len(points))]


def up(points: np.ndarray) -> np.ndarray:
    """(n, 3) normals of the plane."""
    return np.tile([0.0, 0.0, 1.0], (len(points), 1))


def stroke(*corners: tuple[float, float]) -> SurfaceCurve:
    points = line(*corners)
    return SurfaceCurve(points, up(points), False)


def polygons(*drawn: list[tuple[float, float, bool]]) -> Network:
    """Patches in the plane: each a polygon, counter-clockwise, True at its corners.

    Corners at one place are one node; sides between the same two nodes are not shared.
    """
    builder = NetworkBuilder(Network())
    nodes: dict[tuple[float, float], int] = {}
    for polygon in drawn:
        first = next(k for k, (_, _, corner) in enumerate(polygon) if corner)
        around = polygon[first:] + polygon[: first + 1]
        side = [around[0][:2]]
        for x, y, corner in around[1:]:
            side.append((x, y))
            if corner:
                points = line(*side)
                for end in (side[0], side[-1]):
                    if end not in nodes:
                        nodes[end] = builder.add_node([*end, 0.0], [0.0, 0.0, 1.0])
                builder.add_chain(
                    points, up(points), AtNode(nodes[side[0]]), AtNode(nodes[side[-1]])
                )
                side = [(x, y)]
    return builder.finish()


def corners_of(network: Network, patch: int) -> np.ndarray:
    """(k, 2) the corners of a patch of the plane."""
    found = network.patches[patch]
    nodes = [network.origin(found.loop[k]) for k in found.corners]
    return np.array([network.nodes[node].point[:2] for node in nodes])


def t_junctions(network: Network, patch: int) -> list[tuple[float, float]]:
    """Nodes within the sides of a patch of the plane."""
    found = network.patches[patch]
    inner = [half for k, half in enumerate(found.loop) if k not in found.corners]
    points = [network.nodes[network.origin(half)].point for half in inner]
    return [(float(p[0]), float(p[1])) for p in points]
