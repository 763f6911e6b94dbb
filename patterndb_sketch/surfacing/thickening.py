"""Thickening: a surface becomes the closed solid of the points near it, for printing.

Every face has two sides. Around an edge the side of one face goes on in that side of the next which
faces it: edges of one face, two or more are treated alike, and so are surfaces that turn over.
Where one face alone has an edge, a wall joins its two sides, and caps close what walls leave open.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import InvalidNetworkError

#: Normals around a vertex that spread less than this across each other, as a part of their greatest
#: spread, are of one smooth surface: an edge bent by less than 25 degrees.
SMOOTH = 0.05

#: A vertex at a sharp edge moves by this many times half the thickness at most: beyond an edge of
#: some 47 degrees the solid is thinner there, instead of having a spike.
LONGEST = 2.5


def thicken(
    points: Points, triangles: NDArray[np.integer], thickness: float
) -> tuple[Points, Int64Array]:
    """Make the closed solid of a surface, half of the thickness on each of its sides.

    Parameters
    ----------
    points : (v, 3) float64
        Vertices; those without a face are left out.
    triangles : (f, 3) int
        Faces of any sense. Edges may have any number of them.
    thickness : float
        In the unit of the points, above 0. Flat faces are so far apart exactly, and at corners
        their planes are, as far as LONGEST allows.

    Returns
    -------
    points : (w, 3) float64
    triangles : (g, 3) int64
        Every edge has two faces, which agree about its sense; normals point out of the solid. Where
        the surface bends more tightly than the thickness allows, faces pass through each other.

    Raises
    ------
    InvalidNetworkError
        For a thickness that is not above 0, and a surface without faces.
    """
    if not (math.isfinite(thickness) and thickness > 0.0):
        raise InvalidNetworkError(f"the thickness is {thickness}; give a length above 0")
    if not len(triangles):
        raise InvalidNetworkError("the surface has no faces; there is nothing to thicken")
    faces = np.asarray(triangles, np.int64)
    links, rim = _link_sides(points, faces)
    # A corner of a face has two sides: element 2 (3 face + corner) + side.
    n = 6 * len(faces)
    graph = coo_array((np.ones(len(links), np.bool_), (links[:, 0], links[:, 1])), (n, n))
    count, label = connected_components(graph, directed=False)
    places = np.empty(count, np.int64)
    places[label] = np.repeat(faces.ravel(), 2)
    moved = points[places] + _measure_offsets(points, faces, label, count) * (thickness / 2.0)
    name = label.reshape(-1, 3, 2)
    # The wall of an edge from a to b of one face alone, from its first side to its second.
    a, b = name[rim // 3, rim % 3], name[rim // 3, (rim + 1) % 3]
    solid = [
        name[:, :, 0],
        name[:, ::-1, 1],
        np.stack([b[:, 0], a[:, 0], a[:, 1]], axis=1),
        np.stack([b[:, 0], a[:, 1], b[:, 1]], axis=1),
    ]
    made = np.concatenate(solid).astype(np.int64)
    return moved, np.concatenate([made, _cap_ends(made)])


def _cap_ends(triangles: Int64Array) -> Int64Array:
    """(c, 3) the triangles that close what walls leave open.

    Where an edge of three faces or more ends, the walls of these faces stand around a polygon.
    """
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    n = int(triangles.max()) + 1
    open_edges = ~np.isin(tail * n + head, head * n + tail)
    after: dict[int, list[int]] = {}
    for start, end in zip(head[open_edges].tolist(), tail[open_edges].tolist(), strict=True):
        after.setdefault(start, []).append(end)
    made: list[tuple[int, int, int]] = []
    for first in sorted(after):
        while after[first]:
            around = [first, after[first].pop()]
            while around[-1] != first:
                around.append(after[around[-1]].pop())
            made += [(first, b, c) for b, c in pairwise(around[1:-1])]
    return np.array(made, np.int64).reshape(-1, 3)


def _link_sides(points: Points, faces: Int64Array) -> tuple[Int64Array, Int64Array]:
    """(m, 2) pairs of corners' sides that are one, and (r,) half-edges that have no other."""
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    order = np.lexsort((high, low))
    new = (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0)
    groups = np.split(order, np.flatnonzero(new) + 1)
    rim: list[int] = []
    links: list[tuple[int, int]] = []
    for group in groups:
        if len(group) == 1:
            rim.append(int(group[0]))
            continue
        around = group.tolist()
        if len(around) > 2:
            angles = _measure_angles(points, faces, group)
            around = group[np.argsort(angles, kind="stable")].tolist()
        for one, other in zip(around, [*around[1:], around[0]], strict=True):
            # Seen along the edge: the side that faces the next face, and that which faces back.
            ahead, back = int(tail[one] > head[one]), int(tail[other] < head[other])
            for at in (int(low[one]), int(high[one])):
                links.append((2 * _find_corner(tail, one, at) + ahead,
                              2 * _find_corner(tail, other, at) + back))  # fmt: skip
    return np.array(links, np.int64).reshape(-1, 2), np.array(rim, np.int64)


def _find_corner(tail: Int64Array, half: int, vertex: int) -> int:
    """The corner, of those at a half-edge's ends, that is at a vertex."""
    return half if tail[half] == vertex else half - half % 3 + (half + 1) % 3


def _measure_angles(points: Points, faces: Int64Array, group: Int64Array) -> NDArray[np.float64]:
    """The angles at which the faces of some half-edges lie about their common edge."""
    first = int(group[0])
    ends = sorted((int(faces.flat[first]), int(faces[first // 3, (first + 1) % 3])))
    axis = points[ends[1]] - points[ends[0]]
    axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
    inward = points[faces[group // 3, (group + 2) % 3]] - points[ends[0]]
    inward = inward - (inward @ axis)[:, None] * axis
    right = inward[0] / max(float(np.linalg.norm(inward[0])), 1e-300)
    return np.arctan2(inward @ np.cross(axis, right), inward @ right)


def _measure_offsets(
    points: Points, faces: Int64Array, label: NDArray[np.integer], count: int
) -> Points:
    """(count, 3) by how much each vertex of the solid moves for an offset of 1.

    The movement that brings it nearest to the moved planes of its faces, weighted by their angles.
    """
    corner = points[faces]
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(corner, 1, axis=1) - corner
    across = np.cross(leaving, entering)
    size = np.linalg.norm(across, axis=2)
    angle = np.arctan2(size, (leaving * entering).sum(axis=2))
    normal = across[:, 0] / np.maximum(size[:, :1], 1e-300)
    weight = np.repeat(angle.ravel(), 2)
    directed = normal[:, None, None] * np.array([1.0, -1.0])[None, None, :, None]
    directed = np.broadcast_to(directed, (len(faces), 3, 2, 3)).reshape(-1, 3)
    matrix, target = np.zeros((count, 3, 3)), np.zeros((count, 3))
    weighted = weight[:, None] * directed
    np.add.at(matrix, label, weighted[:, :, None] * directed[:, None, :])
    np.add.at(target, label, weighted)
    values, axes = np.linalg.eigh(matrix)
    kept = values > SMOOTH * np.maximum(values[:, -1:], 1e-300)
    shares = np.einsum("ijk,ij->ik", axes, target) / np.where(kept, values, 1.0)
    offsets = np.einsum("ijk,ik->ij", axes, np.where(kept, shares, 0.0))
    lengths = np.linalg.norm(offsets, axis=1, keepdims=True)
    return offsets * np.minimum(1.0, LONGEST / np.maximum(lengths, 1e-300))


def is_closed(triangles: NDArray[np.integer]) -> bool:
    """Has every edge of triangles (f, 3) two of them, which agree about its sense?"""
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    there, back = np.stack([tail, head], axis=1), np.stack([head, tail], axis=1)
    edges = np.unique(there, axis=0)
    return len(edges) == len(there) and np.array_equal(edges, np.unique(back, axis=0))


def turn_outward(points: Points, faces: list[Int64Array]) -> list[Int64Array]:
    """Turn those parts of a surface, each hanging together, that enclose a negative volume.

    faces: arrays (f, k) that may differ in k; returned so. Normals of closed parts point outward
    then, as printers want it.
    """
    vertices = np.concatenate([np.zeros(0, np.int64), *(piece.ravel() for piece in faces)])
    if not len(vertices):
        return faces
    n = int(vertices.max()) + 1
    ends = np.concatenate([
        np.stack([piece, np.roll(piece, -1, axis=1)], axis=2).reshape(-1, 2) for piece in faces
    ])  # fmt: skip
    graph = coo_array((np.ones(len(ends), np.bool_), (ends[:, 0], ends[:, 1])), (n, n))
    count, part = connected_components(graph, directed=False)
    middle = points[vertices].mean(axis=0)
    volume = np.zeros(count)
    for piece in faces:
        at = points[piece] - middle
        for k in range(1, piece.shape[1] - 1):
            six = (np.cross(at[:, 0], at[:, k]) * at[:, k + 1]).sum(axis=1)
            np.add.at(volume, part[piece[:, 0]], six)
    turned = [volume[part[piece[:, 0]]] < 0.0 for piece in faces]
    return [
        np.where(over[:, None], piece[:, ::-1], piece)
        for piece, over in zip(faces, turned, strict=True)
    ]
