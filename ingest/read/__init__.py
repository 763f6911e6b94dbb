"""Mesh files as their authors made them: every polygon, and the file's own vertex indices.

    mesh = read_mesh("penguin.obj")

or, where the bytes are wanted as well (to hash them, say), in two steps:

    data = load_file("penguin.obj")
    mesh = parse(data, "penguin.obj")

General mesh libraries triangulate, merge or split vertices on the way in; a pattern is made
of exactly what they lose.
"""

from __future__ import annotations

from pathlib import Path

from ingest.read.files import load_file
from ingest.read.limits import DEFAULT_LIMITS, ReadLimits
from ingest.read.obj import parse_obj
from ingest.read.ply import parse_ply
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import UnsupportedFormatError

__all__ = ["SUPPORTED_SUFFIXES", "ReadLimits", "load_file", "parse", "read_mesh"]

_VTK_SUFFIXES = (".vtk", ".vtp")
_USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
SUPPORTED_SUFFIXES: tuple[str, ...] = (".obj", ".ply", *_VTK_SUFFIXES, *_USD_SUFFIXES)

_TRIANGLES_ONLY = {".stl": "STL", ".gltf": "glTF", ".glb": "glTF"}


def read_mesh(path: str | Path, *, limits: ReadLimits = DEFAULT_LIMITS) -> PolygonMesh:
    """The polygon mesh in a file, by the file's suffix.

    Raises MeshFileError, with file, line and token, on a file that is damaged, over a limit
    or without faces; UnsupportedFormatError on a format that is unknown or cannot hold quads;
    MissingExtraError on a USD file where usd-core is not installed.

    Example: ``quads, faces = read_mesh("penguin.obj").quads()``
    """
    check_suffix(path)
    return parse(load_file(path, limits), path, limits)


def parse(data: bytes, path: str | Path, limits: ReadLimits = DEFAULT_LIMITS) -> PolygonMesh:
    """The polygon mesh in the bytes of a file, by the suffix of ``path``.

    data: what :func:`load_file` gave for ``path``. OBJ and PLY are read from it alone, and
    ``path`` need not exist; the libraries behind VTK and USD open ``path`` themselves.

    Raises what :func:`read_mesh` raises.
    """
    suffix = check_suffix(path)
    if suffix == ".obj":
        return parse_obj(data, path, limits)
    if suffix == ".ply":
        return parse_ply(data, path, limits)
    # Imported here because pyvista and pxr take seconds to import, and pxr is optional.
    if suffix in _VTK_SUFFIXES:
        from ingest.read.vtk import read_vtk

        return read_vtk(data, path, limits)
    from ingest.read.usd import read_usd

    return read_usd(path, limits)


def check_suffix(path: str | Path) -> str:
    """The lower-case suffix of ``path``, if a reader exists for it.

    Raises UnsupportedFormatError, before any file is touched.
    """
    suffix = Path(path).suffix.lower()
    if suffix in SUPPORTED_SUFFIXES:
        return suffix
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
