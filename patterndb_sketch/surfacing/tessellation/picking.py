"""Picking points of a mesh by rays, and drawing strokes on it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points, as_points
from patterndb.geometry.tree import DEPTH, SLACK, build
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.tessellation.triangles import split_quads

#: A ray whose angle with a triangle's plane has a sine below this runs along it and does not
#: hit it.
EDGE_ON = 1e-9


@dataclass(frozen=True, slots=True)
class Pick:
    """Where a ray first meets a mesh.

    face: which face. point: (3,) float64, on it. distance: from the ray's origin, in the units
    of the points.
    """

    face: int
    point: Points
    distance: float


@dataclass(frozen=True, slots=True)
class SurfaceStroke:
    """A stroke drawn on a mesh.

    strokes: its parts, each (k, 3) points on the mesh, k >= 1; the stroke breaks where rays
             miss. Between its points a stroke is straight and may leave a curved mesh.
    rays:    for every part the rays (k,) int64 that its points are of.
    missed:  (j,) int64, the rays that meet nothing.
    """

    strokes: tuple[Points, ...] = field(repr=False)
    rays: tuple[NDArray[np.int64], ...] = field(repr=False)
    missed: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Canvas:
    """A mesh made ready for many picks; see :meth:`of`."""

    _corners: Points
    _owner: NDArray[np.int64]
    _tree: tuple[Points, Int32Array, Int32Array]

    @classmethod
    def of(cls, points: ArrayLike, faces: ArrayLike) -> Canvas:
        """From points (v, 3) and faces, triangles (f, 3) or quads (f, 4), seen from both sides.

        Quads are cut as :func:`patterndb_sketch.surfacing.tessellation.triangles.split_quads`
        cuts them, which also says what raises InvalidMeshError.
        """
        at, triangles, owner = split_quads(points, faces)
        corners = np.ascontiguousarray(at[triangles])
        return cls(corners, owner, build(corners))

    def pick(self, origin: ArrayLike, direction: ArrayLike) -> Pick | None:
        """Find the first point of the mesh on a ray from origin (3,) along direction (3,), or None.

        The direction may have any length but 0. The point is on the mesh to rounding. Where
        two faces are equally near, it is the first of them. Raises InvalidMeshError for a ray
        that is none.
        """
        face, points, distances = self.picks(np.asarray(origin)[None], np.asarray(direction)[None])
        return Pick(int(face[0]), points[0], float(distances[0])) if face[0] >= 0 else None

    def picks(
        self, origins: ArrayLike, directions: ArrayLike
    ) -> tuple[NDArray[np.int64], Points, NDArray[np.float64]]:
        """As :meth:`pick` for rays (k, 3), (k, 3): faces (k,), points (k, 3), distances (k,).

        A ray that meets nothing has face -1, and NaN for the others.
        """
        begin = as_points(origins, "the rays' origins", InvalidMeshError)
        toward = as_points(directions, "the rays' directions", InvalidMeshError)
        if len(begin) != len(toward):
            raise InvalidMeshError(
                f"{len(begin)} origins do not go with {len(toward)} directions; give one each"
            )
        lengths = np.linalg.norm(toward, axis=1)
        bad = np.flatnonzero(lengths == 0.0)
        if len(bad):
            raise InvalidMeshError(f"the direction of ray {bad[0]} has no length")
        toward /= lengths[:, None]
        triangle, weights = _first_ahead(self._corners, *self._tree, begin, toward)
        met = triangle >= 0
        face = np.full(len(begin), -1, np.int64)
        points = np.full((len(begin), 3), np.nan)
        face[met] = self._owner[triangle[met]]
        points[met] = np.einsum("ne,nec->nc", weights[met], self._corners[triangle[met]])
        return face, points, np.einsum("nc,nc->n", points - begin, toward)

    def draw(self, origins: ArrayLike, directions: ArrayLike) -> SurfaceStroke:
        """Draw the stroke of rays (k, 3), (k, 3) in a row, broken where they miss."""
        face, points, _ = self.picks(origins, directions)
        met = np.flatnonzero(face >= 0)
        parts = np.split(met, 1 + np.flatnonzero(np.diff(met) > 1)) if len(met) else []
        return SurfaceStroke(
            tuple(points[part] for part in parts), tuple(parts), np.flatnonzero(face < 0)
        )


def pick(
    points: ArrayLike, faces: ArrayLike, origin: ArrayLike, direction: ArrayLike
) -> Pick | None:
    """See :meth:`Canvas.pick`; make a Canvas for more than one ray."""
    return Canvas.of(points, faces).pick(origin, direction)


def draw(
    points: ArrayLike, faces: ArrayLike, origins: ArrayLike, directions: ArrayLike
) -> SurfaceStroke:
    """See :meth:`Canvas.draw`; make a Canvas for more than one stroke."""
    return Canvas.of(points, faces).draw(origins, directions)


@kernel
def _entered(boxes: Points, b: Index, origin: Points, direction: Points) -> float:
    """How far along a ray it comes into box b, infinity if it does not."""
    low, high = 0.0, np.inf
    for c in range(3):
        d = direction[c]
        if abs(d) < 1e-300:
            if origin[c] < boxes[b, 0, c] or origin[c] > boxes[b, 1, c]:
                return np.inf
        else:
            one = (boxes[b, 0, c] - origin[c]) / d
            two = (boxes[b, 1, c] - origin[c]) / d
            low = max(low, min(one, two))
            high = min(high, max(one, two))
    # Boxes of triangles across the axes are flat: rounding must not make them empty.
    return low if low <= high + 1e-12 * (1.0 + abs(high)) else np.inf


@kernel
def _hit(corner: Points, origin: Points, direction: Points) -> tuple[float, float, float]:
    """How far along a ray it meets a triangle (3, 3), and the weights of its last two corners
    there; infinity if it does not."""
    ax, ay, az = corner[0, 0], corner[0, 1], corner[0, 2]
    ux, uy, uz = corner[1, 0] - ax, corner[1, 1] - ay, corner[1, 2] - az
    vx, vy, vz = corner[2, 0] - ax, corner[2, 1] - ay, corner[2, 2] - az
    x, y, z = ax - origin[0], ay - origin[1], az - origin[2]
    # The triangle's normal, twice its area long.
    mx, my, mz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(mx * mx + my * my + mz * mz)
    facing = mx * direction[0] + my * direction[1] + mz * direction[2]
    if abs(facing) <= EDGE_ON * size:
        return np.inf, 0.0, 0.0
    s = (x * mx + y * my + z * mz) / facing
    if s < 0.0:
        return np.inf, 0.0, 0.0
    x, y, z = s * direction[0] - x, s * direction[1] - y, s * direction[2] - z
    cx, cy, cz = uy * z - uz * y, uz * x - ux * z, ux * y - uy * x
    w = (cx * mx + cy * my + cz * mz) / (size * size)
    cx, cy, cz = y * vz - z * vy, z * vx - x * vz, x * vy - y * vx
    v = (cx * mx + cy * my + cz * mz) / (size * size)
    if v < -SLACK or w < -SLACK or v + w > 1.0 + SLACK:
        return np.inf, 0.0, 0.0
    return s, v, w


@kernel
def _first_ahead(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    origins: Points,
    directions: Points,
) -> tuple[Int32Array, Points]:
    """(n,) the triangle that each ray meets first, -1 for none, and (n, 3) weights there.

    Unlike :func:`patterndb.geometry.tree.first_along` only ahead, and from both sides.
    """
    triangle = np.full(len(origins), -1, np.int32)
    weights = np.zeros((len(origins), 3))
    if len(corners) == 0:
        return triangle, weights
    stack = np.empty(DEPTH, np.int32)
    for i in range(len(origins)):
        origin, direction = origins[i], directions[i]
        best = np.inf
        stack[0] = 0
        top = 1
        while top:
            top -= 1
            b = stack[top]
            entered = _entered(boxes, b, origin, direction)
            if entered == np.inf or entered > best + 1e-12 * (1.0 + best):
                continue
            if nodes[b, 1] < 0:
                near = nodes[b, 0]
                far = near + 1
                if _entered(boxes, near, origin, direction) > _entered(
                    boxes, far, origin, direction
                ):
                    near, far = far, near
                stack[top] = far
                stack[top + 1] = near
                top += 2
                continue
            for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
                f = order[k]
                s, v, w = _hit(corners[f], origin, direction)
                if s < best or (s == best and s < np.inf and f < triangle[i]):
                    best = s
                    triangle[i] = f
                    # Onto the triangle, if the slack let in a ray beside it.
                    v = min(max(v, 0.0), 1.0)
                    w = min(max(w, 0.0), 1.0 - v)
                    weights[i, 0] = 1.0 - v - w
                    weights[i, 1] = v
                    weights[i, 2] = w
    return triangle, weights
