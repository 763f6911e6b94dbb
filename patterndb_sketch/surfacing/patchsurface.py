"""The patches of a surface as triangles, to be drawn and pointed at, and a tint for every piece."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.surfacing.patch import Surfacing, as_triangles

#: Tints that pieces are given, those of a palette.
N_TINTS = 8

#: What a tint costs a piece beside one that has it, and two steps from one that has it; each
#: piece that has it anywhere costs 1.
BESIDE, NEARBY = 1_000_000, 50


def choose_piece_tints(
    pieces: Sequence[Int64Array], owners: Sequence[int], kept: Mapping[int, int] | None = None
) -> Int64Array:
    """Choose (p,) the tint of every piece, 0 to N_TINTS - 1.

    pieces: the faces (f, 3) or (f, 4) of each, of common vertices. owners: the patch of each;
    the first piece of every patch is served before the others. kept: tints that pieces have
    already: they are kept as far as neighbours allow, so that a picture keeps its colours when
    it changes.
    """
    beside = find_neighbours(pieces)
    before = {} if kept is None else kept
    seen: set[int] = set()
    firsts = [piece for piece, own in enumerate(owners) if own not in seen and not seen.add(own)]
    order = sorted(range(len(pieces)), key=lambda piece: (piece not in before, piece not in firsts))
    tint = np.full(len(pieces), -1, np.int64)
    used = np.zeros(N_TINTS, np.int64)
    for piece in order:
        cost = used.copy()
        for near in beside[piece]:
            if tint[near] >= 0:
                cost[tint[near]] += BESIDE
            for far in beside[near]:
                if tint[far] >= 0:
                    cost[tint[far]] += NEARBY
        best = int(cost.argmin())
        wanted = before.get(piece, best)
        tint[piece] = wanted if cost[wanted] < BESIDE else best
        used[tint[piece]] += 1
    return tint


def find_neighbours(pieces: Sequence[Int64Array]) -> list[set[int]]:
    """Find for every piece those that share an edge with it, chords and curves alike."""
    keys: list[Int64Array] = [np.zeros((0, 2), np.int64)]
    names: list[Int64Array] = [np.zeros(0, np.int64)]
    for name, faces in enumerate(pieces):
        ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        around = np.unique(np.sort(ends, axis=1), axis=0)
        keys.append(around)
        names.append(np.full(len(around), name))
    key, name = np.concatenate(keys), np.concatenate(names)
    order = np.lexsort((name, key[:, 1], key[:, 0]))
    key, name = key[order], name[order]
    beside: list[set[int]] = [set() for _ in pieces]
    # More than two patches may meet along a curve.
    start = 0
    cuts = np.flatnonzero((key[1:] != key[:-1]).any(axis=1)) + 1
    for end in (*cuts.tolist(), len(key)):
        meeting = name[start:end].tolist()
        for one in meeting:
            beside[one].update(other for other in meeting if other != one)
        start = end
    return beside


@dataclass(frozen=True, slots=True, eq=False)
class PatchSurface:
    """All patches of a surface.

    corners: (t, 3, 3) float64 triangles; normals: (t, 3, 3) at their corners, smooth within a
             piece. tints: (t,) the tint of each. owners: (t,) the patch of each.
    edges:   (e, 2, 3) the edges of faces, each once. chords: (c, 2, 3).
    surface: the same triangles, to cast rays at.
    tint_of: for every patch the tints of its pieces.
    """

    corners: Points
    normals: Points
    tints: Int64Array
    owners: Int64Array
    edges: Points
    chords: Points
    surface: Surface
    tint_of: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, made: Surfacing, kept: Mapping[int, tuple[int, ...]]) -> PatchSurface:
        """Of a surface; kept: tints that the pieces of some of its patches had before."""
        pieces = [piece for patch in made.patches for piece in patch.faces]
        owners = [i for i, patch in enumerate(made.patches) for _ in patch.faces]
        starts = np.cumsum([0, *(len(patch.faces) for patch in made.patches)]).tolist()
        before = {
            starts[patch] + i: tint
            for patch, tints in kept.items()
            for i, tint in enumerate(tints[: len(made.patches[patch].faces)])
        }
        tints = choose_piece_tints(pieces, owners, before)
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
            surface=Surface(made.points, triangles.astype(np.int32)),
            tint_of=tuple(tuple(tints[a:b].tolist()) for a, b in pairwise(starts)),
        )

    def middle(self, patch: int) -> Points | None:
        """(3,) a point of a patch near its middle; None if it has no faces."""
        mine = self.owners == patch
        if not mine.any():
            return None
        centres = self.corners[mine].mean(axis=1)
        return centres[np.linalg.norm(centres - centres.mean(axis=0), axis=1).argmin()]


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
