"""VTK files, legacy (.vtk) and XML (.vtp), read by VTK itself.

VTK comes with the extra ``viewer``; its readers are called directly, because pyvista's print and
log what they find wrong with a file, and take a second to import.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ingest.formats.files import ReadLimits
from ingest.formats.grammar import quote_token
from ingest.formats.isolated import LibraryError, Polygons, read_isolated
from ingest.formats.meshformat import MeshFormat
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError
from patterndb.system.extras import require_extra

# Cell types of VTK's vtkCellType.h
_NOT_FACES = (0, 1, 2, 3, 4)  # empty, vertex, poly vertex, line, poly line: skipped, as in OBJ
_TRIANGLE, _STRIP, _POLYGON, _PIXEL, _QUAD = 5, 6, 7, 8, 9

_STRIPS = "the faces are triangle strips, which hold no quads; export polygons"

# The counts a file promises. VTK allocates by them before it reads on, and crashes; held
# against the size of the file first, where a point or an index takes a byte at the very
# least, they can be refused by their line.
_LEGACY_COUNT = re.compile(
    rb"^[ \t]*(?:POINTS|VERTICES|LINES|POLYGONS|TRIANGLE_STRIPS|CELLS|CELL_TYPES|POINT_DATA"
    rb"|CELL_DATA)[ \t]+(-?[0-9]+)(?:[ \t]+(-?[0-9]+))?",
    re.M | re.I,
)
_LEGACY_KIND = re.compile(rb"^[ \t]*DATASET[ \t]+(\S+)", re.M | re.I)
_XML_COUNT = re.compile(rb"(?:NumberOf[A-Za-z]+)\s*=\s*[\"']\s*(-?[0-9]+)")
# Compressed XML data may hold more than the file has bytes: zlib packs at most 1032 to 1.
_ZLIB_RATIO = 1032


def require_vtk() -> None:
    """Raise MissingExtraError where the library that reads VTK's files is not installed."""
    require_extra("viewer", "reading VTK files", ("vtkmodules", "pyvista"))


def read_vtk(data: bytes, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The polygons of a poly data or unstructured grid file.

    data: the whole file, for what is checked before VTK reads it from ``path``.

    Vertex and line cells are skipped. Triangle strips, volume cells, curved cells and
    structured grids are refused: reading part of a file would be reading another mesh.

    Raises MissingExtraError without VTK; MeshFileError, also for whatever VTK reports. Nothing is
    printed.
    """
    require_vtk()
    _check_counts(data, path)
    return read_isolated("vtk", path, limits)


FORMATS = (
    MeshFormat(
        "VTK",
        (".vtk",),
        "VTK's legacy files of poly data or unstructured grids, read only; needs the extra viewer",
        read_vtk,
        from_bytes=False,
        require=require_vtk,
    ),
    MeshFormat(
        "VTP",
        (".vtp",),
        "VTK's XML files of poly data, read only; needs the extra viewer",
        read_vtk,
        from_bytes=False,
        require=require_vtk,
    ),
)


def _check_counts(data: bytes, path: str | Path) -> None:
    """Refuse counts that the file is too small to keep."""
    xml = _is_xml(path)
    kind = None if xml else _LEGACY_KIND.search(data)
    if kind is not None and kind[1].upper() not in (b"POLYDATA", b"UNSTRUCTURED_GRID"):
        raise MeshFileError(
            "the dataset holds no polygons; export POLYDATA",
            path=path,
            line=1 + data.count(b"\n", 0, kind.start(1)),
            token=quote_token(kind[1]),
        )
    allowed = len(data) * (_ZLIB_RATIO if xml else 1)
    for match in (_XML_COUNT if xml else _LEGACY_COUNT).finditer(data):
        for digits in match.groups():
            if digits is None:
                continue
            if len(digits) > 18 or not 0 <= int(digits) <= allowed:
                line = 1 + data.count(b"\n", 0, match.start())
                raise MeshFileError(
                    f"the file is too small for this number, it has {len(data):,} bytes; "
                    "is it cut short?",
                    path=path,
                    line=line,
                    token=quote_token(match[0]),
                )


def _is_xml(path: str | Path) -> bool:
    return Path(path).suffix.lower() == ".vtp"


# From here on, what runs in the child process


def find_polygons(path: str) -> Polygons:
    """The polygons VTK finds in the file; LibraryError if it reports anything else."""
    dataset = _read(path)
    if dataset.IsA("vtkPolyData"):
        if dataset.GetNumberOfStrips():
            raise LibraryError(_STRIPS)
        corners, offsets = _cells(dataset.GetPolys())
    else:
        corners, offsets = _cells(dataset.GetCells())
        types = _array(dataset.GetCellTypes()) if len(offsets) > 1 else np.empty(0, np.uint8)
        corners, offsets = _surface_cells(types, corners, offsets)
    points = dataset.GetPoints()
    if points is None:
        raise LibraryError("the file holds no points")
    return Polygons(_array(points.GetData()), corners, np.diff(offsets))


def _read(path: str) -> Any:
    """The vtkPolyData or vtkUnstructuredGrid in the file."""
    from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
    from vtkmodules.vtkIOLegacy import vtkDataSetReader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    # VTK reports what is wrong to its output window: this one keeps the text.
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    reader = vtkXMLPolyDataReader() if _is_xml(path) else vtkDataSetReader()
    reader.SetFileName(path)
    reader.Update()
    dataset = reader.GetOutput()
    report = window.GetOutput()  # bytes, if it quotes some that are not UTF-8
    if report:
        text = quote_token(report) if isinstance(report, bytes) else report
        raise LibraryError(f"VTK cannot read the file: {_reason(text)}")
    if dataset is None or not (dataset.IsA("vtkPolyData") or dataset.IsA("vtkUnstructuredGrid")):
        raise LibraryError("VTK found no polygons in the file; export poly data")
    return dataset


def _reason(report: str) -> str:
    """The first message of VTK's report, without the place in VTK's source."""
    lines = [line for line in report.splitlines() if line.strip()]
    lines = [line for line in lines if not re.match(r"(ERROR|Warning): In ", line)] or lines
    return re.sub(r"^vtk\w+ \(0x[0-9a-f]+\): ", "", lines[0].strip())


def _array(array: Any) -> NDArray[Any]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(array)


def _cells(cells: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners (c,) and offsets (n + 1,) of a vtkCellArray, held to be consistent."""
    if cells is None or not cells.GetNumberOfCells():
        return np.empty(0, np.int64), np.zeros(1, np.int64)
    corners = _array(cells.GetConnectivityArray()).astype(np.int64)
    offsets = _array(cells.GetOffsetsArray()).astype(np.int64)
    if offsets[0] != 0 or offsets[-1] != len(corners) or (np.diff(offsets) < 0).any():
        raise LibraryError(
            f"the offsets of the cells do not ascend from 0 to the {len(corners)} "
            "indices; export the mesh again"
        )
    return corners, offsets


def _surface_cells(
    types: NDArray[np.uint8],
    corners: NDArray[np.int64],
    offsets: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The polygons among the cells of an unstructured grid."""
    if len(types) != len(offsets) - 1:
        raise LibraryError(f"{len(offsets) - 1} cells but {len(types)} cell types")
    if (types == _STRIP).any():
        raise LibraryError(_STRIPS)
    faces = np.isin(types, (_TRIANGLE, _POLYGON, _PIXEL, _QUAD))
    strange = ~faces & ~np.isin(types, _NOT_FACES)
    if strange.any():
        cell = int(strange.argmax())
        raise LibraryError(
            f"cell {cell} (counted from 0) is of VTK type {types[cell]}, not a flat polygon; "
            "extract the surface and export poly data"
        )
    arities = np.diff(offsets)
    for kind, arity in ((_TRIANGLE, 3), (_PIXEL, 4), (_QUAD, 4)):
        wrong = (types == kind) & (arities != arity)
        if wrong.any():
            cell = int(wrong.argmax())
            raise LibraryError(
                f"cell {cell} (counted from 0) is of VTK type {kind} "
                f"but has {arities[cell]} corners"
            )
    # A pixel lists its corners row by row, not around its rim.
    third = offsets[:-1][types == _PIXEL] + 2
    corners[third], corners[third + 1] = corners[third + 1], corners[third].copy()
    kept = np.repeat(faces, arities)
    return corners[kept], np.concatenate(([0], np.cumsum(arities[faces])))
