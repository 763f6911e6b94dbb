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
from numpy.typing import ArrayLike

from patterndb.core.polygonmesh import PolygonMesh, flatten_faces

#: No mesh file begins so: a mesh given as arrays is never taken for a file.
MAGIC = b"patterndb mesh of arrays 1\n"


def mesh_of_arrays(faces: PolygonMesh | ArrayLike | Sequence[Sequence[int]]) -> PolygonMesh:
    """The mesh of (q, 4) vertex indices, or of a sequence of faces of any arity.

    Vertices are named anew (see above); the points are all 0, for patterns need none. Raises
    InvalidMeshError for indices that are no whole numbers in 0..2**31 - 1.
    """
    if isinstance(faces, PolygonMesh):
        flat, sizes = faces.corners, faces.arities()
    else:
        flat, sizes = flatten_faces(faces)
    _, first, name = np.unique(flat, return_index=True, return_inverse=True)
    place = np.empty(len(first), np.int32)
    place[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return PolygonMesh(
        np.zeros((len(first), 3)),
        place[name.reshape(-1)].astype(np.int32),
        np.r_[0, np.cumsum(sizes)].astype(np.int64),
    )


def canonical_bytes(mesh: PolygonMesh) -> bytes:
    """What a mesh of :func:`mesh_of_arrays` is known by, see above."""
    numbers = np.concatenate([[mesh.n_faces], mesh.arities(), mesh.corners])
    return MAGIC + numbers.astype("<u4").tobytes()
