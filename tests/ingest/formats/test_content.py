"""Files that are not what their names say, faces of many corners, and indices that count from 1."""

from __future__ import annotations

import bz2
import gzip
import lzma
import zipfile
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import FORMATS, SUPPORTED_SUFFIXES, parse, read_mesh, write_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
MANY = 100_000


def zipped(data: bytes, folder: Path) -> bytes:
    with zipfile.ZipFile(folder / "made.zip", "w") as archive:
        archive.writestr("a.obj", data)
    return (folder / "made.zip").read_bytes()


@pytest.mark.parametrize("suffix", [*SUPPORTED_SUFFIXES, ".gz", ""])
@pytest.mark.parametrize("kind", ["gzip", "bzip2", "xz", "zip"])
def test_a_compressed_file_is_named_as_such(tmp_path: Path, suffix: str, kind: str) -> None:
    if (kind, suffix) == ("zip", ".usdz"):
        pytest.skip("a scene in one file is a zip file")
    pack = {"gzip": gzip.compress, "bzip2": bz2.compress, "xz": lzma.compress}
    data = zipped(SQUARE, tmp_path) if kind == "zip" else pack[kind](SQUARE)
    path = tmp_path / f"a{suffix}"
    path.write_bytes(data)
    with pytest.raises(MeshFileError, match=rf"compressed \({kind}\); unpack it first"):
        read_mesh(path)


@pytest.mark.parametrize("name", ["meshes", "meshes.obj", "meshes.usda", "meshes.vtk", "a.b"])
def test_a_folder_is_named_as_such(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    with pytest.raises(MeshFileError, match="this is a folder; name a mesh file in it"):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize("suffix", [s for f in FORMATS if f.spell for s in f.suffixes])
def test_a_face_of_a_hundred_thousand_corners_is_read(tmp_path: Path, suffix: str) -> None:
    turn = 2.0 * np.pi * np.arange(MANY) / MANY
    points = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    faces = [[*range(MANY)], [2, 1, 0, 3]]
    write_mesh(tmp_path / f"a{suffix}", (points, faces))
    mesh = read_mesh(tmp_path / f"a{suffix}")
    assert mesh.faces() == faces and (mesh.points == points).all()


def test_corners_of_a_large_face_may_have_texture_coordinates_and_normals() -> None:
    lines = [b"v 0 0 %d" % k for k in range(MANY)]
    face = b" ".join(b"%d/%d/%d" % (k, 9 * 10**5 + k, 9 * 10**5 + k) for k in range(1, MANY + 1))
    mesh = parse(b"\n".join([*lines, b"f " + face, b""]), "a.obj")
    assert mesh.arities().tolist() == [MANY] and mesh.corners.tolist() == [*range(MANY)]


def test_libraries_read_large_faces(tmp_path: Path) -> None:
    turn = 2.0 * np.pi * np.arange(500) / 500
    points = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1).astype(np.float32)
    pyvista = import_module("pyvista")
    pyvista.PolyData(points, faces=[500, *range(500)]).save(tmp_path / "a.vtk")
    usd, geom = import_module("pxr.Usd"), import_module("pxr.UsdGeom")
    stage = usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    mesh = geom.Mesh.Define(stage, "/mesh")
    mesh.CreatePointsAttr(import_module("pxr.Vt").Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr([500])
    mesh.CreateFaceVertexIndicesAttr([*range(500)])
    stage.GetRootLayer().Save()
    for name in ("a.vtk", "a.usda"):
        assert read_mesh(tmp_path / name).arities().tolist() == [500]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 1 2 3\n3 1 3 4\n"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
            "end_header\n0 0 0\n1 0 0\n1 1 0\n3 1 2 3\n",
        ),
    ],
)
def test_indices_that_count_from_one_are_named(name: str, text: str) -> None:
    with pytest.raises(MeshFileError, match="count from 1: subtract 1 from each index"):
        parse(text.encode(), name)
    # An index too large beside one that is 0, or by more than 1, is another fault.
    for last in ("3 0 1 {n}", "3 1 2 9"):
        lines = text.splitlines()
        n = 4 if name == "a.off" else 3
        spoilt = "\n".join([*lines[:-1], last.format(n=n), ""])
        with pytest.raises(MeshFileError) as caught:
            parse(spoilt.encode(), name)
        assert "names vertex" in str(caught.value) and "from 1" not in str(caught.value)


@pytest.mark.parametrize(
    "line",
    [
        b"t crease 2/1/0 1 2 3.0",
        b"t interpolateboundary 1/0/0 1",
        b"vw 0 0 0.25 1 0.75",
        b"vc 0.5 0.5 0.5 1",
        b"l 1 2 3",
        b"mg 1 0.5",
        b"usemap off",
        b"fo 1 2 3",
    ],
)
def test_known_keywords_do_not_refuse_a_file(line: bytes) -> None:
    alone = parse(SQUARE, "a.obj")
    for text in (SQUARE + line + b"\n", line + b"\n" + SQUARE, SQUARE + line):
        mesh: PolygonMesh = parse(text, "a.obj")
        assert mesh.faces()[:1] == alone.faces() or line.startswith(b"fo")
        assert (mesh.points == alone.points).all()
