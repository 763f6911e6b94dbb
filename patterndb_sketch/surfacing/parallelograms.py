"""Smooth surfaces of bent loops: a grid of quads that are as near to parallelograms as can be.

A loop with 3 to 6 corners is parted into as many sectors around a centre, each a grid of quads.
The inner vertices make the quads as near to parallelograms as the loop allows; with four corners
that is Coons' bilinear patch (1967). What decides is where the corners are: many choices are tried
coarsely and compared by a score, which knows nothing of the loop but its shape.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb_sketch.curvenetwork.polylines import measure_angles
from query.placing.leastsquares import solve_held

#: Candidate corners for each number of corners: so many of the likeliest vertices, of which all
#: subsets are tried. 112 choices in all.
LIKELIEST = {3: 6, 4: 8, 5: 7, 6: 6}

#: A vertex is the likelier a corner the more the loop turns there, and, with this weight, the more
#: it turns from this share of the perimeter before it to as much after: corners may be rounded.
AROUND_WEIGHT = 0.5
AROUND = 0.03

#: Quads along half a side while choices are compared.
COARSE = 4

#: Quads along half a side of the result in the mean, at least and at most; between, its quads are
#: as long as the loop's edges. With fewer it would be farther from what is meant, with more not
#: nearer.
FEWEST, MOST = 4, 24

#: Quads from a corner to the spoke on either side of it, at least: of a side that is short beside
#: the others.
NARROWEST = 2

#: How much the sum over quads gives way to edges that are short, which alone says where vertices
#: are that no quad's shape depends on.
EVENNESS = 1e-6

#: Weights of the score, chosen on half of a set of loops cut from artists' meshes.
SKEW, TURNING, ASPECT = 3.0, 0.25, 0.5

#: What a number of corners other than four adds to the score: four are meant most often. On
#: patches across the flow of meshes, the first half of benchmarks/surfacing/bent_patches.py, the
#: mean distance falls from 22.1 to 20.7 thousandths; along the flow it stays. More would be
#: better there still, but these patches all have four sides.
UNUSUAL = 0.5
USUAL_SIDES = 4

#: What the logarithm of the deviation from parallelograms is kept away from: below, it is noise.
LEAST_DEVIATION = 1e-3


@dataclass(frozen=True, slots=True)
class SectorGrid:
    """N sectors around a centre, each a grid of quads.

    starts:  (N + 1,) the border's vertices come first, around the grid: corner s is vertex
             starts[s], and the last is their number.
    quads:   (q, 4) int64.
    energy:  (v, v) sparse: x' energy x is to be least for each coordinate x of the vertices.
    laplacian: (v, v) sparse: the differences to the neighbours along edges, summed.
    ring:    vertices beside the border's, around the grid: for each side one less than it has
             edges, those beside its two corners among them; a corner's stands for both of its
             sides and comes twice.
    within:  the quads without a vertex on the border.
    """

    starts: Int64Array
    quads: Int64Array = field(repr=False)
    energy: csc_array = field(repr=False)
    laplacian: csc_array = field(repr=False)
    ring: tuple[Int64Array, ...] = field(repr=False)
    within: Int64Array = field(repr=False)

    @property
    def border(self) -> int:
        """How many vertices the border has."""
        return int(self.starts[-1])


@lru_cache(maxsize=256)
def make_sector_grid(spans: tuple[int, ...]) -> SectorGrid:
    """The grid of so many sides whose sector s has spans[s] quads along the side after its corner.

    spans: NARROWEST or more each. Along the side before it a sector has as many as the next one
    along the side after, for the two share a spoke: side s has spans[s] + spans[s + 2] quads.
    """
    sides = len(spans)
    starts = np.r_[0, np.cumsum(count_along(spans))]
    border = int(starts[-1])
    number: dict[tuple[int, int, int], int] = {}

    def vertex(sector: int, i: int, j: int) -> int:
        # i steps from the sector's corner along the side after it, j along the one before.
        sector %= sides
        wide, high = spans[sector], spans[(sector + 1) % sides]
        if j == 0:
            return int(starts[sector] + i) % border
        if i == 0:
            return int(starts[sector] - j) % border
        if i == wide and j == high:
            key = (-1, 0, 0)
        elif j == high:
            before = (sector - 1) % sides  # whose spoke it is, too
            key = (before, spans[before], i)
        else:
            key = (sector, i, j)
        return number.setdefault(key, border + len(number))

    quads = np.array(
        [
            [vertex(s, i, j), vertex(s, i + 1, j), vertex(s, i + 1, j + 1), vertex(s, i, j + 1)]
            for s, wide in enumerate(spans)
            for i in range(wide)
            for j in range(spans[(s + 1) % sides])
        ],
        np.int64,
    )
    ring = tuple(
        np.array(
            [vertex(s, i, 1) for i in range(1, wide + 1)]
            + [vertex(s + 1, 1, j) for j in range(spans[(s + 2) % sides] - 1, 0, -1)],
            np.int64,
        )
        for s, wide in enumerate(spans)
    )
    total = border + len(number)
    bent = _join_columns(quads, [1.0, -1.0, 1.0, -1.0], total)
    edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    long = _join_columns(edges, [1.0, -1.0], total)
    lengths = csc_array(long.T @ long)
    energy = csc_array(bent.T @ bent + EVENNESS * lengths)
    within = quads[(quads >= border).all(axis=1)]
    return SectorGrid(starts, quads, energy, 0.5 * lengths, ring, within)


def count_along(spans: Sequence[int]) -> Int64Array:
    """(N,) quads along the sides of the grid of such sectors."""
    return np.array(spans, np.int64) + np.roll(spans, -2)


def _join_columns(rows: Int64Array, weights: Sequence[float], columns: int) -> csc_array:
    """(m, columns) sparse, with the weights in each row at the places that ``rows`` (m, k) name."""
    at = np.repeat(np.arange(len(rows)), len(weights))
    values = np.tile(weights, len(rows))
    return csc_array((values, (at, rows.ravel())), shape=(len(rows), columns))


def place_inner(grid: SectorGrid, border: Points) -> Points:
    """The inner vertices (k, m) of a grid for columns of values of its border (b, m)."""
    return solve_held(grid.energy, border)


@lru_cache(maxsize=len(LIKELIEST))
def _weigh_border(sides: int) -> Floats:
    """(inner, border) what each vertex of a coarse grid's border gives to the inner ones."""
    grid = make_sector_grid((COARSE,) * sides)
    return place_inner(grid, np.eye(grid.border))


@dataclass(frozen=True, slots=True)
class CornerChoice:
    """Corners of a loop: their positions, ascending, and the score of the grid that they make."""

    corners: tuple[int, ...]
    score: float


def rank_corners(points: Points, nodes: Sequence[int] = ()) -> list[CornerChoice]:
    """Choices of 3 to 6 corners of a closed loop (n, 3), n >= 6, the likeliest first.

    nodes: positions that are tried as corners first, where there are no more than six.
    """
    around = np.r_[points, points[:1]]
    lengths = arc_length(around)
    scaled = points / float(np.linalg.norm(np.ptp(points, axis=0)))
    steps = np.roll(scaled, -1, axis=0) - scaled
    turning = measure_angles(np.roll(steps, 1, axis=0), steps)
    reach = AROUND * lengths[-1]
    before = points - at_lengths(around, (lengths[:-1] - reach) % lengths[-1])
    after = at_lengths(around, (lengths[:-1] + reach) % lengths[-1]) - points
    likely = turning + AROUND_WEIGHT * measure_angles(before, after)
    order = np.lexsort((np.arange(len(points)), -np.round(likely, 9))).tolist()
    named = [i for i in order if i in set(nodes)][: max(LIKELIEST)]
    found: list[CornerChoice] = []
    for sides, count in LIKELIEST.items():
        pool = sorted({*order[:count], *named})
        chosen = np.array(list(combinations(pool, sides)), np.int64).reshape(-1, sides)
        if len(chosen) == 0:
            continue
        scores = _score(scaled, turning, chosen)
        found += [
            CornerChoice(tuple(corners), score)
            for corners, score in zip(chosen.tolist(), scores.tolist(), strict=True)
        ]
    return sorted(found, key=lambda one: (one.score, one.corners))


def _place_borders(points: Points, corners: NDArray[np.int64], counts: Int64Array) -> Points:
    """(m, b, 3) the loop in counts (N,) edges of one length each between N corners (m, N)."""
    around = np.r_[points, points[:1]]
    at = measure_borders(arc_length(around), corners, counts)
    return at_lengths(around, at.ravel()).reshape(*at.shape, 3)


def measure_borders(lengths: Floats, corners: NDArray[np.int64], counts: Int64Array) -> Floats:
    """(m, b) where :func:`_place_borders` puts vertices, in lengths along the loop.

    lengths: (n + 1,) those of the loop's vertices, the first again at the end.
    """
    starts = lengths[corners]
    ends = np.roll(starts, -1, axis=1)
    ends[:, -1] += lengths[-1]
    share = np.concatenate([np.arange(count) / count for count in counts.tolist()])
    at = np.repeat(starts, counts, axis=1) + np.repeat(ends - starts, counts, axis=1) * share
    return at % lengths[-1]


def _score(points: Points, turning: Floats, corners: NDArray[np.int64]) -> Floats:
    """(m,) how unlikely choices of corners (m, N) of a loop of diagonal 1 are.

    Grids of what artists mean have quads that are nearly rectangular, nearly parallelograms and not
    too long, and loops turn at corners rather than elsewhere.
    """
    even = (COARSE,) * corners.shape[1]
    grid = make_sector_grid(even)
    border = _place_borders(points, corners, count_along(even))
    inner = np.einsum("ib,mbx->mix", _weigh_border(corners.shape[1]), border)
    a, b, c, d = np.moveaxis(np.concatenate([border, inner], axis=1)[:, grid.quads], 2, 0)
    across, along = (b + c - a - d) / 2, (c + d - a - b) / 2
    one, other = (across**2).sum(-1), (along**2).sum(-1)
    tiny = 1e-12
    skew = ((across * along).sum(-1) ** 2 / np.maximum(one * other, tiny**2)).mean(axis=1)
    area = np.linalg.norm(np.cross(across, along), axis=-1).sum(axis=1)
    bent = ((a - b + c - d) ** 2).sum(axis=(1, 2)) * (len(grid.quads) / 64)
    deviation = bent / np.maximum(area, tiny) ** 2
    aspect = np.abs(np.log(np.maximum(one, tiny) / np.maximum(other, tiny))).mean(axis=1)
    rest = (turning**2).sum() - (turning[corners] ** 2).sum(axis=1)
    unusual = 0.0 if corners.shape[1] == USUAL_SIDES else UNUSUAL
    return (
        unusual
        + SKEW * skew
        + TURNING * rest
        + np.log(deviation + LEAST_DEVIATION)
        + ASPECT * aspect
    )


@dataclass(frozen=True, slots=True)
class ParallelogramMesh:
    """A loop of n vertices filled by a grid.

    corners: positions of the loop. points: (k, 3), the vertices inside. triangles: (f, 3) int64 in
    the loop's sense; below n a position in the loop, n + i row i of ``points``.
    """

    corners: tuple[int, ...]
    points: Points = field(repr=False)
    triangles: Int64Array = field(repr=False)


def choose_spans(vertices: int, corners: Sequence[int]) -> tuple[int, ...]:
    """The quads along the sides of the sectors of a loop of so many vertices with such corners.

    Every side gets about as many quads as it has edges, so that faces inside are as long as those
    on the loop; sides opposite each other in a grid of four get the mean of both.
    """
    sides = len(corners)
    half = min(MOST, max(FEWEST, round(vertices / (2 * sides))))
    counts = np.diff(np.r_[corners, corners[0] + vertices]) * (2 * sides * half / vertices)
    # Side s has spans[s] + spans[s + 2] quads; of four sides that tells the sums alone.
    sums = np.eye(sides) + np.roll(np.eye(sides), 2, axis=1)
    spans = np.linalg.lstsq(sums, counts, rcond=None)[0]
    return tuple(np.maximum(np.round(spans), NARROWEST).astype(int).tolist())


def lay_grid(points: Points, corners: Sequence[int]) -> tuple[SectorGrid, Points]:
    """The grid that 3 to 6 corners make in a closed loop (n, 3), and its vertices (v, 3)."""
    grid = make_sector_grid(choose_spans(len(points), corners))
    border = _place_borders(points, np.array([corners]), np.diff(grid.starts))[0]
    return grid, np.concatenate([border, place_inner(grid, border)])


def fill_with_parallelograms(points: Points, corners: Sequence[int]) -> ParallelogramMesh:
    """Fill a closed loop (n, 3) with the grid that 3 to 6 of its vertices as corners make.

    Inside are the grid's vertices but for the border's; triangles join them to the loop's own.
    """
    n = len(points)
    sides = len(corners)
    grid, laid = lay_grid(points, corners)
    inner = laid[grid.border :]
    shift = n - grid.border
    together = np.r_[points, inner]
    quads = grid.within + shift
    cut = _cut_quads(together, quads)
    lengths = arc_length(np.r_[points, points[:1]])
    strip: list[tuple[int, int, int]] = []
    for s, first in enumerate(corners):
        last = corners[(s + 1) % sides] + (n if s == sides - 1 else 0)
        side = [i % n for i in range(first, last + 1)]
        at = np.array([lengths[i % n] + lengths[-1] * (i // n) for i in range(first, last + 1)])
        share = (at - at[0]) / (at[-1] - at[0])
        strip += _join_rows(side, share, (grid.ring[s] + shift).tolist())
    triangles = np.concatenate([np.array(strip, np.int64).reshape(-1, 3), cut])
    return ParallelogramMesh(tuple(corners), inner, triangles)


def _join_rows(
    side: Sequence[int], share: Floats, ring: Sequence[int]
) -> list[tuple[int, int, int]]:
    """Triangles between the vertices of a side, at ``share`` of its length, and the row beside."""
    made: list[tuple[int, int, int]] = []
    i = j = 0
    while i < len(side) - 1 or j < len(ring) - 1:
        # Whichever row's next edge has its middle first goes on.
        here = (share[i] + share[i + 1]) / 2 if i < len(side) - 1 else math.inf
        there = (j + 1.5) / (len(ring) + 1) if j < len(ring) - 1 else math.inf
        if here <= there:
            made.append((side[i], side[i + 1], ring[j]))
            i += 1
        else:
            made.append((side[i], ring[j + 1], ring[j]))
            j += 1
    return made


def _cut_quads(points: Points, quads: Int64Array) -> Int64Array:
    """(2 q, 3) quads (q, 4) cut along their shorter diagonals."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    first = np.linalg.norm(a - c, axis=1) <= np.linalg.norm(b - d, axis=1)
    order = np.where(first[:, None], [0, 1, 2, 0, 2, 3], [0, 1, 3, 1, 2, 3])
    return np.take_along_axis(quads, order, axis=1).reshape(-1, 3)
