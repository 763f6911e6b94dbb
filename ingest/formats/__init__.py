"""Mesh files as their authors made them: every polygon, and the file's own vertex indices.

    mesh = read_mesh("penguin.obj")
    write_mesh("copy.ply", mesh)

or, where the bytes are wanted as well (to hash them, say), in two steps:

    data = load_file("penguin.obj")
    mesh = parse(data, "penguin.obj")

General mesh libraries triangulate, merge or split vertices on the way in; a pattern is made
of exactly what they lose.

``FORMATS`` is the one table of what can be read and written; the command line, the messages,
the documentation and the tests follow it. Read in this order: files (how every reader begins
and ends), grammar (numbers and tokens of text), obj, plyheader, plybody and ply, off, then
isolated, vtk and usd, whose files a library reads in a process of its own.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ingest.formats import obj, off, ply, stl, threemf, usd, vtk
from ingest.formats.files import DEFAULT_LIMITS, ReadLimits, load_file
from ingest.formats.meshformat import MeshFormat
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError, MeshFileError, UnsupportedFormatError
from patterndb.system.files import explain_compression, open_regular, replace_file

__all__ = [
    "FORMATS",
    "PRINTED",
    "SUPPORTED_SUFFIXES",
    "WRITTEN_SUFFIXES",
    "MeshFormat",
    "ReadLimits",
    "find_format",
    "list_format_names",
    "load_file",
    "parse",
    "read_mesh",
    "write_mesh",
]

#: All mesh formats; one more is a module beside these, and its entry here.
FORMATS: tuple[MeshFormat, ...] = (obj.FORMAT, ply.FORMAT, *vtk.FORMATS, usd.FORMAT, off.FORMAT)

#: Formats of triangles that printers read: they are written, and not read.
PRINTED: tuple[MeshFormat, ...] = (stl.FORMAT, threemf.FORMAT)

#: Suffixes of the files that can be read.
SUPPORTED_SUFFIXES: tuple[str, ...] = tuple(s for format in FORMATS for s in format.suffixes)

#: Suffixes of the files that can be written.
WRITTEN_SUFFIXES: tuple[str, ...] = tuple(
    suffix for format in (*FORMATS, *PRINTED) if format.spell for suffix in format.suffixes
)

_BY_SUFFIX = {suffix: format for format in FORMATS for suffix in format.suffixes}
_TRIANGLES_ONLY = {
    **{suffix: format.name for format in PRINTED for suffix in format.suffixes},
    ".gltf": "glTF",
    ".glb": "glTF",
}


def read_mesh(path: str | Path, *, limits: ReadLimits = DEFAULT_LIMITS) -> PolygonMesh:
    """Read the polygon mesh in a file, by the file's suffix.

    Raises MeshFileError, with file, line and token, on a file that is damaged, over a limit
    or without faces; UnsupportedFormatError on a format that is unknown or cannot hold quads;
    MissingExtraError on a VTK or USD file where the extra that reads it is not installed.

    Example: ``quads, faces = read_mesh("penguin.obj").quads()``
    """
    try:
        form = find_format(path)
    except UnsupportedFormatError:
        # A 3MF file is an archive, and has a message of its own.
        if not any(Path(path).suffix.lower() in form.suffixes for form in PRINTED):
            _refuse_by_content(path)
        raise
    form.require()
    return parse(load_file(path, limits), path, limits)


def parse(data: bytes, path: str | Path, limits: ReadLimits = DEFAULT_LIMITS) -> PolygonMesh:
    """Return the polygon mesh in the bytes of a file, by the suffix of ``path``.

    data: what :func:`load_file` gave for ``path``. OBJ, PLY and OFF are read from it alone,
    and ``path`` need not exist; the libraries behind VTK and USD open ``path`` themselves.

    Raises what :func:`read_mesh` raises.
    """
    format = find_format(path)
    packed = explain_compression(data)
    # A scene of USD in one file is a zip file.
    is_scene = data.startswith(b"PK") and Path(path).suffix.lower() == ".usdz"
    if packed is not None and not is_scene:
        raise MeshFileError(packed, path=path)
    return format.parse(data, path, limits)


def write_mesh(
    path: str | Path, mesh: PolygonMesh | tuple[ArrayLike, ArrayLike | Sequence[Sequence[int]]]
) -> None:
    """Write a polygon mesh into a file, in the format of the file's suffix: .obj, .ply or .off, or
    .stl or .3mf for printers.

    mesh: a PolygonMesh, or (v, 3) points and faces, which are (q, k) vertex indices from 0 or
    a list of faces of any arity. Vertices and faces keep their order, and every coordinate
    reads back as the same number; STL and 3MF have triangles only, STL of single precision. A file
    that is there is replaced in one step.

    Raises UnsupportedFormatError for a suffix that is not written; InvalidMeshError for a mesh
    without faces, a face of fewer than 3 corners or a point that is not finite, which no
    reader would take; OSError as writing does.

    Example: ``write_mesh("square.obj", (points, [[0, 1, 2, 3]]))``
    """
    printed = [form for form in PRINTED if Path(path).suffix.lower() in form.suffixes]
    spell = (printed[0] if printed else find_format(path)).spell
    if spell is None:
        known = " ".join(WRITTEN_SUFFIXES)
        raise UnsupportedFormatError(
            f"{find_format(path).name} is read, but not written; written are {known}", path=path
        )
    if not isinstance(mesh, PolygonMesh):
        mesh = PolygonMesh.from_faces(*mesh)
    if not mesh.n_faces:
        raise InvalidMeshError("the mesh has no faces; nothing could be read from its file")
    if mesh.arities().min() < 3:
        face = int(mesh.arities().argmin())
        raise InvalidMeshError(
            f"face {face} (counted from 0) has {mesh.arities()[face]} corners; 3 are the fewest"
        )
    finite = np.isfinite(mesh.points).all(axis=1)
    if not finite.all():
        at = int(np.argmin(finite))
        raise InvalidMeshError(
            f"vertex {at} (counted from 0) is not finite: {mesh.points[at].tolist()}"
        )
    replace_file(Path(path), spell(mesh))


def find_format(path: str | Path) -> MeshFormat:
    """Return the format that files of this suffix have.

    Raises UnsupportedFormatError, before any file is touched.
    """
    suffix = Path(path).suffix.lower()
    found = _BY_SUFFIX.get(suffix)
    if found is not None:
        return found
    if suffix in _TRIANGLES_ONLY:
        raise UnsupportedFormatError(
            f"{_TRIANGLES_ONLY[suffix]} holds triangles only, the quads were lost when it was "
            "written; export the original as OBJ, PLY or USD",
            path=path,
        )
    known = " ".join(SUPPORTED_SUFFIXES)
    raise UnsupportedFormatError(
        f"unknown mesh format {suffix or '(no suffix)'!r}; supported are {known}", path=path
    )


def _refuse_by_content(path: str | Path) -> None:
    """Refuse a folder and a compressed file as such, whose names tell no format."""
    if Path(path).is_dir():
        raise MeshFileError("this is a folder; name a mesh file in it", path=path)
    with contextlib.suppress(OSError), open_regular(path) as file:
        packed = explain_compression(file.read(16))
        if packed is not None:
            raise MeshFileError(packed, path=path)


def list_format_names() -> str:
    """Return the names of all formats that can be read: "OBJ, PLY, ..."."""
    return ", ".join(format.name for format in FORMATS)
