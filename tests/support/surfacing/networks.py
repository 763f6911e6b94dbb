"""Networks that several tests of sketching look at."""

from __future__ import annotations

import math

import numpy as np

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle


def faces_network(points: object, faces: list[list[int]]) -> CurveNetwork:
    """The network of a mesh's edges, with its faces as cycles."""
    number: dict[tuple[int, int], int] = {}
    for face in faces:
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            number.setdefault((min(a, b), max(a, b)), len(number))
    network = CurveNetwork.from_edges(np.asarray(points, float), list(number))
    cycles = tuple(
        Cycle(
            tuple(
                (number[min(a, b), max(a, b)], a > b)
                for a, b in zip(face, face[1:] + face[:1], strict=True)
            )
        )
        for face in faces
    )
    return CurveNetwork(network.curves, network.nodes, cycles)


def cube() -> CurveNetwork:
    """The twelve edges of the unit cube and its six faces, seen from outside."""
    points = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return faces_network(points, faces)


def prism() -> CurveNetwork:
    """The nine edges of a triangular prism and its five faces."""
    points = [[math.cos(a), math.sin(a), z] for z in (0, 1.5) for a in (0, 2.1, 4.2)]
    return faces_network(points, [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]])


def torus(m: int = 8, n: int = 6) -> CurveNetwork:
    """An m x n grid on a torus with its m n faces."""

    def at(i: int, j: int) -> list[float]:
        u, v = 2 * math.pi * i / m, 2 * math.pi * j / n
        r = 3 + math.cos(v)
        return [r * math.cos(u), r * math.sin(u), math.sin(v)]

    points = [at(i, j) for i in range(m) for j in range(n)]
    faces = [
        [i * n + j, (i + 1) % m * n + j, (i + 1) % m * n + (j + 1) % n, i * n + (j + 1) % n]
        for i in range(m)
        for j in range(n)
    ]
    return faces_network(points, faces)


def ring(points: object) -> CurveNetwork:
    """One closed curve through points (n, 3), which is its only cycle."""
    closed = np.asarray(points, float)
    closed = np.concatenate([closed, closed[:1]])
    curve = Curve(closed, (0, 0), "ring", "ring")
    return CurveNetwork((curve,), closed[:1], (Cycle(((0, False),)),))


def shuffled(network: CurveNetwork, seed: int) -> CurveNetwork:
    """The same network with its curves in another order, some walked the other way round, and
    its cycles from another curve on."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(network.curves))
    turned = rng.integers(0, 2, len(order)).astype(bool)
    curves = []
    place = {}
    for new, old in enumerate(order.tolist()):
        curve = network.curves[old]
        place[old] = (new, bool(turned[new]))
        if turned[new]:
            points = np.ascontiguousarray(curve.points[::-1])
            curve = Curve(points, curve.nodes[::-1], curve.id, curve.stroke)
        curves.append(curve)
    cycles = []
    for cycle in network.cycles:
        steps = [(place[c][0], backward != place[c][1]) for c, backward in cycle.steps]
        k = int(rng.integers(len(steps)))
        moved = Cycle(tuple(steps[k:] + steps[:k]))
        cycles.append(moved.turned if rng.integers(2) else moved)
    return CurveNetwork(tuple(curves), network.nodes, tuple(cycles))
