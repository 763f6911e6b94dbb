"""Place a fill across its loop, and measure how it lies there.

Inner vertices minimise the umbrella Laplacian over inner vertices and those of the loop, the mesh
around being held: bending energy, so that a fill goes on as the surroundings arrive. (Harmonic
placing, which minimises stretch alone, lets rings of regular quads sag. It is taken where fewer
quads are flipped by it.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Floats, units
from patterndb.system.kernels import kernel
from query.holes.surroundings import Surroundings, norm_of
from query.placing.laplace import solve_harmonic
from query.placing.untangle import untangle

#: The library's routines are known at run time only.
_lapack: Any = lapack

#: Inner vertices up to which a dense solver is faster.
DENSE = 160

#: What is added to the normal equations' diagonal: loops without surroundings leave a plane open.
RIDGE = 1e-9

#: A quad is turned over where it lies folded back on the faces across two of its edges or more: the
#: cosine of the angle between normals is less than this. Artists' own quads meet across one edge at
#: any angle, around a thin rim; across two they hardly ever are more than 120 degrees apart.
FOLDED = -0.5

#: The numbers of :func:`measure_fill`, in order.
MEASURES = (
    "edge_mean",
    "edge_spread",
    "loop_edge_ratio",
    "least_jacobian",
    "mean_jacobian",
    "flipped",
    "angles",
    "opposite_edges",
    "area_spread",
    "area_mean",
    "straight_loop",
    "straight_inner",
    "irregular_angles",
    "normal_jump",
    "loop_angles",
    "worst_loop_angle",
    "bending",
    "worst_aspect",
    "mean_aspect",
    "worst_angle",
    "turned",
    "least_outward",
    "worst_fold",
)


#: Where the bending energy is among them, which the solver knows.
BENDING = MEASURES.index("bending")


@dataclass(frozen=True, slots=True, eq=False)
class PlacedFill:
    """points: (k, 3) inner vertices in the fill's order. measures: see MEASURES. flipped: quads
    that are turned over; see FOLDED."""

    points: Floats
    measures: Floats
    flipped: int


def place_fill(around: Surroundings, quads: Int32Array, n_vertices: int) -> PlacedFill:
    """Place the inner vertices of a fill and measure it.

    quads: (q, 4) int32, loop vertices 0..L-1 in order, inner ones L..n_vertices - 1.
    """
    n_loop = len(around.outside)
    n_outer = len(around.points)
    inner = n_vertices - n_loop
    shifted = np.where(quads >= n_loop, quads - n_loop + n_outer, quads).astype(np.int64)
    points = np.empty((n_outer + inner, 3))
    points[:n_outer] = around.points
    points[n_outer:] = around.points[:n_loop].mean(axis=0)
    start, beside = _neighbours(
        around.corners.astype(np.int64), around.offsets, shifted, n_outer + inner
    )
    placed: PlacedFill | None = None
    for harmonic in (False, True):
        bending = 0.0
        if inner:
            rows_of = _laplacian_rows(points, start, beside, n_outer, n_loop)
            solve = _solve_dense if inner <= DENSE else _solve_sparse
            solved, bending = solve(*rows_of, inner, harmonic)
            points[n_outer:] = solved
        measures, flipped = _measure_there(around, points, shifted)
        rows = inner + n_loop
        measures[BENDING] = np.log(bending / (around.scale**2) / max(rows, 1) + 1e-6)
        if placed is None or flipped < placed.flipped:
            placed = PlacedFill(points[n_outer:].copy(), measures, flipped)
        if not flipped or not inner:
            break
    assert placed is not None
    return placed


def mend_fill(around: Surroundings, quads: Int32Array, placed: PlacedFill) -> PlacedFill:
    """Untangle a fill that has quads turned over, if fewer are then; its measures stay."""
    n, n_vertices = len(around.outside), len(around.outside) + len(placed.points)
    if not placed.flipped or not len(placed.points):
        return placed
    neighbours = Neighbours.of(quads, n_vertices, n)
    vertices = np.vstack([around.points[:n], placed.points])
    normals = units(solve_harmonic(neighbours, around.normals))
    points = untangle(quads, vertices, normals, n, neighbours)[n:]
    flipped = count_flipped(around, quads, points)
    return PlacedFill(points, placed.measures, flipped) if flipped < placed.flipped else placed


def count_flipped(around: Surroundings, quads: Int32Array, inner: Floats) -> int:
    """Count the quads of a fill that are turned over where its inner vertices (k, 3) lie."""
    n_loop, n_outer = len(around.outside), len(around.points)
    shifted = np.where(quads >= n_loop, quads - n_loop + n_outer, quads).astype(np.int64)
    return _measure_there(around, np.vstack([around.points, inner]), shifted)[1]


def _measure_there(
    around: Surroundings, points: Floats, quads: NDArray[np.int64]
) -> tuple[Floats, int]:
    """Measure a fill by the points of the mesh around and its own after them."""
    return measure_fill(
        points,
        quads,
        around.corners.astype(np.int64),
        around.offsets,
        around.normals,
        around.beyond,
        len(around.outside),
        len(around.points),
        around.scale,
        around.area,
    )


@kernel
def _neighbours(
    corners: NDArray[np.int64],
    offsets: NDArray[np.int64],
    quads: NDArray[np.int64],
    n_points: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Neighbours of every vertex along edges, once for each face that the edge borders."""
    start = np.zeros(n_points + 1, np.int64)
    for c in corners:
        start[c + 1] += 2
    for f in range(len(quads)):
        for e in range(4):
            start[quads[f, e] + 1] += 2
    for v in range(n_points):
        start[v + 1] += start[v]
    at = start[:-1].copy()
    beside = np.empty(start[-1], np.int64)
    for f in range(len(offsets) - 1):
        first, k = offsets[f], offsets[f + 1] - offsets[f]
        for e in range(k):
            v = corners[first + e]
            beside[at[v]] = corners[first + (e + 1) % k]
            beside[at[v] + 1] = corners[first + (e - 1) % k]
            at[v] += 2
    for f in range(len(quads)):
        for e in range(4):
            v = quads[f, e]
            beside[at[v]] = quads[f, (e + 1) & 3]
            beside[at[v] + 1] = quads[f, (e + 3) & 3]
            at[v] += 2
    return start, beside


@kernel
def _laplacian_rows(
    points: Floats,
    start: NDArray[np.int64],
    beside: NDArray[np.int64],
    n_outer: int,
    n_loop: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats, Floats]:
    """Rows of inner vertices, then of loop vertices: (row, column, weight) and right-hand sides
    (r, 3)."""
    inner = len(start) - 1 - n_outer
    most = len(beside) + inner
    row = np.empty(most, np.int64)
    column = np.empty(most, np.int64)
    weight = np.empty(most)
    right = np.zeros((inner + n_loop, 3))
    n = 0
    for r in range(inner + n_loop):
        v = n_outer + r if r < inner else r - inner
        d = start[v + 1] - start[v]
        if d == 0:
            continue
        for k in range(start[v], start[v + 1]):
            j = beside[k]
            if j >= n_outer:
                row[n] = r
                column[n] = j - n_outer
                weight[n] = 1.0 / d
                n += 1
            else:
                right[r] -= points[j] / d
        if v >= n_outer:
            row[n] = r
            column[n] = v - n_outer
            weight[n] = -1.0
            n += 1
        else:
            right[r] += points[v]
    return row[:n], column[:n], weight[:n], right


def _solve_dense(
    row: NDArray[np.int64],
    column: NDArray[np.int64],
    weight: Floats,
    right: Floats,
    inner: int,
    harmonic: bool,
) -> tuple[Floats, float]:
    a = np.zeros((len(right), inner))
    np.add.at(a.reshape(-1), row * inner + column, weight)
    if harmonic:
        solved = _solve_square(a[:inner], right[:inner])
    else:
        m = a.T @ a
        m[np.diag_indices(inner)] += RIDGE
        solved = _solve_square(m, a.T @ right)
    rest = a @ solved - right
    return solved, float(np.cumsum(rest * rest)[-1])


def _solve_square(a: Floats, right: Floats) -> Floats:
    """Solve a square system. LAPACK is SciPy's: NumPy's has other last digits."""
    _, _, solved, singular = _lapack.dgesv(a, right)
    if singular:
        raise np.linalg.LinAlgError("Singular matrix")
    return solved


def _solve_sparse(
    row: NDArray[np.int64],
    column: NDArray[np.int64],
    weight: Floats,
    right: Floats,
    inner: int,
    harmonic: bool,
) -> tuple[Floats, float]:
    a = csr_array((weight, (row, column)), shape=(len(right), inner))
    if harmonic:
        solved = splu(a[:inner].tocsc()).solve(right[:inner])
    else:
        m = (a.T @ a).tocsc()
        m.setdiag(m.diagonal() + RIDGE)
        solved = splu(m).solve(a.T @ right)
    rest = a @ solved - right
    return solved, float((rest * rest).sum())


@kernel
def _angle_between(a: Floats, b: Floats) -> float:
    return np.arctan2(norm_of(np.cross(a, b)), (a * b).sum())


@kernel
def measure_fill(
    points: Floats,
    quads: NDArray[np.int64],
    corners: NDArray[np.int64],
    offsets: NDArray[np.int64],
    normals: Floats,
    beyond: Floats,
    n_loop: int,
    n_outer: int,
    scale: float,
    area: float,
) -> tuple[Floats, int]:
    """Measure a placed fill; see MEASURES, of which "bending" is left 0. Also the flipped quads."""
    found = np.zeros(23)
    q = len(quads)
    tiny = 1e-6 * scale
    # Half-edges of the fill: the quads at a vertex, and edges by their ends.
    n_points = len(points)
    valence = np.zeros(n_points, np.int64)
    for f in range(q):
        for e in range(4):
            valence[quads[f, e]] += 1
    normal = np.zeros((q, 3))
    vertex_normal = np.zeros((n_points, 3))
    for f in range(q):
        c = np.cross(
            points[quads[f, 2]] - points[quads[f, 0]], points[quads[f, 3]] - points[quads[f, 1]]
        )
        s = norm_of(c)
        if s > 0:
            normal[f] = c / s
        for e in range(4):
            vertex_normal[quads[f, e]] += normal[f]
    for i in range(n_loop):
        vertex_normal[i] += 2 * normals[i]
    lengths = 0.0
    squares = 0.0
    n_edges = 0
    ratio = 0.0
    n_ratio = 0
    least = 1.0
    mean = 0.0
    angles = 0.0
    opposite = 0.0
    areas = 0.0
    area_squares = 0.0
    irregular = 0.0
    n_irregular = 0
    loop_angles = 0.0
    worst_loop = 0.0
    worst_aspect = 0.0
    mean_aspect = 0.0
    worst_angle = 0.0
    least_outward = 1.0
    for f in range(q):
        worst = 1.0
        side = np.empty(4)
        for e in range(4):
            v, w, u = quads[f, e], quads[f, (e + 1) & 3], quads[f, (e + 3) & 3]
            a, b = points[w] - points[v], points[u] - points[v]
            la, lb = norm_of(a), norm_of(b)
            side[e] = la
            c = np.cross(a, b)
            j = (c * normal[f]).sum() / max(la * lb, 1e-300)
            worst = min(worst, j)
            t = np.arctan2(norm_of(c), (a * b).sum())
            if j < 0:
                t = 2 * np.pi - t
            angles += (t - np.pi / 2) ** 2
            worst_angle = max(worst_angle, abs(t - np.pi / 2))
            s = norm_of(vertex_normal[v])
            outward = (c * vertex_normal[v]).sum() / max(la * lb * s, 1e-300)
            least_outward = min(least_outward, outward)
            inner = v >= n_outer
            if inner and valence[v] != 4:
                irregular += (t - 2 * np.pi / valence[v]) ** 2
                n_irregular += 1
            if v < n_loop:
                off = abs(t - np.pi / 2)
                loop_angles += off
                worst_loop = max(worst_loop, off)
            on_loop = v < n_loop and w < n_loop and w == (v + 1) % n_loop
            if not on_loop:
                # Inner edges are met twice, from both of their quads.
                d = np.log(max(la, tiny) / scale)
                lengths += d
                squares += d * d
                n_edges += 1
                if v < n_loop and w >= n_outer:
                    x = norm_of(points[v] - points[(v + 1) % n_loop])
                    y = norm_of(points[v] - points[(v - 1) % n_loop])
                    ratio += abs(d - np.log(max(np.sqrt(x * y), tiny) / scale))
                    n_ratio += 1
        aspect = abs(np.log(max(side[0] + side[2], tiny) / max(side[1] + side[3], tiny)))
        worst_aspect = max(worst_aspect, aspect)
        mean_aspect += aspect
        for e in range(2):
            opposite += abs(np.log(max(side[e], tiny) / max(side[e + 2], tiny)))
        c = np.cross(
            points[quads[f, 2]] - points[quads[f, 0]], points[quads[f, 3]] - points[quads[f, 1]]
        )
        d = np.log(max(norm_of(c) / 2, 1e-6 * area) / area)
        areas += d
        area_squares += d * d
        least = min(least, worst)
        mean += worst
    if n_edges:
        middle = lengths / n_edges
        found[0] = middle
        found[1] = np.sqrt(max(squares / n_edges - middle * middle, 0.0))
    found[2] = ratio / max(n_ratio, 1)
    found[3] = least
    found[4] = mean / q
    worst_fold, flipped = _find_folds(quads, normal, beyond, n_points)
    found[5] = flipped / q
    found[6] = angles / q
    found[7] = opposite / q
    middle = areas / q
    found[8] = np.sqrt(max(area_squares / q - middle * middle, 0.0))
    found[9] = abs(middle)
    loop_bend, inner_bend = _strand_bends(points, quads, corners, offsets, n_loop, n_outer)
    found[10] = loop_bend
    found[11] = inner_bend
    found[12] = irregular / max(n_irregular, 1)
    jump = 0.0
    for f in range(q):
        for e in range(4):
            v, w = quads[f, e], quads[f, (e + 1) & 3]
            if v < n_loop and w == (v + 1) % n_loop:
                outer = normals[v] + normals[w]
                s = norm_of(outer)
                if s > 0:
                    bend = 1.0 - (outer * normal[f]).sum() / s
                    jump += bend
                    worst_fold = max(worst_fold, bend)
    found[13] = jump / n_loop
    found[14] = loop_angles / n_loop
    found[15] = worst_loop
    found[17] = worst_aspect
    found[18] = mean_aspect / q
    found[19] = worst_angle
    found[20] = flipped > 0
    found[21] = least_outward
    found[22] = worst_fold
    return found, flipped


@kernel
def _find_folds(
    quads: NDArray[np.int64], normal: Floats, beyond: Floats, n_points: int
) -> tuple[float, int]:
    """1 less the cosine of the greatest angle between the normals of quads with a common edge; and
    how many quads are turned over, see FOLDED.

    beyond: (L, 3) normals of the faces across the loop's edges, 0 where there is none.
    """
    n_loop = len(beyond)
    keys = np.empty(4 * len(quads), np.int64)
    folded = np.zeros(len(quads), np.int64)
    for f in range(len(quads)):
        for e in range(4):
            v, w = quads[f, e], quads[f, (e + 1) & 3]
            keys[4 * f + e] = min(v, w) * n_points + max(v, w)
            if v < n_loop and w == (v + 1) % n_loop:
                folded[f] += (normal[f] * beyond[v]).sum() < FOLDED
    order = np.argsort(keys)
    worst = 0.0
    for i in range(len(order) - 1):
        if keys[order[i]] == keys[order[i + 1]]:
            a, b = order[i] >> 2, order[i + 1] >> 2
            cosine = (normal[a] * normal[b]).sum()
            worst = max(worst, 1.0 - cosine)
            if cosine < FOLDED:
                folded[a] += 1
                folded[b] += 1
    return worst, (folded > 1).sum()


@kernel
def _strand_bends(
    points: Floats,
    quads: NDArray[np.int64],
    corners: NDArray[np.int64],
    offsets: NDArray[np.int64],
    n_loop: int,
    n_outer: int,
) -> tuple[float, float]:
    """Mean squared bend, in radians, of the strands through regular vertices: of the loop, across
    it; and of those within."""
    n_points = len(points)
    n_faces = len(offsets) - 1
    total = len(corners) + 4 * len(quads)
    tail = np.empty(total, np.int64)
    head = np.empty(total, np.int64)
    before = np.empty(total, np.int64)
    n = 0
    for f in range(n_faces):
        first, k = offsets[f], offsets[f + 1] - offsets[f]
        for e in range(k):
            tail[n] = corners[first + e]
            head[n] = corners[first + (e + 1) % k]
            before[n] = corners[first + (e - 1) % k]
            n += 1
    for f in range(len(quads)):
        for e in range(4):
            tail[n] = quads[f, e]
            head[n] = quads[f, (e + 1) & 3]
            before[n] = quads[f, (e + 3) & 3]
            n += 1
    start = np.zeros(n_points + 1, np.int64)
    for h in range(n):
        start[tail[h] + 1] += 1
    for v in range(n_points):
        start[v + 1] += start[v]
    at = start[:-1].copy()
    out = np.empty(n, np.int64)
    for h in range(n):
        out[at[tail[h]]] = h
        at[tail[h]] += 1
    loop_sum = 0.0
    n_loop_bends = 0
    inner_sum = 0.0
    n_inner = 0
    for v in range(n_points):
        if (n_loop <= v < n_outer) or start[v + 1] - start[v] != 4:
            continue
        h = out[start[v]]
        ring = np.empty(4, np.int64)
        whole = True
        for e in range(4):
            ring[e] = head[h]
            following = -1
            for k in range(start[v], start[v + 1]):
                if head[out[k]] == before[h]:
                    following = out[k]
            if following < 0:
                whole = False
                break
            h = following
        if not whole:
            continue
        for e in range(2):
            x, y = ring[e], ring[e + 2]
            bend = np.pi - _angle_between(points[x] - points[v], points[y] - points[v])
            if v < n_loop:
                if (x == (v + 1) % n_loop and y == (v - 1) % n_loop) or (
                    y == (v + 1) % n_loop and x == (v - 1) % n_loop
                ):
                    continue
                loop_sum += bend * bend
                n_loop_bends += 1
            else:
                inner_sum += bend * bend
                n_inner += 1
    return loop_sum / max(n_loop_bends, 1), inner_sum / max(n_inner, 1)
