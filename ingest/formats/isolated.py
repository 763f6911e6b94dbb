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
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ingest.formats.files import ReadLimits, assemble
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError

# Exit codes of the child, apart from 0 and from those of an uncaught exception or a signal.
REFUSED = 3

_CHILD = "from ingest.formats.isolated import answer_parent; answer_parent()"


@dataclass(frozen=True, slots=True)
class Polygons:
    """What a library found: points (v, 3), corners (c,) from 0, arities (f,)."""

    points: NDArray[np.floating]
    corners: NDArray[np.integer]
    arities: NDArray[np.integer]


class LibraryError(Exception):
    """What is wrong with the file, in words; the parent adds its name."""


def read_isolated(library: str, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The mesh that ``find_polygons`` of ``ingest.formats.<library>`` finds in the file.

    Raises MeshFileError if it refuses the file, crashes, or exceeds a limit.
    """
    environment = dict(os.environ)
    # The child must find the packages this process found, however that came about.
    environment["PYTHONPATH"] = os.pathsep.join(entry or os.getcwd() for entry in sys.path)  # noqa: PTH109
    # One thread: a pool of them reserves address space by the core, and that is bounded.
    environment |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    # -P: a file of the user's in the working directory must not stand in for a module.
    command = [sys.executable, "-P", "-c", _CHILD, library, os.path.abspath(path)]  # noqa: PTH100
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


# From here on, what runs in the child process

# The libraries alone take up to 1.3 GiB of addresses, more with more cores; a mesh takes a few
# times its file's size, compressed ones more.
_ADDRESS_BYTES = 6 * 2**30
_ADDRESS_BYTES_PER_FILE_BYTE = 32


def answer_parent() -> None:
    """Read the file that the command line names, and end the process.

    Writes the packed polygons to stdout, or exits with REFUSED and the reason there.
    """
    library, path = sys.argv[1:]
    # What a library prints must not end up in the answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    _bound_memory(Path(path).stat().st_size)
    try:
        code, data = 0, pack(import_module(f"ingest.formats.{library}").find_polygons(path))
    except LibraryError as error:
        code, data = REFUSED, str(error).encode("utf-8", "backslashreplace")
    with os.fdopen(answer, "wb") as pipe:
        pipe.write(data)
    # Not sys.exit: the libraries' own clean-up may crash, with the answer already given.
    os._exit(code)


def _bound_memory(file_bytes: int) -> None:
    """Bound this process's memory, where the system can, and leave no core files behind."""
    try:
        import resource
    except ImportError:  # Windows
        return
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    wanted = _ADDRESS_BYTES + _ADDRESS_BYTES_PER_FILE_BYTE * file_bytes
    if most == resource.RLIM_INFINITY or wanted < most:
        resource.setrlimit(resource.RLIMIT_AS, (wanted, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
