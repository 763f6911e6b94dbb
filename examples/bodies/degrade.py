"""Bodies in the state in which models of cars are found: torn, doubled, turned and cluttered."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bodies.body import WELD, Body, Shape, shape
from bodies.clutter import exterior_parts, interior_parts
from bodies.coons import MIRROR, blended, cut, extended, grid_faces, shrunk
from bodies.layout import Layout, Piece, crowded, layout
from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.features.errors import InvalidFeatureError

#: What a triangle belongs to.
SURFACE, INTERIOR, EXTERIOR = 0, 1, 2

#: Edges of a piece that is meshed on its own: a share of the diagonal, and their count's bounds.
EDGE = 0.018
FEWEST, MOST = 3, 60

#: A piece of a torn mesh has its count of edges times a number in this range.
UNEVEN = (0.6, 1.5)


@dataclass(frozen=True, slots=True, eq=False)
class Mess:
    """Triangles as a file might bring them, not welded.

    points:    (v, 3) float64. triangles: (t, 3) int64.
    parts:     (t,) int64, the patch that a triangle comes from; patches share no vertices.
    kinds:     (t,) int64: SURFACE, INTERIOR or EXTERIOR clutter.
    reach:     how far vertices of the surface lie from the clean body at most, in metres, beside
               the sagitta of its edges.
    flipped:   (parts,) bool, the patches that are turned inside out.
    """

    points: Points = field(repr=False)
    triangles: Int64Array = field(repr=False)
    parts: Int64Array = field(repr=False)
    kinds: Int64Array = field(repr=False)
    reach: float
    flipped: NDArray[np.bool_] = field(repr=False)


def degrade(
    body: Body,
    seed: int = 0,
    *,
    uneven: bool = False,
    cuts: int = 1,
    gaps: float = 0.0,
    crossings: float = 0.0,
    flips: float = 0.0,
    interior: bool = False,
    exterior: bool = False,
    shuffle: bool = False,
    mirror: bool = True,
) -> Mess:
    """The body as separate patches, with the faults that are asked for; its features stay true.

    uneven:    every patch is meshed on its own: vertices of neighbours do not meet along borders.
    cuts:      patches are cut into up to so many along their longer side.
    gaps:      patches end short of their borders, by up to half of this share of the diagonal.
    crossings: or reach beyond them, straight on, by up to this share. Of both, each side of a
               patch draws one.
    flips:     the share of patches that are turned inside out.
    interior:  seats, an engine, and inner shells. exterior: mirrors, handles, an aerial, wheels.
    shuffle:   every triangle with vertices of its own, in random order.
    mirror:    both halves, each with faults of its own, rather than the driver's.
    Raises InvalidFeatureError for shares that are negative or would leave no patch.
    """
    if cuts < 1 or not 0.0 <= flips <= 1.0:
        raise InvalidFeatureError(f"cuts {cuts} must be 1 or more, flips {flips} from 0 to 1")
    if not 0.0 <= gaps <= 0.01 or not 0.0 <= crossings <= 0.02:
        raise InvalidFeatureError(
            f"gaps {gaps} must be 0 to 0.01 of the diagonal, crossings {crossings} 0 to 0.02"
        )
    rng = np.random.default_rng(seed)
    made = shape(body.car)
    plan = layout(made.outline, body.resolution)
    gap, crossing = gaps * body.diagonal / 2.0, crossings * body.diagonal
    grids: list[Points] = []
    kinds: list[int] = []
    signs = (1.0, -1.0) if mirror else (1.0,)
    for side in signs:
        for piece in plan.pieces:
            count = 1 if not uneven else float(rng.uniform(*UNEVEN))
            patch = _meshed(made, plan, piece, uneven, EDGE * body.diagonal / count)
            for part in _cut(patch, int(rng.integers(1, cuts + 1)), rng):
                torn = _torn(part, gap, crossing, rng)
                # A mirror image is turned inside out: its rows run the other way.
                grids.append(torn if side > 0.0 else torn[::-1] * MIRROR)
                kinds.append(SURFACE)
    plain = [(_flat(one), grid_faces(*one.shape[:2])) for one in grids]
    for wanted, kind, maker in (
        (interior, INTERIOR, interior_parts), (exterior, EXTERIOR, exterior_parts)
    ):  # fmt: skip
        for points, faces in maker(body) if wanted else ():
            for sign in signs:
                plain.append((points, faces) if sign > 0 else (points * MIRROR, faces[:, ::-1]))
                kinds.append(kind)
    flipped = rng.random(len(plain)) < flips
    return _joined(plain, kinds, flipped, 2.0 * crossing, rng if shuffle else None)


def _meshed(made: Shape, plan: Layout, piece: Piece, uneven: bool, edge: float) -> Points:
    """(n, m, 3) grid of a piece, counter-clockwise from outside: with the samples of the clean
    body, or with its own."""
    sides = (piece.bottom, piece.right, piece.top, piece.left)
    if not uneven:
        parameters = blended(*(one.path(plan.along(one)) for one in sides))
    else:
        lengths: list[float] = []
        for one in sides:
            t = one.start + np.linspace(0.0, 1.0, 33) * (one.end - one.start)
            points = made.outline.surfaces[piece.surface](one.path(t))
            lengths.append(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()))
        n, m = (
            int(np.clip(round(max(pair) / edge), FEWEST, MOST))
            for pair in ((lengths[0], lengths[2]), (lengths[1], lengths[3]))
        )
        steps = [crowded(k, True, True) for k in (n, m, n, m)]
        parameters = blended(*(
            one.path(one.start + t * (one.end - one.start))
            for one, t in zip(sides, steps, strict=True)
        ))  # fmt: skip
    grid = made.at(piece.surface, parameters)
    grid[np.abs(grid[..., 1]) < WELD, 1] = 0.0
    return grid if made.outline.surfaces[piece.surface].outward > 0.0 else grid[::-1]


def _cut(patch: Points, parts: int, rng: np.random.Generator) -> list[Points]:
    """The patch cut into parts along its longer side, at random lines of its grid."""
    sizes = [float(np.linalg.norm(patch[-1, 0] - patch[0, 0])),
             float(np.linalg.norm(patch[0, -1] - patch[0, 0]))]  # fmt: skip
    axis = int(np.argmax(sizes))
    # Every part keeps two cells, so that it can be shrunk.
    places = np.arange(2, patch.shape[axis] - 2, 2)
    chosen = np.sort(rng.choice(places, min(parts - 1, len(places)), replace=False))
    bounds = [0, *chosen.tolist(), patch.shape[axis] - 1]
    return [patch[a : b + 1] if axis == 0 else patch[:, a : b + 1] for a, b in pairwise(bounds)]


def _torn(patch: Points, gap: float, crossing: float, rng: np.random.Generator) -> Points:
    """The patch with each of its four sides moved in or out."""
    if gap == 0.0 and crossing == 0.0:
        return patch
    out = rng.random(4) < 0.5 if gap and crossing else np.full(4, crossing > 0.0)
    amounts = rng.uniform(0.3, 1.0, 4)
    for side in range(4):
        turned = np.rot90(patch, side, axes=(0, 1))
        if out[side]:
            turned = extended(turned, amounts[side] * crossing)
        else:
            turned = shrunk(turned, amounts[side] * gap)
        patch = np.rot90(turned, -side, axes=(0, 1))
    return patch


def _flat(grid: Points) -> Points:
    return grid.reshape(-1, 3)


def _joined(
    plain: list[tuple[Points, Int64Array]],
    kinds: list[int],
    flipped: NDArray[np.bool_],
    reach: float,
    rng: np.random.Generator | None,
) -> Mess:
    points: list[Points] = []
    triangles: list[Int64Array] = []
    offset = 0
    for (at, faces), turn in zip(plain, flipped, strict=True):
        three = faces if faces.shape[1] == 3 else cut(at, faces)
        triangles.append(offset + (three[:, ::-1] if turn else three))
        points.append(at)
        offset += len(at)
    parts = np.repeat(np.arange(len(plain)), [len(one) for one in triangles])
    every, corners = np.concatenate(points), np.concatenate(triangles)
    if rng is not None:
        order = rng.permutation(len(corners))
        turns = rng.integers(0, 3, len(corners))[:, None]
        corners = np.take_along_axis(corners[order], (np.arange(3) + turns) % 3, axis=1)
        parts = parts[order]
        every, corners = every[corners.ravel()], np.arange(3 * len(corners)).reshape(-1, 3)
    return Mess(every, corners, parts, np.array(kinds)[parts], reach, flipped)
