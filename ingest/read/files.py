"""Reading the bytes of a file that may be anything at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ingest.read.limits import DEFAULT_LIMITS, ReadLimits
from patterndb.errors import MeshFileError


def load_file(path: str | Path, limits: ReadLimits = DEFAULT_LIMITS) -> bytes:
    """The bytes of a regular file within the size limit.

    A symbolic link is followed: libraries of meshes are often trees of links. What it
    leads to must be a regular file; a pipe or a device could block or never end.

    Raises MeshFileError if the file is missing, unreadable, empty, too large or not regular.
    """
    check_file(path, limits)
    try:
        # Between the check and here the path may have become a pipe: O_NONBLOCK lets
        # the open return, the descriptor is checked again, and the read is bounded.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | _O_BINARY)
        with os.fdopen(descriptor, "rb") as file:
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


_O_BINARY: int = getattr(os, "O_BINARY", 0)  # Windows alone translates line ends without it


def _check_status(status: os.stat_result, path: str | Path, limits: ReadLimits) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise MeshFileError("this is a directory; name a mesh file in it", path=path)
    if not stat.S_ISREG(status.st_mode):
        raise MeshFileError(
            "not a regular file but a pipe, socket or device; write it to a file first", path=path
        )
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
