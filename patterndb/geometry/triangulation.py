"""Any polygons -> triangles that do not depend on how the polygons were written down.

Points at the same place are one, points are sorted by place, triangles by their points: the
order, the sense and the first corner of faces no longer matter, nor do split vertices.
"""

# scipy has no types: what it returns is typed by the functions' own annotations.
# pyright: reportMissingTypeStubs=false, reportUnknownVariableType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidMeshError
from patterndb.geometry.leastarea import triangulate_cheapest
from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel

#: Points this close, as a share of the diagonal, are one: coordinates in files have some seven
#: digits, computed ones fifteen.
WELD = 1e-9

#: The most corners of one face: its triangulation takes time with the cube (a second or two).
MOST_CORNERS = 1_000

#: What an edge's squared length counts beside an area: among equal areas the shorter edges win.
SHORTER = 1e-6


def weld(points: Points, reach: float) -> tuple[Points, NDArray[np.int64]]:
    """(w, 3) the places of (n, 3) points in lexicographic order, and (n,) the place of each.

    Points within ``reach`` of each other, also by way of others, are one, at the place of the
    lexicographically first: the result does not depend on their order.
    """
    points = points + 0.0  # -0.0 is 0.0
    order = np.lexsort(points.T[::-1])
    sorted_points = points[order]
    fresh = np.r_[True, (sorted_points[1:] != sorted_points[:-1]).any(axis=1)]
    place = np.empty(len(points), np.int64)
    place[order] = np.cumsum(fresh) - 1
    places = sorted_points[fresh]
    pairs = KDTree(places).query_pairs(reach, output_type="ndarray")
    if len(pairs):
        n = len(places)
        graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (n, n))
        label = connected_components(graph, directed=False)[1]
        first = np.unique(label, return_index=True)[1]
        kept = np.sort(first)
        place = np.searchsorted(kept, first)[label[place]]
        places = places[kept]
    return np.ascontiguousarray(places), place


def triangulate_faces(
    points: Points, corners: NDArray[np.integer], offsets: NDArray[np.integer]
) -> tuple[Int32Array, int]:
    """((t, 3) triangles, how many faces or pieces of faces had fewer than three points).

    points: (v, 3), welded and sorted; corners, offsets: faces as of a PolygonMesh. Of all ways
    to cut a face along its diagonals the one with the least area is taken: concave and warped
    faces are covered once, which a fan from one corner does not do.

    Source: the dynamic programme of Barequet and Sharir 1995, "Filling gaps in the boundary of
    a polyhedron". Raises InvalidMeshError for a face of more than MOST_CORNERS corners.
    """
    arity = np.diff(offsets)
    if len(arity) and arity.max() > MOST_CORNERS:
        face = int(np.argmax(arity))
        raise InvalidMeshError(
            f"face {face} has {arity[face]} corners, the limit is {MOST_CORNERS}; "
            "cut it into smaller faces"
        )
    pieces = _cut(points, corners.astype(np.int32), offsets.astype(np.int64))
    sound = (
        (pieces[:, 0] != pieces[:, 1])
        & (pieces[:, 1] != pieces[:, 2])
        & (pieces[:, 2] != pieces[:, 0])
    )
    dropped = int((~sound).sum() + (arity < 3).sum())
    return pieces[sound], dropped


def sort_triangles(triangles: Int32Array) -> tuple[Int32Array, int]:
    """((t, 3) triangles, each ascending and once, sorted; how many repeated others)."""
    ascending = np.sort(triangles, axis=1)
    ascending = ascending[np.lexsort(ascending.T[::-1])]
    fresh = np.ones(len(ascending), np.bool_)
    fresh[1:] = (ascending[1:] != ascending[:-1]).any(axis=1)
    return np.ascontiguousarray(ascending[fresh]), int((~fresh).sum())


@kernel
def _cut(points: Points, corners: Int32Array, offsets: NDArray[np.int64]) -> Int32Array:
    """(t, 3) the triangles of all faces, n - 2 of a face with n corners."""
    total = 0
    for f in range(len(offsets) - 1):
        total += max(offsets[f + 1] - offsets[f] - 2, 0)
    result = np.empty((total, 3), np.int32)
    at = 0
    for f in range(len(offsets) - 1):
        n = offsets[f + 1] - offsets[f]
        if n < 3:
            continue
        face = _written_once(corners[offsets[f] : offsets[f + 1]])
        if n == 3:
            result[at] = face
        else:
            _cut_face(points, face, result[at : at + n - 2])
        at += n - 2
    return result


@kernel
def _written_once(face: Int32Array) -> Int32Array:
    """The lexicographically first of all 2 n ways to write down a face."""
    n = len(face)
    least = face.min()
    start = -1
    sense = 1
    for s in range(n):
        if face[s] != least:
            continue
        for way in (1, -1):
            smaller = start < 0
            for k in range(n):
                if smaller:
                    break
                new = face[(s + way * k) % n]
                old = face[(start + sense * k) % n]
                if new != old:
                    smaller = new < old
                    break
            if smaller:
                start = s
                sense = way
    result = np.empty(n, np.int32)
    for k in range(n):
        result[k] = face[(start + sense * k) % n]
    return result


@kernel
def _cut_face(points: Points, face: Int32Array, result: Int32Array) -> None:
    """Write the triangles (n - 2, 3) of one face (n,)."""
    corners = np.empty((len(face), 3))
    for k in range(len(face)):
        corners[k] = points[face[k]]
    triangulate_cheapest(corners, SHORTER, 0.0, result)
    for t in range(len(result)):
        for e in range(3):
            result[t, e] = face[result[t, e]]
