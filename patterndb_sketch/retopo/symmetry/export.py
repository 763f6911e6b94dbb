"""The mesh of a half together with its image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.filling.meshing import RetopoMesh, open_edges
from patterndb_sketch.retopo.network import NONE, SYMMETRY, Network
from patterndb_sketch.retopo.symmetry.plane import Plane


@dataclass(frozen=True, slots=True, eq=False)
class MirroredMesh:
    """A mesh of quads that is its own image.

    mesh:     of both halves: the quads of the half first, then their images. A vertex or quad
              of the image has the node, chain and patch of what it is the image of.
    image:    (v,) int32, the vertex that is a vertex's image; on the seam it is itself.
    pinched:  (e, 2) int32, edges beside the seam whose two ends are on it: they and their images
              are one edge, of four quads. More edges along the curves there mend it.
    """

    mesh: RetopoMesh
    image: Int32Array
    pinched: Int32Array


def mirrored(half: RetopoMesh, network: Network, plane: Plane) -> MirroredMesh:
    """The mesh of a half and its image, welded where the network has a seam, never by distance.

    half: of ``network``, as welded. Vertices on the seam are moved exactly onto the plane, from
    where rounding has left them; all others and their images are mirror images by arithmetic,
    and exactly so for the planes x, y or z = 0. Quads of the image are turned over.

    Differs from the program of Takayama et al. 2013, which welds what is near to the plane: a
    vertex that only comes near stays its own.
    """
    seam = seam_vertices(half, network)
    n, extra = len(half.vertices), int((~seam).sum())
    image = np.empty(n + extra, np.int32)
    image[:n][seam] = np.flatnonzero(seam)
    image[:n][~seam] = np.arange(n, n + extra)
    image[n:] = np.flatnonzero(~seam)
    points, normals = half.vertices.copy(), half.normals.copy()
    points[seam] = plane.flattened(points[seam])
    normals[seam] = plane.flattened_normals(normals[seam])
    both = RetopoMesh(
        np.concatenate([points, plane.mirrored(points[~seam])]),
        np.concatenate([normals, plane.mirrored_directions(normals[~seam])]),
        np.concatenate([half.quads, image[half.quads[:, ::-1]]]).astype(np.int32),
        np.concatenate([half.patch, half.patch]),
        np.concatenate([half.node, half.node[~seam]]),
        np.concatenate([half.chain, half.chain[~seam]]),
    )
    return MirroredMesh(both, image, _pinched(half, seam))


def seam_vertices(half: RetopoMesh, network: Network) -> np.ndarray:
    """(v,) bool: is a vertex of the half on a chain that is marked as the seam, or at its end?"""
    chains = [chain for chain in network.chains.values() if SYMMETRY in chain.marks]
    nodes = {node for chain in chains for node in (chain.start, chain.end)} - {NONE}
    return np.isin(half.chain, [chain.id for chain in chains]) | np.isin(half.node, sorted(nodes))


def _pinched(half: RetopoMesh, seam: np.ndarray) -> Int32Array:
    """(e, 2) inner edges of the half with both ends on the seam."""
    tail, head = half.quads.ravel(), np.roll(half.quads, -1, axis=1).ravel()
    both = seam[tail] & seam[head]
    edges = np.unique(np.sort(np.stack([tail[both], head[both]], axis=1), axis=1), axis=0)
    rim = {(min(a, b), max(a, b)) for a, b in open_edges(half).tolist()}
    inner = [edge for edge in edges.tolist() if tuple(edge) not in rim]
    return np.array(inner, np.int32).reshape(-1, 2)
