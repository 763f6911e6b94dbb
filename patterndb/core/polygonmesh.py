"""A polygon mesh as a file gives it: points, and faces of any arity over their indices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.errors import InvalidMeshError
from patterndb.verbs import MeshVerbs


@dataclass(frozen=True, slots=True, eq=False)
class PolygonMesh(MeshVerbs):
    """Points and faces, nothing triangulated and no vertex split.

    points:  (v, 3) float64, in the file's own units and axes.
    corners: (c,) int32, the vertex indices of all faces, face after face.
    offsets: (f + 1,) int64; face i is ``corners[offsets[i]:offsets[i + 1]]``.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.int32]
    offsets: NDArray[np.int64]

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise InvalidMeshError(f"points must be (v, 3), got {self.points.shape}")
        if self.offsets.ndim != 1 or len(self.offsets) < 1 or self.offsets[0] != 0:
            raise InvalidMeshError("offsets must be (f + 1,) and start at 0")
        if self.offsets[-1] != len(self.corners) or (np.diff(self.offsets) < 0).any():
            raise InvalidMeshError("offsets must ascend and end at the number of corners")
        if len(self.corners) and (self.corners.min() < 0 or self.corners.max() >= len(self.points)):
            raise InvalidMeshError(
                f"a face names a vertex outside 0..{len(self.points) - 1}: "
                f"indices run from {self.corners.min()} to {self.corners.max()}"
            )

    @classmethod
    def from_faces(
        cls, points: ArrayLike, faces: ArrayLike | Sequence[Sequence[int]]
    ) -> PolygonMesh:
        """The mesh of (v, 3) points and of faces: (q, k) vertex indices, or a list of lists.

        Raises InvalidMeshError for faces that are none, or that name a vertex there is not.
        """
        try:
            places = np.array(points, np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidMeshError(f"points must be (v, 3) numbers ({error})") from error
        corners, arities = flatten_faces(faces)
        if places.size == 0:
            places = places.reshape(0, 3)
        return cls(places, corners.astype(np.int32), np.r_[0, np.cumsum(arities)].astype(np.int64))

    @property
    def n_faces(self) -> int:
        return len(self.offsets) - 1

    def arities(self) -> NDArray[np.int64]:
        """(f,) number of corners of every face."""
        return np.diff(self.offsets)

    def quads(self) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
        """The four-sided faces with four distinct vertices, in file order.

        Returns ((q, 4) int32 vertices, (q,) int64 the faces' places in the file).
        """
        faces = np.flatnonzero(self.arities() == 4)
        quads = self.corners[self.offsets[faces][:, None] + np.arange(4)]
        ordered = np.sort(quads, axis=1)
        good = (ordered[:, 1:] != ordered[:, :-1]).all(axis=1)
        return np.ascontiguousarray(quads[good]), faces[good]

    def fans(self) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
        """Every face as a fan of triangles from its first corner.

        Returns ((t, 3) int32 vertices, (t,) int64 the faces that they are of, ascending).
        """
        fans = np.maximum(self.arities() - 2, 0)
        face = np.repeat(np.arange(self.n_faces), fans)
        k = np.arange(len(face)) - np.repeat(np.cumsum(fans) - fans, fans)
        first = self.offsets[face]
        return self.corners[np.stack([first, first + k + 1, first + k + 2], axis=1)], face

    def faces(self) -> list[list[int]]:
        """The vertices of every face."""
        ends = self.offsets.tolist()
        corners = self.corners.tolist()
        return [corners[a:b] for a, b in pairwise(ends)]


def flatten_faces(
    faces: ArrayLike | Sequence[Sequence[int]],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the vertices of all faces, face after face, and how many each has.

    faces: (q, 4) vertex indices, or those of another arity, or a sequence of faces of any
    arity. Raises InvalidMeshError for indices that are no whole numbers in 0..2**31 - 1.
    """
    if isinstance(faces, np.ndarray):
        array = _as_indices(cast("NDArray[Any]", faces))
        if array.size == 0:
            array = array.reshape(0, 4)
        if array.ndim != 2:
            raise InvalidMeshError(f"quads must be (q, 4), got {array.shape}")
        return array.ravel(), np.full(len(array), array.shape[1], np.int64)
    try:
        rows = [_as_indices(np.asarray(face)) for face in cast("Sequence[ArrayLike]", faces)]
    except (TypeError, ValueError) as error:
        raise InvalidMeshError(
            f"the faces must be lists of vertex indices, or a (q, 4) array ({error})"
        ) from error
    if any(row.ndim != 1 for row in rows):
        raise InvalidMeshError("every face must be a list of vertex indices")
    sizes = np.array([len(row) for row in rows], np.int64)
    return (np.concatenate(rows) if rows else np.zeros(0, np.int64)), sizes


def _as_indices(values: NDArray[np.generic]) -> NDArray[np.int64]:
    if values.size == 0:
        return values.astype(np.int64)
    if values.dtype.kind not in "iu":
        raise InvalidMeshError(f"vertex indices must be whole numbers, not {values.dtype}")
    if values.min() < 0 or values.max() >= 2**31:
        raise InvalidMeshError("vertex indices must lie in 0..2**31 - 1")
    return values.astype(np.int64)
