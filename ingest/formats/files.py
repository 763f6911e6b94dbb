"""What every reader begins with, and ends with.

It begins with limits on what a file may ask for, and with the bytes of a file that may be
anything at all; it ends with a PolygonMesh that holds what it promises.
"""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError
from patterndb.system.files import IRREGULAR, open_regular

MIB = 2**20


@dataclass(frozen=True, slots=True)
class ReadLimits:
    """Bounds beyond which a file is refused, checked before memory is spent on it.

    max_bytes: size of the file, in bytes. 512 MiB is some five million quads of OBJ text
        with texture coordinates; what is larger is a scan or a mistake, not made by hand.
    max_line_bytes: length of a line of text (continued lines joined), and of a PLY header,
        in bytes. A face of 100,000 corners with texture coordinates and normals takes some
        3 MiB; the limit stops a binary file that was named ``.obj``.
    max_arity: corners of one face. Hand-made polygons have a handful, caps of cylinders a
        hundred, outlines that a CAD program cut finely some thousands; beyond, a number of
        corners was most likely read from the wrong place.
    max_library_seconds: time that VTK or USD may spend on a file. The largest file within
        max_bytes takes them some twenty seconds; damaged ones can keep them busy for ever.
    """

    max_bytes: int = 512 * MIB
    max_line_bytes: int = 4 * MIB
    max_arity: int = 100_000
    max_library_seconds: float = 60.0


DEFAULT_LIMITS = ReadLimits()


def load_file(path: str | Path, limits: ReadLimits = DEFAULT_LIMITS) -> bytes:
    """The bytes of a regular file within the size limit.

    A symbolic link is followed: libraries of meshes are often trees of links. What it
    leads to must be a regular file; a pipe or a device could block or never end.

    Raises MeshFileError if the file is missing, unreadable, empty, too large or not regular.
    """
    check_file(path, limits)
    try:
        # Between the check and here the path may have become another file, so that what is open
        # is checked again, and the read is bounded.
        with open_regular(path) as file:
            _check_status(os.fstat(file.fileno()), path, limits)
            data = file.read(limits.max_bytes + 1)
    except OSError as error:
        raise _unreadable(path, error) from error
    if len(data) > limits.max_bytes:
        raise MeshFileError("the file grew over the size limit while it was read", path=path)
    return data


def check_file(path: str | Path, limits: ReadLimits) -> None:
    """Refuse, by its status alone, a file that :func:`load_file` would refuse.

    For the readers that leave the reading to a library and hand it the path.
    """
    try:
        status = os.stat(path)  # noqa: PTH116 (a str with a NUL byte must reach the except below)
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    _check_status(status, path, limits)


def _check_status(status: os.stat_result, path: str | Path, limits: ReadLimits) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise MeshFileError("this is a folder; name a mesh file in it", path=path)
    if not stat.S_ISREG(status.st_mode):
        raise MeshFileError(IRREGULAR, path=path)
    if status.st_size == 0:
        raise MeshFileError("the file is empty; export the mesh again", path=path)
    if status.st_size > limits.max_bytes:
        raise MeshFileError(
            f"the file has {status.st_size:,} bytes, over the limit of {limits.max_bytes:,}; "
            "split the mesh, or raise the limit (max_bytes, --max-bytes)",
            path=path,
        )


def _unreadable(path: str | Path, error: Exception) -> MeshFileError:
    reason = getattr(error, "strerror", None) or str(error)
    return MeshFileError(f"the file cannot be read: {reason}", path=path)


_MAX_POINTS = np.iinfo(np.int32).max


def explain_arity(arity: int, limits: ReadLimits) -> str:
    """Say why no face may have so many corners, and what to do."""
    if arity < 3:
        return f"has {arity} corners; 3 are the fewest: delete the face"
    return (
        f"has {arity:,} corners; {limits.max_arity:,} are the most: cut the face into smaller ones"
    )


def explain_index(corners: NDArray[np.integer], n_points: int) -> str:
    """Say which vertices there are, where a face names another: (c,) corners of all faces."""
    if n_points and len(corners) and corners.min() == 1 and corners.max() == n_points:
        return (
            f"but the vertices are 0 to {n_points - 1}; the faces of this file count from 1: "
            "subtract 1 from each index"
        )
    return f"but the vertices are 0 to {n_points - 1}"


def assemble(
    points: NDArray[np.floating],
    corners: NDArray[np.integer],
    arities: NDArray[np.integer],
    path: str | Path,
    limits: ReadLimits,
) -> PolygonMesh:
    """The mesh of points (v, 3), corners (c,) from 0 and arities (f,).

    The text readers have refused by line what is refused here by number alone; for the
    formats that a library reads, this is the check.

    Raises MeshFileError on a coordinate that is not finite, a corner outside 0..v-1, a face
    of fewer than 3 corners or more than the limit, and a mesh without faces.
    """
    if not len(arities):
        raise MeshFileError("the file holds no faces; export polygons, not points", path=path)
    if len(points) > _MAX_POINTS:
        raise MeshFileError(f"{len(points):,} vertices are more than 32 bits can number", path=path)
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        at = int(np.argmin(finite))
        raise MeshFileError(
            f"vertex {at} (counted from 0) is not finite: {points[at].tolist()}; repair it",
            path=path,
        )
    wrong_arity = (arities < 3) | (arities > limits.max_arity)
    if wrong_arity.any():
        face = int(wrong_arity.argmax())
        raise MeshFileError(
            f"face {face} (counted from 0) {explain_arity(int(arities[face]), limits)}", path=path
        )
    offsets = np.concatenate(([0], np.cumsum(arities, dtype=np.int64)))
    if offsets[-1] != len(corners):
        raise MeshFileError(
            f"the faces need {offsets[-1]} corners, but {len(corners)} are given", path=path
        )
    outside = (corners < 0) | (corners >= len(points))
    if outside.any():
        corner = int(outside.argmax())
        face = int(np.searchsorted(offsets, corner, side="right")) - 1
        raise MeshFileError(
            f"face {face} (counted from 0) names vertex {corners[corner]}, "
            + explain_index(corners, len(points)),
            path=path,
        )
    return PolygonMesh(
        points=np.ascontiguousarray(points, dtype=np.float64),
        corners=corners.astype(np.int32),
        offsets=offsets,
    )
