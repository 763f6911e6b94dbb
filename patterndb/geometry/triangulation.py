"""Any polygons -> triangles, as they stand or whichever way they were written down.

:func:`cut_faces` keeps the vertices and the sense of a mesh's faces. The other functions are for
triangles that do not depend on how the polygons were written: points at the same place are one,
points are sorted by place, triangles by their points, so that the order, the sense and the first
corner of faces no longer matter, nor do split vertices.
"""

# scipy has no types: what it returns is typed by the functions' own annotations.
# pyright: reportMissingTypeStubs=false, reportUnknownVariableType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb._native.geometry.earclipping import clip_ears
from patterndb._native.geometry.triangulation import cut, cut_chosen, write_once
from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points

#: Points this close, as a share of the diagonal, are one: coordinates in files have some seven
#: digits, computed ones fifteen.
WELD = 1e-9

#: The most corners of a face of which the least area is sought: time grows with the cube, and is
#: a millisecond here. Faces of more corners are cut in their plane.
MOST_EXACT = 128

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
    # Imported here because drawing and placing load this module, and need no tree.
    from scipy.spatial import KDTree

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
    faces are covered once, which a fan from one corner does not do. Faces of more than MOST_EXACT
    corners are cut in their plane (rust/geometry/src/earclipping.rs).

    Source: the dynamic programme of Barequet and Sharir 1995, "Filling gaps in the boundary of
    a polyhedron".
    """
    arity = np.diff(offsets)
    corners, offsets = corners.astype(np.int32), offsets.astype(np.int64)
    pieces = cut(points, corners, offsets)
    rows = _first_rows(arity)
    for f in np.flatnonzero(arity > MOST_EXACT).tolist():
        face = write_once(corners[offsets[f] : offsets[f + 1]])
        _clip(points, face, pieces[rows[f] : rows[f + 1]])
    sound = (
        (pieces[:, 0] != pieces[:, 1])
        & (pieces[:, 1] != pieces[:, 2])
        & (pieces[:, 2] != pieces[:, 0])
    )
    dropped = int((~sound).sum() + (arity < 3).sum())
    return pieces[sound], dropped


def cut_faces(mesh: PolygonMesh, *, fan_quads: bool = True) -> tuple[Int32Array, NDArray[np.int64]]:
    """Cut the faces of a mesh into triangles of its vertices, each in the sense of its face.

    Faces become triangles that cover them once and have the least area, concave faces too; quads
    become fans from their first corner, or with ``fan_quads=False`` the same as other faces.
    Returns ((t, 3) vertices, (t,) the faces that they are of, ascending).
    """
    triangles, face = mesh.fans()
    arity = mesh.arities()
    rows = _first_rows(arity)
    chosen = np.flatnonzero((arity > (4 if fan_quads else 3)) & (arity <= MOST_EXACT))
    if len(chosen):
        cut_chosen(mesh.points, mesh.corners, mesh.offsets, rows, chosen, triangles)
    for f in np.flatnonzero(arity > MOST_EXACT).tolist():
        corners = mesh.corners[mesh.offsets[f] : mesh.offsets[f + 1]]
        _clip(mesh.points, corners, triangles[rows[f] : rows[f + 1]])
    return triangles, face


def sort_triangles(triangles: Int32Array) -> tuple[Int32Array, int]:
    """((t, 3) triangles, each ascending and once, sorted; how many repeated others)."""
    ascending = np.sort(triangles, axis=1)
    ascending = ascending[np.lexsort(ascending.T[::-1])]
    fresh = np.ones(len(ascending), np.bool_)
    fresh[1:] = (ascending[1:] != ascending[:-1]).any(axis=1)
    return np.ascontiguousarray(ascending[fresh]), int((~fresh).sum())


def _first_rows(arity: NDArray[np.int64]) -> NDArray[np.int64]:
    """(f + 1,) the first triangle of every face, and how many there are."""
    return np.r_[0, np.cumsum(np.maximum(arity - 2, 0))]


def _clip(points: Points, face: Int32Array, result: Int32Array) -> None:
    """Write the triangles (n - 2, 3) of one face (n,) of many corners."""
    clip_ears(np.ascontiguousarray(points[face]), result)
    result[:] = face[result]
