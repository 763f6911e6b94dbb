"""Quad meshes to take apart, and what holds of every one that was."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.filling import has_suitable_fill, weld_patches
from patterndb_sketch.retopo.network import BORDER, check_network
from patterndb_sketch.retopo.quadgrids import check_quads, mark_separatrices
from patterndb_sketch.retopo.quadimport import QuadImport

Mesh = tuple[Points, Int32Array]


def cube(k: int) -> Mesh:
    """A cube of k x k quads on each side."""
    number: dict[tuple[int, ...], int] = {}
    quads: list[list[int]] = []
    for axis in range(3):
        for level in (0, k):
            for i in range(k):
                for j in range(k):
                    quad: list[int] = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at = [0, 0, 0]
                        at[axis], at[axis - 2], at[axis - 1] = level, i + di, j + dj
                        quad.append(number.setdefault(tuple(at), len(number)))
                    quads.append(quad if level else quad[::-1])
    return np.array(list(number), float) / k, np.array(quads, np.int32)


def torus(a: int, b: int, shift: int = 0) -> Mesh:
    """Closed, all valences 4; going round the tube once leads ``shift`` further."""

    def at(i: int, j: int) -> int:
        return (i + j // b * shift) % a * b + j % b

    quads = [
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(a) for j in range(b)
    ]
    u, v = np.divmod(np.arange(a * b), b)
    u, v = 2 * np.pi * (u / a + shift * v / (a * b)), 2 * np.pi * v / b
    out = 2.0 + np.cos(v)
    points = np.stack([out * np.cos(u), out * np.sin(u), np.sin(v)], axis=1)
    return points, np.array(quads, np.int32)


def tube(a: int, b: int) -> Mesh:
    """A ring of a x b quads with two borders."""
    u, v = np.divmod(np.arange(a * (b + 1)), b + 1)
    angle = 2 * np.pi * u / a
    points = np.stack([(1 + v) * np.cos(angle), (1 + v) * np.sin(angle), 0.0 * v], axis=1)
    quads = [
        [
            i * (b + 1) + j,
            i * (b + 1) + j + 1,
            (i + 1) % a * (b + 1) + j + 1,
            (i + 1) % a * (b + 1) + j,
        ]
        for i in range(a)
        for j in range(b)
    ]
    return points, np.array(quads, np.int32)


def cycles(quads: NDArray[np.integer]) -> list[tuple[int, ...]]:
    """The quads, each from its lowest vertex on, in order."""
    first = quads.argmin(axis=1)[:, None]
    return sorted(map(tuple, np.take_along_axis(quads, (first + np.arange(4)) % 4, 1).tolist()))


def is_again(found: QuadImport, mesh: Mesh) -> None:
    """The welded mesh is the one imported: the same vertices, bit for bit, and the same quads."""
    points, quads = mesh
    made = weld_patches(found.filled)
    rows = np.concatenate(
        [found.vertex[p][found.filled.placed[p].quads] for p in sorted(found.filled.placed)]
    )
    name = np.full(len(made.vertices), -1)
    name[made.quads] = rows
    # One vertex of the mesh for each, and each of the mesh's once.
    assert (name[made.quads] == rows).all()
    assert sorted(name.tolist()) == np.unique(quads).tolist()
    assert made.vertices.tobytes() == np.ascontiguousarray(points[name]).tobytes()
    assert cycles(name[made.quads]) == cycles(quads)


def marked_edges(mesh: Mesh) -> set[frozenset[int]]:
    """The edges on separatrices of a mesh that has irregular vertices in every part, with sets of
    edges and nothing else."""
    _, quads = mesh
    around: dict[int, list[tuple[int, ...]]] = {}
    beside: dict[frozenset[int], int] = {}
    for quad in map(tuple, quads.tolist()):
        for a, b in pairwise((*quad, quad[0])):
            around.setdefault(a, []).append(quad)
            beside[frozenset((a, b))] = beside.get(frozenset((a, b)), 0) + 1
    border = {v for edge, uses in beside.items() if uses == 1 for v in edge}
    edges: dict[int, set[int]] = {}
    for edge in beside:
        a, b = edge
        edges.setdefault(a, set()).add(b)
        edges.setdefault(b, set()).add(a)
    irregular = {v for v, at in edges.items() if len(at) != (3 if v in border else 4)}
    marked = {edge for edge, uses in beside.items() if uses == 1}
    for start in irregular:
        for first in edges[start]:
            one, two = start, first
            marked.add(frozenset((one, two)))
            while two not in irregular and two not in border:
                # Straight ahead: the neighbour that shares no quad with the edge.
                (ahead,) = [
                    v
                    for v in edges[two] - {one}
                    if not any(one in quad and v in quad for quad in around[two])
                ]
                one, two = two, ahead
                marked.add(frozenset((one, two)))
    return marked


def holds(found: QuadImport, mesh: Mesh) -> None:
    """What always holds: the network's invariants, patches of four sides of one chain, T never,
    counts as they were, irregular vertices at nodes."""
    network = found.network
    check_network(network)
    for patch in network.patches.values():
        assert patch.corners == (0, 1, 2, 3)
        assert len(patch.loop) == 4
        assert has_suitable_fill(network, patch)
        assert not any(network.mark(half) for half in patch.loop)
    for node in network.nodes.values():
        outside = [h for h in node.ends if network.mark(h) == BORDER]
        assert node.corner_flags.count(False) == len(outside) <= 1
    # Every quad is in one patch.
    assert sum(len(placed.quads) for placed in found.filled.placed.values()) == len(mesh[1])
    checked = check_quads(*mesh)
    irregular = mesh[0][checked.irregular]
    places = {node.point.tobytes() for node in network.nodes.values()}
    assert {point.tobytes() for point in irregular} <= places
    marked, _ = mark_separatrices(checked)
    assert sum(chain.count for chain in network.chains.values()) == len(
        {frozenset(e) for e in edges_of(mesh[1])[marked].tolist()}
    )
    is_again(found, mesh)


def edges_of(quads: Int32Array) -> Int32Array:
    """(4q, 2) the ends of every half-edge."""
    return np.stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()], axis=1)


def thirds(points: Points, triangles: NDArray[np.integer]) -> Mesh:
    """Every triangle as three quads, from its middle and the middles of its edges."""
    all_points = list(map(tuple, points.tolist()))
    number: dict[tuple[float, ...], int] = {p: k for k, p in enumerate(all_points)}

    def middle(*corners: int) -> int:
        at = tuple(np.mean([all_points[c] for c in sorted(corners)], axis=0).tolist())
        if at not in number:
            number[at] = len(all_points)
            all_points.append(at)
        return number[at]

    quads: list[list[int]] = []
    for a, b, c in triangles.tolist():
        m = middle(a, b, c)
        for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
            quads.append([v, middle(v, w), m, middle(u, v)])
    return np.array(all_points), np.array(quads, np.int32)


def refined(points: Points, quads: Int32Array, times: int) -> Mesh:
    """Every quad as four, so many times."""
    for _ in range(times):
        ends = np.sort(edges_of(quads), axis=1)
        edges, which = np.unique(ends, axis=0, return_inverse=True)
        on = (len(points) + which.reshape(-1, 4)).astype(np.int32)
        inside = len(points) + len(edges) + np.arange(len(quads), dtype=np.int32)
        new = np.concatenate([points, points[edges].mean(axis=1), points[quads].mean(axis=1)])
        parts = [np.stack([quads[:, e], on[:, e], inside, on[:, e - 1]], axis=1) for e in range(4)]
        points, quads = new, np.concatenate(parts).astype(np.int32)
    return points, quads
