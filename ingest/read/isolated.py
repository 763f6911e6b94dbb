"""Letting a library read a file in a process of its own.

VTK and USD are large C++ libraries that trust their files: of a thousand damaged ones a few
end them by a segmentation fault, and some keep them busy for ever. Neither may end or block
a program that reads a folder of meshes, so each such file is read in a child process, with
bounds on its time and memory; what it hands back is checked here.

The child also keeps to itself what the libraries print, and the state they hold per process.
"""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ingest.read.assemble import assemble
from ingest.read.limits import ReadLimits
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError

# Exit codes of the child, apart from 0 and from those of an uncaught exception or a signal.
REFUSED = 3


@dataclass(frozen=True, slots=True)
class Polygons:
    """What a library found: points (v, 3), corners (c,) from 0, arities (f,)."""

    points: NDArray[np.floating]
    corners: NDArray[np.integer]
    arities: NDArray[np.integer]


class LibraryError(Exception):
    """What is wrong with the file, in words; the parent adds its name."""


def read_isolated(library: str, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The mesh that ``ingest.read.<library>`` finds in the file.

    Raises MeshFileError if it refuses the file, crashes, or exceeds a limit.
    """
    environment = dict(os.environ)
    # The child must find the packages this process found, however that came about.
    environment["PYTHONPATH"] = os.pathsep.join(entry or os.getcwd() for entry in sys.path)  # noqa: PTH109
    # One thread: a pool of them reserves address space by the core, and that is bounded.
    environment |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "ingest.read.child", library, os.path.abspath(path)]  # noqa: PTH100
    try:
        child = subprocess.run(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=limits.max_library_seconds,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise MeshFileError(
            f"{library} did not finish within {limits.max_library_seconds:g} s; "
            "the file is most likely damaged, export it again",
            path=path,
        ) from error
    if child.returncode == REFUSED:
        raise MeshFileError(child.stdout.decode("utf-8", "backslashreplace"), path=path)
    if child.returncode:
        raise MeshFileError(
            f"{library} crashed on the file ({_ending(child.returncode)}); "
            "it is most likely damaged, export it again",
            path=path,
        )
    try:
        found = unpack(child.stdout)
    except (ValueError, KeyError, OSError, zipfile.BadZipFile) as error:
        raise MeshFileError(f"{library} gave no mesh: {error}", path=path) from error
    return assemble(found.points, found.corners, found.arities, path, limits)


def pack(polygons: Polygons) -> bytes:
    """Polygons as bytes for :func:`unpack`; arrays only, nothing that runs on being read."""
    buffer = io.BytesIO()
    np.savez(buffer, points=polygons.points, corners=polygons.corners, arities=polygons.arities)
    return buffer.getvalue()


def unpack(data: bytes) -> Polygons:
    """The polygons in the bytes that :func:`pack` gave."""
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        found: dict[str, NDArray[Any]] = {name: arrays[name] for name in arrays.files}
    return Polygons(**found)


def _ending(code: int) -> str:
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"
