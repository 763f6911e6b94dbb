"""The shape of placed quads: which way they face, which are flipped, how far from square."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb._native.geometry.quadshape import squareness
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours, mean_of_neighbours
from patterndb.geometry.points import Floats, Points, units

#: A boundary this near to its plane, as a part of its diagonal, is planar: below it, files of
#: single precision and rotations leave nothing to tell.
PLANAR = 1e-6

#: A triangle of this part of its quad's longest squared edge has no area.
NO_AREA = 1e-9

#: Rounds in which normals are averaged over neighbours where no surface gives them: enough
#: that those of a fold are outvoted.
AVERAGED = 3


def quality(quads: Int32Array, vertices: Points) -> float:
    """How far the quads' angles are from right: the smaller, the squarer.

    quads: (q, 4) int32; vertices: (v, 3) float64. Returns radians squared: the deviations of
    the four angles of a quad from 90 degrees, squared and summed, and the mean of that over
    the quads (Marcias et al. 2015, section 4, "Geometric sorting": "the average quality of
    the quads"). 0 for rectangles; an angle beyond 180 degrees counts as such.
    """
    return float(squareness(np.ascontiguousarray(quads), np.ascontiguousarray(vertices)))


def plane_normal(points: Points, within: float = PLANAR) -> Points | None:
    """(3,) unit normal of a closed polygon (P, 3) that is planar, counter-clockwise; or None.

    within: how far a vertex may be from the plane, as a part of the polygon's diagonal.
    """
    middle = points.mean(axis=0)
    spokes = points - middle
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    if size <= NO_AREA * diagonal**2:
        return None
    normal = area / size
    return normal if float(np.abs(spokes @ normal).max()) <= within * diagonal else None


def own_normals(quads: Int32Array, vertices: Points, beside: Neighbours) -> Points:
    """(v, 3) unit normals of placed quads, smoothed so that a fold does not turn them."""
    corner = vertices[quads]
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    normals = np.zeros_like(vertices)
    for e in range(4):
        np.add.at(normals, quads[:, e], area)
    for _ in range(AVERAGED):
        normals = 0.5 * normals + 0.5 * mean_of_neighbours(beside.start, beside.neighbour, normals)
    return units(normals)


def flipped(quads: Int32Array, vertices: Points, normals: Points) -> NDArray[np.bool_]:
    """(q,) which quads are clockwise, cross themselves, or have no area.

    quads: (q, 4) int32; vertices: (v, 3); normals: (v, 3) unit normals of what the quads
    lie on. A quad is seen along the mean of its vertices' normals. It is sound if one of its
    diagonals cuts it into two counter-clockwise triangles; it may be concave.
    """
    up = units(normals[quads].sum(axis=1))
    corner = vertices[quads]
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(corner, 1, axis=1) - corner
    area = np.einsum("qec,qc->qe", np.cross(leaving, entering), up)
    longest = (leaving**2).sum(axis=2).max(axis=1, initial=0.0)
    positive = area > NO_AREA * longest[:, None]
    return ~((positive[:, 0] & positive[:, 2]) | (positive[:, 1] & positive[:, 3]))


def scaled_jacobian(quads: NDArray[np.integer], vertices: Points) -> Floats:
    """Return (q,) the scaled Jacobian of quads: 1 for a rectangle, 0 or less for a turned corner.

    Parameters
    ----------
    quads : (q, 4) int
        Vertices of each quad, in order.
    vertices : (v, 3) float64
        Places of the vertices.

    Returns
    -------
    (q,) float64
        The least over a quad's corners of the sine of the angle there, seen along the quad's own
        normal, the cross product of its diagonals.

    References
    ----------
    Knupp, "Algebraic mesh quality metrics for unstructured initial meshes", Finite Elements in
    Analysis and Design 39, 2003.
    """
    corner = vertices[quads]
    normal = units(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]))
    side = units((np.roll(corner, -1, axis=1) - corner).reshape(-1, 3)).reshape(-1, 4, 3)
    sine = np.einsum("qec,qc->qe", np.cross(np.roll(side, 1, axis=1), side), normal)
    return sine.min(axis=1, initial=1.0)


def find_turned_corners(quads: NDArray[np.integer], vertices: Points) -> NDArray[np.bool_]:
    """Find the corners (q, 4) of more than 180 degrees, seen across each quad's own diagonals.

    quads: (q, 4) vertex indices; vertices: (v, 3). There the scaled Jacobian is negative. A
    straight corner is none, nor is any of a quad whose diagonals are parallel.
    """
    corner = vertices[quads]
    up = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(corner, 1, axis=1) - corner
    area = np.einsum("qec,qc->qe", np.cross(leaving, entering), units(up))
    longest = (leaving**2).sum(axis=2).max(axis=1, initial=0.0)
    return area < -NO_AREA * longest[:, None]
