"""A mesh given by a program as arrays: its faces, and the bytes by which it is known.

A mesh file is known by its bytes; arrays have none, so they are written down in one way:
``MAGIC``, the number of faces, the number of corners of every face, and the vertices of all
faces one after the other, each number as four bytes, lowest first. Vertices are renamed in
the order in which they first appear, so that neither their names nor unused ones matter; the
order of the faces does, for examples of patches name them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError

#: No mesh file begins so: a mesh given as arrays is never taken for a file.
MAGIC = b"patterndb mesh of arrays 1\n"


def mesh_of_arrays(faces: PolygonMesh | ArrayLike | Sequence[Sequence[int]]) -> PolygonMesh:
    """The mesh of (q, 4) vertex indices, or of a sequence of faces of any arity.

    Vertices are named anew (see above); the points are all 0, for patterns need none. Raises
    InvalidMeshError for indices that are no whole numbers in 0..2**31 - 1.
    """
    if isinstance(faces, PolygonMesh):
        flat, sizes = faces.corners, faces.arities()
    elif isinstance(faces, np.ndarray):
        array = _indices(faces)
        if array.size == 0:
            array = array.reshape(0, 4)
        if array.ndim != 2:
            raise InvalidMeshError(f"quads must be (q, 4), got {array.shape}")
        flat, sizes = array.ravel(), np.full(len(array), array.shape[1], np.int64)
    else:
        try:
            rows = [_indices(np.asarray(face)) for face in faces]  # pyright: ignore[reportGeneralTypeIssues]
        except (TypeError, ValueError) as error:
            raise InvalidMeshError(
                f"the faces must be lists of vertex indices, or a (q, 4) array ({error})"
            ) from error
        if any(row.ndim != 1 for row in rows):
            raise InvalidMeshError("every face must be a list of vertex indices")
        sizes = np.array([len(row) for row in rows], np.int64)
        flat = np.concatenate(rows) if rows else np.zeros(0, np.int64)
    _, first, name = np.unique(flat, return_index=True, return_inverse=True)
    place = np.empty(len(first), np.int32)
    place[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return PolygonMesh(
        np.zeros((len(first), 3)),
        place[name.reshape(-1)].astype(np.int32),
        np.r_[0, np.cumsum(sizes)].astype(np.int64),
    )


def _indices(values: NDArray[np.generic]) -> NDArray[np.int64]:
    if values.size == 0:
        return values.astype(np.int64)
    if values.dtype.kind not in "iu":
        raise InvalidMeshError(f"vertex indices must be whole numbers, not {values.dtype}")
    if values.min() < 0 or values.max() >= 2**31:
        raise InvalidMeshError("vertex indices must lie in 0..2**31 - 1")
    return values.astype(np.int64)


def canonical_bytes(mesh: PolygonMesh) -> bytes:
    """What a mesh of :func:`mesh_of_arrays` is known by, see above."""
    numbers = np.concatenate([[mesh.n_faces], mesh.arities(), mesh.corners])
    return MAGIC + numbers.astype("<u4").tobytes()
