"""What is to be painted of one disk, in flat coordinates: the same for paper and window."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.bundles import find_bundles
from patterndb.core.disk import Disk
from patterndb.core.halfedge import Int32Array
from patterndb.core.quadmesh import QuadMesh
from patterndb.geometry.embedding import embed_disk, frame_points
from patterndb.geometry.points import Points
from viewer.style import TINTS, parse_colour

#: Part of an edge that a polychord's band covers.
BAND = 0.44


@dataclass(frozen=True, slots=True, eq=False)
class StrokeMark:
    """A stroke that was asked for, in the numbers of a fill's vertices.

    ends:  (k, 2) int32 the boundary edges where it begins and ends; none for a loop.
    edges: (m, 2) int32 transversal edges of the strand that carries it, or none; a loop's first
           comes again at its end.
    """

    ends: Int32Array
    edges: Int32Array


@dataclass(frozen=True, slots=True)
class DiskDrawing:
    """A disk laid out, coordinates within -1 to 1.

    points:    (v, 2) float64; the boundary's come first, in order.
    quads:     (q, 4) int32.
    perimeter: number of boundary vertices.
    bands:     (b, 4, 2) float64 four-sided pieces of the polychords' bands, to be painted
               in order: where two cross, the crossing is a piece of its own.
    tints:     (b, 3) float64 their colours, 0 to 1.
    chosen:    (c, 4, 2) float64 pieces of the bundle picked out, if one is.
    convex, reflex: (n,) int32 corners.
    irregular: (i,) int32 irregular interior vertices; valences: (i,) int32 theirs.
    edge:      a typical edge's length, for the size of markers and lines.
    marks:     strokes that were asked for.
    """

    points: Points
    quads: NDArray[np.int32]
    perimeter: int
    bands: Points
    tints: Points
    chosen: Points
    convex: NDArray[np.int32]
    reflex: NDArray[np.int32]
    irregular: NDArray[np.int32]
    valences: NDArray[np.int32]
    edge: float
    marks: tuple[StrokeMark, ...] = ()


def draw_disk(
    disk: Disk,
    *,
    mirrored: bool = False,
    tinted: bool = True,
    choose: int | None = None,
    points: Points | None = None,
    marks: tuple[StrokeMark, ...] = (),
) -> DiskDrawing:
    """Lay a disk out for painting.

    mirrored: draw the mirror image. tinted: with the polychords' bands. choose: the bundle
    to pick out, numbered as :func:`patterndb.core.bundles.find_bundles` does; one there is not is
    ignored. points: (v, 2) where the vertices lie; None lays them out by the disk's corners.
    marks: of strokes.
    """
    points = embed_disk(disk) if points is None else frame_points(points)
    if mirrored:
        points = points * np.array([-1.0, 1.0])
    counts = disk.corner_counts()
    irregular = disk.irregular()
    corner = points[disk.quads]
    lengths = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    bands, tints = np.zeros((0, 4, 2)), np.zeros((0, 3))
    chosen = np.zeros((0, 4, 2))
    if tinted or choose is not None:
        bundle = find_bundles(disk)
        pieces = _pieces(corner)
        if choose is not None:
            chosen = pieces[:, :2][bundle == choose]
        if tinted:
            palette = np.array([parse_colour(t) for t in TINTS])
            own = palette[choose_tints(disk, bundle)[bundle]]
            over = _even(disk)[disk.quads[:, 0]]
            crossing = np.where(over[:, None], own[:, 0], own[:, 1])[:, None]
            bands = pieces.reshape(-1, 4, 2)
            tints = np.concatenate([own, crossing], axis=1).reshape(-1, 3)
    return DiskDrawing(
        points=points,
        quads=disk.quads,
        perimeter=disk.perimeter,
        bands=bands,
        tints=tints,
        chosen=chosen,
        convex=disk.corners[counts == 1],
        reflex=disk.corners[counts > 2],
        irregular=irregular,
        valences=disk.valence()[irregular],
        edge=float(np.median(lengths)),
        marks=marks,
    )


def _even(disk: Disk) -> NDArray[np.bool_]:
    """(v,) bool one of the two colours of the vertices: a disk of quads is bipartite.

    Every polychord meets quads whose first vertices' colours and sense alternate, so
    deciding by them which band lies on top makes bands go over and under like a weave.
    """
    even = np.zeros(disk.n_vertices, np.bool_)
    known = np.zeros(disk.n_vertices, np.bool_)
    known[0] = even[0] = True
    while not known.all():
        for k in range(4):
            here, there = disk.quads[:, k], disk.quads[:, (k + 1) % 4]
            for a, b in ((here, there), (there, here)):
                fresh = known[a] & ~known[b]
                even[b[fresh]] = ~even[a[fresh]]
                known[b[fresh]] = True
    return even


def _pieces(corner: Points) -> Points:
    """(q, 3, 4, 2) band through edges 0 and 2, band through 1 and 3, and where they cross."""
    low, high = 0.5 - BAND / 2.0, 0.5 + BAND / 2.0
    # Edge 0 runs along u at v = 0, edge 1 along v at u = 1.
    rows = (
        ((low, 0.0), (high, 0.0), (high, 1.0), (low, 1.0)),
        ((0.0, low), (1.0, low), (1.0, high), (0.0, high)),
        ((low, low), (high, low), (high, high), (low, high)),
    )
    uv = np.array(rows)
    u, v = uv[..., 0], uv[..., 1]
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    return np.einsum("bpc,qcd->qbpd", weights, corner)


# Which tint each polychord gets, so that parallel ones share it and crossing ones differ.
#
# An expanded pattern has bundles of parallel polychords where the pattern has one; tinting
# bundles, not polychords, lets a fill of 300 quads be read as the pattern it came from.


def choose_tints(disk: Disk, bundle: Int32Array) -> Int32Array:
    """Choose (bundles,) int32 the tint of every bundle, an index of style.TINTS.

    All different as long as there are tints enough; then bundles that cross or run side by
    side differ as far as the tints go.
    """
    n = int(bundle.max()) + 1
    meets = np.zeros((n, n), np.bool_)
    meets[bundle[:, 0], bundle[:, 1]] = True
    twin = QuadMesh.from_quads(disk.quads).twin
    along = bundle[:, [1, 0, 1, 0]].ravel()
    inner = np.flatnonzero(twin >= 0)
    meets[along[inner], along[twin[inner]]] = True
    meets |= meets.T
    tint = np.full(n, -1, np.int32)
    used = np.zeros(len(TINTS), np.int64)
    for b in range(n):
        near = tint[meets[b]]
        cost = used + 1_000_000 * np.bincount(near[near >= 0], minlength=len(TINTS))
        tint[b] = int(cost.argmin())
        used[tint[b]] += 1
    return tint
