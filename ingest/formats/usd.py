"""USD files, read by the library of the format (usd-core, the extra ``usd``)."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ingest.formats.files import ReadLimits, check_file
from ingest.formats.grammar import quote_token
from ingest.formats.isolated import LibraryError, Polygons, read_isolated
from ingest.formats.meshformat import MeshFormat
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.system.extras import require_extra


def require_usd() -> None:
    """Raise MissingExtraError where the library that reads USD files is not installed."""
    require_extra("usd", "reading USD files")


def read_usd(data: bytes, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """All Mesh prims of a USD file as one mesh, in the order of the scene.

    data: not looked at; the library opens ``path``.

    Points are in world space, at the earliest time of an animation. Faces run counter-clockwise:
    those of a left-handed mesh are reversed, and so are those a mirroring transform turns over.
    The cage is read as it is, whatever subdivision scheme the prim asks for. Instances count
    each; prims that are inactive or only defined as classes do not. Left out are faces that
    holeIndices name, and prims that are guides or invisible, by themselves or by a prim above them.

    A file that composes others (sublayers, references, payloads) is refused: its content
    would not tell which mesh it holds. References within the file are followed.

    Raises MissingExtraError without usd-core; MeshFileError on whatever the library reports.
    """
    require_usd()
    check_file(path, limits)
    return read_isolated("usd", path, limits)


FORMAT = MeshFormat(
    "USD",
    (".usd", ".usda", ".usdc", ".usdz"),
    "Pixar's scenes, all their meshes as one, read only; needs the extra usd",
    read_usd,
    from_bytes=False,
    require=require_usd,
)


# From here on, what runs in the child process


def find_polygons(path: str) -> Polygons:
    """All Mesh prims in the file; LibraryError on whatever USD reports."""
    try:
        meshes = _meshes(path)
    except LibraryError:
        raise
    except UnicodeDecodeError as error:  # USD's message, quoting the file
        raise LibraryError(f"USD cannot read the file: {quote_token(error.object)}") from error
    except Exception as error:
        raise LibraryError(f"USD cannot read the file: {_reason(error)}") from error
    counts = [len(points) for points, _, _ in meshes]
    first = np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))
    points = [np.empty((0, 3)), *(each for each, _, _ in meshes)]
    corners = [np.empty(0, np.int64)]
    corners += [own + begin for (_, own, _), begin in zip(meshes, first, strict=False)]
    arities = [np.empty(0, np.int64), *(each for _, _, each in meshes)]
    return Polygons(np.concatenate(points), np.concatenate(corners), np.concatenate(arities))


_Part = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]


def _meshes(path: str) -> list[_Part]:
    """Points, corners (from 0 in each) and arities of every Mesh prim."""
    sdf, usd, geom = _pxr("Sdf"), _pxr("Usd"), _pxr("UsdGeom")
    # Anonymous: the library keeps opened layers by name, and would not notice a changed file.
    layer = sdf.Layer.OpenAsAnonymous(path)
    if layer is None:
        raise LibraryError("not a USD file")
    # References within the file have an empty name.
    others = sorted(filter(None, layer.GetCompositionAssetDependencies()))
    if others:
        raise LibraryError(
            f"the scene is composed of other files, such as {others[0]!r}; "
            "make it one with usdcat --flatten"
        )
    stage = usd.Stage.Open(layer)
    broken = stage.GetCompositionErrors()
    if broken:
        # The layer's own name is an address in memory.
        reason = re.sub(r"@anon:[^@]*@", "", str(broken[0]))
        raise LibraryError(f"USD cannot compose the scene: {reason}")
    time = usd.TimeCode.EarliestTime()
    meshes = [
        geom.Mesh(prim)
        for prim in stage.Traverse(usd.TraverseInstanceProxies())
        if prim.IsA(geom.Mesh)
    ]
    shown = [mesh for mesh in meshes if _is_shown(mesh, time)]
    if meshes and not shown:
        raise LibraryError(
            f"all meshes of the scene, such as {meshes[0].GetPath()}, are guides or invisible; "
            "make those visible that are wanted"
        )
    return [_part(mesh, time) for mesh in shown]


def _is_shown(mesh: Any, time: Any) -> bool:
    """Is a mesh neither a guide nor invisible, by itself or by a prim above it?"""
    geom = _pxr("UsdGeom")
    return (
        mesh.ComputePurpose() != geom.Tokens.guide
        and mesh.ComputeVisibility(time) != geom.Tokens.invisible
    )


def _part(mesh: Any, time: Any) -> _Part:
    geom = _pxr("UsdGeom")
    name = mesh.GetPath()
    points = np.array(mesh.GetPointsAttr().Get(time) or [], np.float64).reshape(-1, 3)
    arities = _integers(mesh.GetFaceVertexCountsAttr(), time)
    corners = _integers(mesh.GetFaceVertexIndicesAttr(), time)
    # Checked for each prim, since merged a wrong index could land in another prim's points.
    if (arities < 3).any() or arities.sum() != len(corners):
        raise LibraryError(
            f"{name}: faceVertexCounts sum to {arities.sum()}, at least 3 each; "
            f"faceVertexIndices has {len(corners)}"
        )
    wrong = (corners < 0) | (corners >= len(points))
    if wrong.any():
        at = int(wrong.argmax())
        raise LibraryError(
            f"{name}: faceVertexIndices[{at}] names point {corners[at]}, "
            f"but the points are 0 to {len(points) - 1}"
        )
    corners, arities = _without_holes(mesh, corners, arities, time)
    # Row vectors: a point is multiplied from the left.
    matrix = np.array(geom.Xformable(mesh).ComputeLocalToWorldTransform(time))
    if not np.array_equal(matrix, np.eye(4)):
        points = points @ matrix[:3, :3] + matrix[3, :3]
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    left_handed = mesh.GetOrientationAttr().Get(time) == geom.Tokens.leftHanded
    if mirrored != left_handed:
        corners = _reversed(corners, arities)
    return points, corners, arities


def _without_holes(
    mesh: Any, corners: NDArray[np.int64], arities: NDArray[np.int64], time: Any
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners and arities without the faces that the prim declares to be holes."""
    holes = _integers(mesh.GetHoleIndicesAttr(), time)
    wrong = (holes < 0) | (holes >= len(arities))
    if wrong.any():
        at = int(wrong.argmax())
        raise LibraryError(
            f"{mesh.GetPath()}: holeIndices[{at}] names face {holes[at]}, "
            f"but the faces are 0 to {len(arities) - 1}"
        )
    kept = np.ones(len(arities), np.bool_)
    kept[holes] = False
    return corners[np.repeat(kept, arities)], arities[kept]


def _integers(attribute: Any, time: Any) -> NDArray[np.int64]:
    value = np.array(attribute.Get(time) or [], ndmin=1)
    if len(value) and (value.ndim != 1 or value.dtype.kind not in "iu"):
        raise LibraryError(f"{attribute.GetPath()} is not a list of integers")
    return value.astype(np.int64)


def _reversed(corners: NDArray[np.int64], arities: NDArray[np.int64]) -> NDArray[np.int64]:
    """Every face the other way round, from the same first corner."""
    ends = np.cumsum(arities)
    begins = np.repeat(ends - arities, arities)
    rank = np.arange(len(corners)) - begins
    return corners[begins + (-rank) % np.repeat(arities, arities)]


def _reason(error: Exception) -> str:
    """The library's own words, without the place in its source that they come with."""
    reports = [str(getattr(report, "commentary", report)) for report in error.args]
    return " ".join(reports).split("\n")[0].strip() or "no reason given"


def _pxr(module: str) -> Any:
    """A module of usd-core; they carry no types."""
    return import_module(f"pxr.{module}")
