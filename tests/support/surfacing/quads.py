"""Networks filled with quads and with triangles, for the tests of the bridge between them."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.store import Database
from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing.quads import QuadPatch, count_even_edges, fill_with_quads
from patterndb_sketch.surfacing.sampling import (
    Loop,
    Sampling,
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import minimal_area, tessellate_patch


def loops(network: CurveNetwork, spacing: float) -> tuple[Sampling, list[Loop]]:
    """The even loops of a network's cycles."""
    edges = count_even_edges(network, network.cycles, spacing).edges
    sampling = sample(network, spacing, edges)
    return sampling, [loop_of(network, sampling, cycle) for cycle in network.cycles]


def filled(db: Database, loop: Loop, smooth: bool, spacing: float) -> tuple[Int64Array, QuadPatch]:
    """The triangles of a loop's patch, of least area or smooth, and the quads on them."""
    if smooth:
        none = np.zeros((0, 2), np.int64)
        patch = tessellate_patch(loop, none, [range(len(loop.points))], spacing)
        triangles = np.concatenate(patch.faces)
        points = np.concatenate([loop.points, patch.points])
    else:
        triangles, points = minimal_area(loop.points)[0], loop.points
    return triangles, fill_with_quads(db, loop, points, triangles)


def together(
    sampling: Sampling, of: list[Loop], patches: list[QuadPatch]
) -> tuple[Points, Int64Array]:
    """One mesh of all patches: vertices on the network are shared."""
    points, quads = [sampling.points], []
    count = len(sampling.points)
    for loop, patch in zip(of, patches, strict=True):
        names = np.r_[loop.vertices, count + np.arange(len(patch.points))]
        quads.append(names[patch.quads])
        points.append(patch.points)
        count += len(patch.points)
    return np.concatenate(points), np.concatenate(quads)


def half_edges(faces: Int64Array) -> list[tuple[int, int]]:
    """(tail, head) of every half-edge."""
    ahead = np.roll(faces, -1, axis=1)
    return list(zip(faces.ravel().tolist(), ahead.ravel().tolist(), strict=True))


def euler(faces: Int64Array) -> int:
    """Vertices - edges + faces, of the vertices that are used."""
    edges = {(min(edge), max(edge)) for edge in half_edges(faces)}
    return len(np.unique(faces)) - len(edges) + len(faces)


def assert_disk_within(n: int, faces: Int64Array) -> None:
    """The faces are one disk, and its boundary is 0, 1, ..., n - 1 in this sense."""
    directed = half_edges(faces)
    assert len(set(directed)) == len(directed)
    border = {edge for edge in directed if edge[::-1] not in set(directed)}
    assert border == {(i, (i + 1) % n) for i in range(n)}
    assert euler(faces) == 1


def assert_closed(faces: Int64Array, characteristic: int) -> None:
    """Every edge has two faces, which agree about its sense; V - E + F is what it is to be."""
    directed = half_edges(faces)
    assert len(set(directed)) == len(directed)
    assert {(b, a) for a, b in directed} == set(directed)
    assert euler(faces) == characteristic
