"""What is to be painted of one disk, in flat coordinates: the same for paper and window."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.disk import Disk
from patterndb.core.halfedge import Int32Array, next_edge
from patterndb.core.polychord import polychords
from patterndb.core.quadmesh import QuadMesh
from patterndb.geometry.points import Points
from viewer.embedding import embed_disk, frame_points
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
    to pick out, numbered as :func:`viewer.drawing.find_bundles` does; one there is not is ignored.
    points: (v, 2) where the vertices lie; None lays them out by the disk's corners. marks: of
    strokes.
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


def find_bundles(disk: Disk) -> Int32Array:
    """Find bundles of parallel polychords, as (q, 2) int32 through edges 0-2 and edges 1-3.

    Two polychords are parallel if between them runs a regular chain: closed or from one
    flat boundary vertex to another, through interior vertices of valence 4 only. Bundles
    are numbered by the first boundary edge they meet, those of loops after them, so that a
    reduced pattern and its expansions number them alike (and as Pattern.label does).
    """
    twin = QuadMesh.from_quads(disk.quads).twin
    of_edge = polychords(twin).of_edge
    root = np.arange(of_edge.max() + 1)
    for chain in _regular_chains(disk, twin):
        for h in chain:
            one = _find(root, int(of_edge[next_edge(h)]))
            other = _find(root, int(of_edge[next_edge(int(twin[h]))]))
            root[max(one, other)] = min(one, other)
    tail = disk.quads.ravel()
    border = np.flatnonzero(twin < 0)
    border = border[np.argsort(tail[border])]
    number: dict[int, int] = {}
    for c in (*of_edge[border].tolist(), *range(len(root))):
        number.setdefault(_find(root, c), len(number))
    name = np.array([number[_find(root, c)] for c in range(len(root))], np.int32)
    return name[of_edge].reshape(-1, 4)[:, :2]


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


def find_boundary_bundles(disk: Disk, bundle: Int32Array) -> Int32Array:
    """Find (P,) int32 bundle that meets every boundary edge, edge j leaving vertex j."""
    tail = disk.quads
    head = np.roll(tail, -1, axis=1)
    quad, edge = np.nonzero((tail < disk.perimeter) & (head == (tail + 1) % disk.perimeter))
    met = np.empty(disk.perimeter, np.int32)
    met[tail[quad, edge]] = bundle[quad, edge & 1]
    return met


def _regular_chains(disk: Disk, twin: Int32Array) -> list[list[int]]:
    """Half-edges of every regular chain; a chain may be found once from each end."""
    valence = disk.valence()
    tail = disk.quads.ravel()
    p = disk.perimeter

    def walk(h: int) -> list[int] | None:
        chain = [h]
        while True:
            head = int(tail[next_edge(chain[-1])])
            if head < p:
                return chain if valence[head] == 2 else None
            if valence[head] != 4:
                return None
            # Two quads on round the vertex is straight ahead.
            ahead = next_edge(int(twin[next_edge(chain[-1])]))
            if ahead == h:
                return chain
            if len(chain) > len(twin):
                return None
            chain.append(ahead)

    chains: list[list[int]] = []
    seen = np.zeros(len(twin), np.bool_)
    for from_boundary in (True, False):
        for h in np.flatnonzero(twin >= 0).tolist():
            v = int(tail[h])
            start = valence[v] == 2 if v < p else valence[v] == 4
            if (v < p) != from_boundary or not start or seen[h]:
                continue
            chain = walk(h)
            if chain is None or (not from_boundary and int(tail[next_edge(chain[-1])]) != v):
                continue
            seen[chain] = True
            chains.append(chain)
    return chains


def _find(root: NDArray[np.int64], c: int) -> int:
    while root[c] != c:
        c = int(root[c])
    return c
