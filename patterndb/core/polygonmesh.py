"""A polygon mesh as a file gives it: points, and faces of any arity over their indices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import InvalidMeshError


@dataclass(frozen=True, slots=True, eq=False)
class PolygonMesh:
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
