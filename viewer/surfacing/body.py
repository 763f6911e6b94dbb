"""A surface made ready to be drawn and picked: triangles, lines and colours, whatever the view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.network import Cycle
from patterndb_sketch.surfacing.patch import Surfacing, as_triangles
from patterndb_sketch.surfacing.tessellation import Canvas
from viewer.surfacing.palette import piece_tints

#: A cycle's key: what two cycles that differ in start and sense only have in common.
Key = tuple[tuple[int, bool], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """All patches of a surface.

    corners: (t, 3, 3) float64 triangles; normals: (t, 3, 3) at their corners, smooth within a
             piece. tints: (t,) the tint of each. owners: (t,) the patch of each.
    edges:   (e, 2, 3) the edges of faces, each once. chords: (c, 2, 3).
    canvas:  what rays meet; its faces are the triangles.
    tint_of: for every patch the tints of its pieces.
    """

    corners: Points
    normals: Points
    tints: Int64Array
    owners: Int64Array
    edges: Points
    chords: Points
    canvas: Canvas
    tint_of: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, made: Surfacing, kept: Mapping[int, tuple[int, ...]]) -> Body:
        """Of a surface; kept: tints that the pieces of some of its patches had before."""
        pieces = [piece for patch in made.patches for piece in patch.faces]
        owners = [i for i, patch in enumerate(made.patches) for _ in patch.faces]
        starts = np.cumsum([0, *(len(patch.faces) for patch in made.patches)]).tolist()
        before = {
            starts[patch] + i: tint
            for patch, tints in kept.items()
            for i, tint in enumerate(tints[: len(made.patches[patch].faces)])
        }
        tints = piece_tints(pieces, owners, before)
        cut = [as_triangles([piece]) for piece in pieces]
        counts = [len(part) for part in cut]
        triangles = np.concatenate([np.zeros((0, 3), np.int64), *cut])
        lines = [patch.chords for patch in made.patches]
        return cls(
            corners=made.points[triangles],
            normals=_normals(made.points, triangles, np.repeat(np.arange(len(cut)), counts)),
            tints=np.repeat(tints, counts),
            owners=np.repeat(np.array(owners, np.int64), counts),
            edges=made.points[_edges(pieces)],
            chords=made.points[np.concatenate([np.zeros((0, 2), np.int64), *lines])],
            canvas=Canvas.of(made.points, triangles),
            tint_of=tuple(tuple(tints[a:b].tolist()) for a, b in pairwise(starts)),
        )

    def middle(self, patch: int) -> Points | None:
        """(3,) a point of a patch near its middle; None if it has no faces."""
        mine = self.owners == patch
        if not mine.any():
            return None
        centres = self.corners[mine].mean(axis=1)
        return centres[np.linalg.norm(centres - centres.mean(axis=0), axis=1).argmin()]


def renumbered(cycle: Cycle, number: Mapping[int, int]) -> Cycle | None:
    """The cycle with other numbers for its curves; None if one of them has none."""
    if not all(curve in number for curve in cycle.curves):
        return None
    return Cycle(tuple((number[curve], backward) for curve, backward in cycle.steps))


def _edges(pieces: list[Int64Array]) -> Int64Array:
    parts = [np.zeros((0, 2), np.int64)]
    for faces in pieces:
        parts.append(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2))
    return np.unique(np.sort(np.concatenate(parts), axis=1), axis=0)


def _normals(points: Points, triangles: Int64Array, piece: Int64Array) -> Points:
    """(t, 3, 3) normals at the corners: the mean of the piece's triangles there, by area."""
    at = points[triangles]
    own = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    name = piece[:, None] * len(points) + triangles
    corners, which = np.unique(name, return_inverse=True)
    total = np.zeros((len(corners), 3))
    np.add.at(total, which.reshape(-1), np.repeat(own, 3, axis=0))
    normals = total[which.reshape(triangles.shape)]
    size = np.linalg.norm(normals, axis=2, keepdims=True)
    return normals / np.where(size > 0.0, size, 1.0)
