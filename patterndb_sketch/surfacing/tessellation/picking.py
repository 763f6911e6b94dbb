"""Picking points of a mesh by rays, and drawing strokes on it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points, as_points
from patterndb.geometry.surface import Surface
from patterndb_sketch.surfacing.tessellation.triangles import split_quads


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

    _mesh: Surface
    _owner: NDArray[np.int64]

    @classmethod
    def of(cls, points: ArrayLike, faces: ArrayLike) -> Canvas:
        """From points (v, 3) and faces, triangles (f, 3) or quads (f, 4), seen from both sides.

        Quads are cut as :func:`patterndb_sketch.surfacing.tessellation.triangles.split_quads`
        cuts them, which also says what raises InvalidMeshError.
        """
        at, triangles, owner = split_quads(points, faces)
        return cls(Surface(at, triangles.astype(np.int32)), owner)

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
        triangle, weights = self._mesh.cast_ahead(begin, toward)
        met = triangle >= 0
        face = np.full(len(begin), -1, np.int64)
        points = np.full((len(begin), 3), np.nan)
        face[met] = self._owner[triangle[met]]
        points[met] = self._mesh.interpolate_points(triangle[met], weights[met])
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
