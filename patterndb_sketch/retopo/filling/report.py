"""Report what a mesh of quads is like, how far it is from its surface, and what is left open."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.filling.mesh import (
    FilledNetwork,
    RetopoMesh,
    find_irregular_vertices,
    find_open_edges,
    weld_patches,
)
from patterndb_sketch.retopo.network import HalfChain, Network, walk_face

#: Samples along an edge of a quad, or of a triangle of the surface, for distances.
SAMPLES = 4


@dataclass(frozen=True, slots=True)
class Report:
    """Of a filled network.

    patches:   how many there are with so many corners. unfilled: how many have no quads.
    kept:      how many faces that were given, triangles and larger ones, have so many edges.
    irregular: how many vertices have so many faces where 4 inside, or 2 on the border, is regular.
    flipped:   quads clockwise seen from outside. open_edges: with one face. tangled: edges with
               more than two, or that two faces pass the same way. euler: vertices - edges + faces.
    to_surface, from_surface: greatest distance of the quads from the surface, and the reverse, as
               parts of the surface's diagonal.
    """

    patches: dict[int, int]
    unfilled: int
    vertices: int
    quads: int
    kept: dict[int, int]
    irregular: dict[int, int]
    flipped: int
    open_edges: int
    tangled: int
    euler: int
    to_surface: float
    from_surface: float


def report_mesh(found: FilledNetwork, surface: Surface, mesh: RetopoMesh | None = None) -> Report:
    """What the mesh of a filled network is like."""
    mesh = weld_patches(found) if mesh is None else mesh
    corners: dict[int, int] = {}
    for patch in found.network.patches.values():
        n = len(patch.corners)
        corners[n] = corners.get(n, 0) + 1
    _, valence = find_irregular_vertices(mesh)
    tail, head = mesh.list_sides()
    directed = (tail.astype(np.int64) << 32) | head
    low, high = np.minimum(tail, head).astype(np.int64), np.maximum(tail, head)
    edges, uses = np.unique((low << 32) | high, return_counts=True)
    twice = len(directed) - len(np.unique(directed))
    to_surface, from_surface = hausdorff(mesh.vertices, mesh.quads, surface, mesh.kept)
    return Report(
        patches=dict(sorted(corners.items())),
        unfilled=len(found.network.patches) - len(found.placed),
        vertices=len(mesh.vertices),
        quads=len(mesh.quads),
        kept=dict(sorted(Counter(map(len, mesh.kept)).items())),
        irregular={int(v): int((valence == v).sum()) for v in np.unique(valence)},
        flipped=sum(len(placed.flipped) for placed in found.placed.values()),
        open_edges=len(find_open_edges(mesh)),
        tangled=int((uses > 2).sum()) + twice,
        euler=len(mesh.vertices) - len(edges) + len(mesh.quads) + len(mesh.kept),
        to_surface=to_surface,
        from_surface=from_surface,
    )


@dataclass(frozen=True, slots=True)
class OpenLoop:
    """A loop without a patch. corners: of it. at: a point on it, with the surface's empty side
    on the left of the way to ``towards``."""

    corners: int
    at: tuple[float, float, float]
    towards: tuple[float, float, float]


def find_open_loops(network: Network) -> list[OpenLoop]:
    """The sides of curves where no patch is and one may be: what is left to be closed.

    One for each loop of half-chains; those around all of what was drawn are among them.
    """
    taken = network.patch_of()
    done: set[HalfChain] = set()
    found: list[OpenLoop] = []
    for chain in sorted(network.chains):
        for half in (2 * chain, 2 * chain + 1):
            if half in taken or half in done or network.mark(half):
                continue
            loop, corners = walk_face(network.nodes, network.chains, half)
            done.update(loop)
            line, _ = network.chains[chain].directed(half)
            k = len(line) // 2
            at, towards = (tuple(line[i].tolist()) for i in (k - 1, k))
            found.append(OpenLoop(len(corners), at, towards))
    return found


def hausdorff(
    vertices: Points,
    quads: np.ndarray,
    surface: Surface,
    others: Sequence[Sequence[int]] = (),
) -> tuple[float, float]:
    """The greatest distance from quads (q, 4) to the surface, and from the surface to the quads, as
    parts of the surface's diagonal; at samples.

    A quad is taken as the two triangles at its shorter diagonal, another face as a fan from its
    first vertex. Both 1.0 without quads.
    """
    if len(quads) == 0:
        return 1.0, 1.0
    triangles = np.concatenate([cut_quads(vertices, quads), cut_fans(others)])
    cover = Surface.from_arrays(vertices, triangles)
    there = _sample_triangles(cover.vertices[cover.triangles])
    out = float(np.linalg.norm(surface.nearest(there).points - there, axis=1).max())
    here = _sample_triangles(surface.vertices[surface.triangles])
    back = float(np.linalg.norm(cover.nearest(here).points - here, axis=1).max())
    return out / surface.diagonal, back / surface.diagonal


def cut_quads(vertices: Points, quads: np.ndarray) -> np.ndarray:
    """(2 q, 3) int32, quads (q, 4) cut along their shorter diagonals."""
    corner = vertices[quads]
    one = np.linalg.norm(corner[:, 0] - corner[:, 2], axis=1)
    two = np.linalg.norm(corner[:, 1] - corner[:, 3], axis=1)
    first = (one <= two)[:, None]
    return np.concatenate(
        [
            np.where(first, quads[:, [0, 1, 2]], quads[:, [0, 1, 3]]),
            np.where(first, quads[:, [0, 2, 3]], quads[:, [1, 2, 3]]),
        ]
    )


def cut_fans(faces: Sequence[Sequence[int]]) -> np.ndarray:
    """(t, 3) int32, faces cut into fans from their first vertices, one after another."""
    rows = [(face[0], b, c) for face in faces for b, c in pairwise(face[1:])]
    return np.array(rows, np.int32).reshape(-1, 3)


def _sample_triangles(corners: np.ndarray) -> Points:
    """Points all over triangles (t, 3, 3): corners, and even steps between."""
    weights = [
        (i / SAMPLES, j / SAMPLES, 1.0 - (i + j) / SAMPLES)
        for i in range(SAMPLES + 1)
        for j in range(SAMPLES + 1 - i)
    ]
    return np.concatenate([np.einsum("e,tec->tc", np.array(w), corners) for w in weights])
