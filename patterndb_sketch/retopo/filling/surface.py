"""The quads of a filled network as triangles, to be drawn and pointed at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.filling.mesh import (
    FilledNetwork,
    RetopoMesh,
    find_irregular_vertices,
    find_open_edges,
)
from patterndb_sketch.retopo.filling.report import cut_fans

#: A point this near to a quad, in median edges, is on it.
ON = 0.75

#: What of the surface is this near to a quad, in median edges, is below it: coarse quads are far
#: from what is round.
UNDER = 1.5

#: What is nearest to an edge of a quad is below the quads if it is this near, in median edges.
RIM = 0.2

#: The owner of what is drawn and of no patch.
NO_PATCH = -1


@dataclass(frozen=True, slots=True, eq=False)
class FilledSurface:
    """All quads as triangles, with what lies on them.

    mesh:    what they are of, as it is saved.
    corners: (t, 3, 3) triangles, the two halves of a quad one after another, then those of faces
             that were given. normals: (t, 3, 3) there.
    owner:   (t,) int32, the patch of each, -1 for such faces. sides: (t,) int32, how many sides it
             has, 0 for such faces.
    flipped: (t,) bool, is its quad clockwise, or does it cross itself?
    edges:   (e, 2, 3) edges of the faces, up: (e, 2, 3) normals there, of: (e,) their patch.
             rims: (e,) bool, does the patch have it once? Such edges lie along its curves.
    irregular: (k,) int32 vertices not of 4 quads, but for those on open borders; valences: (k,).
    rim:     (k,) int32, one of the patches around each.
    edge:    median length of an edge, 0 without quads.
    under:   (v,) int32, the patch that lies on each vertex of the surface, -1 for none.
    """

    mesh: RetopoMesh
    corners: Points
    normals: Points
    owner: Int32Array
    sides: Int32Array
    flipped: NDArray[np.bool_]
    edges: Points
    up: Points
    of: Int32Array
    rims: NDArray[np.bool_]
    irregular: Int32Array
    valences: Int32Array
    rim: Int32Array
    edge: float
    under: Int32Array
    _surface: Surface | None
    _sound: NDArray[np.int64]

    @classmethod
    def from_filled(cls, found: FilledNetwork, surface: Surface, mesh: RetopoMesh) -> FilledSurface:
        """Cut the quads of a filled network on a surface.

        mesh: all its quads, with their images if there are any.
        """
        quads, at = mesh.quads, mesh.vertices
        # Along the shorter diagonal: a bent quad is nearer to the surface so.
        corner = at[quads]
        one = np.linalg.norm(corner[:, 0] - corner[:, 2], axis=1)
        two = np.linalg.norm(corner[:, 1] - corner[:, 3], axis=1)
        first = (one <= two)[:, None, None]
        cut = np.where(
            first, quads[:, [[0, 1, 2], [0, 2, 3]]], quads[:, [[0, 1, 3], [1, 2, 3]]]
        ).reshape(-1, 3)
        kept = cut_fans(mesh.kept)
        cut = np.concatenate([cut, kept])
        owner = np.concatenate([np.repeat(mesh.patch, 2), np.full(len(kept), NO_PATCH, np.int32)])
        counts = {p: len(found.network.patches[p].corners) for p in found.placed}
        counts[NO_PATCH] = 0
        sides = np.array([counts[p] for p in owner.tolist()], np.int32)
        tail, head = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
        pairs = np.stack([tail, head], axis=1)
        named = np.concatenate([np.repeat(mesh.patch, 4)[:, None], pairs], axis=1)
        given = [(NO_PATCH, face[k - 1], face[k]) for face in mesh.kept for k in range(len(face))]
        named = np.concatenate([named, np.array(given, np.int64).reshape(-1, 3)])
        named[:, 1:].sort(axis=1)
        named, uses = np.unique(named, axis=0, return_counts=True)
        pairs = named[:, 1:]
        wrong, valences = find_irregular_vertices(mesh)
        border = np.zeros(len(at), np.bool_)
        border[find_open_edges(mesh).ravel()] = True
        inside = ~border[wrong]
        wrong, valences = wrong[inside], valences[inside]
        around = np.zeros(len(at), np.int32)
        around[quads.ravel()] = np.repeat(mesh.patch, 4)
        lengths = np.linalg.norm(at[tail] - at[head], axis=1)
        edge = float(np.median(lengths)) if len(lengths) else 0.0
        area = np.cross(at[cut[:, 1]] - at[cut[:, 0]], at[cut[:, 2]] - at[cut[:, 0]])
        sound = np.flatnonzero(np.linalg.norm(area, axis=1) > 0.0)
        cover = Surface.from_arrays(at, cut[sound]) if len(sound) else None
        return cls(
            mesh,
            at[cut],
            mesh.normals[cut],
            owner.astype(np.int32),
            sides,
            np.pad(np.repeat(_flipped(found, len(quads)), 2), (0, len(kept))),
            at[pairs],
            mesh.normals[pairs],
            named[:, 0].astype(np.int32),
            uses == 1,
            wrong,
            valences,
            around[wrong],
            edge,
            _under(surface, cover, owner[sound], edge),
            cover,
            sound,
        )

    def patch_at(self, point: Points) -> int | None:
        """Return the patch whose quads a point (3,) of the surface is on."""
        found = self._find_triangle(point)
        return None if found is None else int(self.owner[found])

    def quad_at(self, point: Points) -> int | None:
        """Return the quad of the mesh that a point (3,) of the surface is on."""
        found = self._find_triangle(point)
        return None if found is None else found // 2

    def point_in(self, patch: int) -> Points | None:
        """Return a point (3,) within a patch that has quads, near its middle; None without."""
        own = np.flatnonzero(self.owner == patch)
        if not len(own):
            return None
        middles = self.corners[own].mean(axis=1)
        return middles[int(np.linalg.norm(middles - middles.mean(axis=0), axis=1).argmin())]

    def _find_triangle(self, point: Points) -> int | None:
        """Which triangle of a quad a point (3,) of the surface is on."""
        if self._surface is None:
            return None
        foot = self._surface.nearest(point[None])
        if np.linalg.norm(foot.points[0] - point) > ON * self.edge:
            return None
        at = int(self._sound[foot.triangles[0]])
        return None if self.owner[at] == NO_PATCH else at


def _flipped(found: FilledNetwork, count: int) -> NDArray[np.bool_]:
    """(count,) which quads of the network's mesh are flipped; images come after all others."""
    placed = [found.placed[patch] for patch in sorted(found.placed)]
    own = [np.isin(np.arange(len(one.quads)), one.flipped) for one in placed]
    flags = np.concatenate([np.zeros(0, np.bool_), *own])
    return np.resize(flags, count)


def _under(surface: Surface, cover: Surface | None, owner: Int32Array, edge: float) -> Int32Array:
    """See :class:`FilledSurface`; owner: of its triangles."""
    under = np.full(len(surface.vertices), -1, np.int32)
    if cover is None:
        return under
    reach = UNDER * edge
    low, high = cover.vertices.min(axis=0) - reach, cover.vertices.max(axis=0) + reach
    near = ((surface.vertices >= low) & (surface.vertices <= high)).all(axis=1)
    near = np.flatnonzero(near)
    feet = cover.nearest(surface.vertices[near])
    away = np.linalg.norm(feet.points - surface.vertices[near], axis=1)
    agree = np.einsum("nc,nc->n", feet.normals, surface.normals[near]) > 0.0
    # What lies off the rim of all quads is nearest to an edge of theirs.
    inside = (away <= reach) & agree & ((feet.weights.min(axis=1) > 1e-6) | (away < RIM * edge))
    under[near[inside]] = owner[feet.triangles[inside]]
    return under
