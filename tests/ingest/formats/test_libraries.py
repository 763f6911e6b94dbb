"""The formats that a library reads for us, VTK and USD."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import ReadLimits, parse, read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError, MissingExtraError
from tests.support.formats.meshwriters import Soup, assert_is, patient, soups

# A file takes a quarter of a second, for the process it is read in.
FEW = settings(patient, max_examples=5)

VTK_HEAD = "# vtk DataFile Version 3.0\na title\nASCII\nDATASET POLYDATA\n"
VTK_POINTS = "POINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n"
USD_SQUARE = """def Mesh "square"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
}
"""


def _pxr(name: str) -> Any:
    return import_module(f"pxr.{name}")


def _write_vtk(soup: Soup, path: Path, *, binary: bool) -> None:
    pyvista = import_module("pyvista")
    faces = np.concatenate([[len(face), *face] for face in soup.faces])
    pyvista.PolyData(np.array(soup.points, float), faces=faces).save(path, binary=binary)


def _write_usd(soup: Soup, path: Path) -> None:
    stage = _pxr("Usd").Stage.CreateNew(str(path))
    mesh = _pxr("UsdGeom").Mesh.Define(stage, "/mesh")
    vt = _pxr("Vt")
    mesh.CreatePointsAttr(vt.Vec3fArray.FromNumpy(np.array(soup.points, np.float32)))
    mesh.CreateFaceVertexCountsAttr([len(face) for face in soup.faces])
    mesh.CreateFaceVertexIndicesAttr([i for face in soup.faces for i in face])
    stage.GetRootLayer().Save()


# Seven digits: what VTK writes as text, and single precision holds.
short = st.integers(-8000, 8000).map(lambda n: n / 8)


@FEW
@given(soup=soups(short), name=st.sampled_from(["a.vtk", "a.vtp"]), binary=st.booleans())
def test_vtk_round_trip(
    tmp_path_factory: pytest.TempPathFactory, soup: Soup, name: str, binary: bool
) -> None:
    path = tmp_path_factory.mktemp("vtk") / name
    _write_vtk(soup, path, binary=binary)
    assert_is(read_mesh(path), soup)


@FEW
@given(soup=soups(short), suffix=st.sampled_from([".usda", ".usdc", ".usd"]))
def test_usd_round_trip(tmp_path_factory: pytest.TempPathFactory, soup: Soup, suffix: str) -> None:
    path = tmp_path_factory.mktemp("usd") / f"a{suffix}"
    _write_usd(soup, path)
    assert_is(read_mesh(path), soup)


def test_usdz(tmp_path: Path) -> None:
    soup = Soup([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [[0, 1, 2, 3]])
    _write_usd(soup, tmp_path / "a.usdc")
    _pxr("UsdUtils").CreateNewUsdzPackage(str(tmp_path / "a.usdc"), str(tmp_path / "a.usdz"))
    assert_is(read_mesh(tmp_path / "a.usdz"), soup)


def test_vtk_skips_points_and_lines(tmp_path: Path) -> None:
    text = VTK_HEAD + VTK_POINTS + "VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\nPOLYGONS 1 5\n4 0 1 2 3\n"
    (tmp_path / "a.vtk").write_text(text)
    assert read_mesh(tmp_path / "a.vtk").corners.tolist() == [0, 1, 2, 3]


def test_vtk_unstructured_grid(tmp_path: Path) -> None:
    text = VTK_HEAD.replace("POLYDATA", "UNSTRUCTURED_GRID") + VTK_POINTS
    text += "CELLS 5 22\n4 0 1 2 3\n3 0 1 2\n4 0 1 3 2\n2 0 1\n4 3 2 1 0\n"
    text += "CELL_TYPES 5\n9\n5\n8\n3\n7\n"  # quad, triangle, pixel, line, polygon
    (tmp_path / "a.vtk").write_text(text)
    mesh = read_mesh(tmp_path / "a.vtk")
    assert mesh.corners.tolist() == [0, 1, 2, 3, 0, 1, 2, 0, 1, 2, 3, 3, 2, 1, 0]
    assert mesh.arities().tolist() == [4, 3, 4, 4]


REFUSED_VTK = [
    (VTK_HEAD + VTK_POINTS + "POLYGONS 1 5\n4 0 1 2 4\n", "names vertex 4"),
    (VTK_HEAD + VTK_POINTS + "POLYGONS 1 5\n4 0 1 2 -1\n", "names vertex -1"),
    (VTK_HEAD + VTK_POINTS + "POLYGONS 1 3\n2 0 1\n", "has 2 corners"),
    (VTK_HEAD + VTK_POINTS + "POLYGONS 1 100002\n100001" + " 0" * 100_001, "has 100,001 corners"),
    (VTK_HEAD + VTK_POINTS + "POLYGONS 1 5\n4 0 1\n", "VTK cannot read"),
    (VTK_HEAD + VTK_POINTS + "POLYGONS 1 999999999999\n4 0 1 2 3\n", ":7: the file is too small"),
    (VTK_HEAD + VTK_POINTS.replace("4", "-4"), ":5: the file is too small"),
    (
        # VTK reads it from 9.7 on.
        VTK_HEAD + VTK_POINTS.replace("1 1 0", "1 nan 0") + "POLYGONS 1 4\n3 0 1 2\n",
        "not finite | VTK cannot read",
    ),
    (
        VTK_HEAD + VTK_POINTS.replace("1 1 0", "1 x 0") + "POLYGONS 1 4\n3 0 1 2\n",
        "VTK cannot read",
    ),
    (VTK_HEAD + VTK_POINTS + "TRIANGLE_STRIPS 1 5\n4 0 1 3 2\n", "strips"),
    (VTK_HEAD + VTK_POINTS, "no faces"),
    (VTK_HEAD.replace("POLYDATA", "STRUCTURED_POINTS"), ":4: the dataset holds no polygons"),
    (VTK_HEAD[:40], "VTK"),
]


@pytest.mark.parametrize(("text", "part"), REFUSED_VTK)
def test_refuses_vtk(tmp_path: Path, text: str, part: str) -> None:
    _refused(tmp_path / "a.vtk", text, part)


def test_refuses_volume_cells(tmp_path: Path) -> None:
    text = VTK_HEAD.replace("POLYDATA", "UNSTRUCTURED_GRID") + VTK_POINTS
    text += "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n"
    _refused(tmp_path / "a.vtk", text, "VTK type 10")


def test_refuses_broken_xml(tmp_path: Path) -> None:
    _write_vtk(
        Soup([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [[0, 1, 2]]), tmp_path / "b.vtp", binary=False
    )
    text = (tmp_path / "b.vtp").read_text()
    _refused(tmp_path / "a.vtp", text[: len(text) // 2], "Error parsing XML")
    wrong = text.replace('NumberOfPoints="3"', 'NumberOfPoints="30000000"')
    _refused(tmp_path / "a.vtp", wrong, "too small")


def test_usd_merges_all_meshes_where_they_stand(tmp_path: Path) -> None:
    moved = "double3 xformOp:translate = (10, 0, 0)\n"
    moved += 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    text = f'#usda 1.0\n{USD_SQUARE}def Xform "group"\n{{\n{moved}\n{USD_SQUARE}}}\n'
    (tmp_path / "a.usda").write_text(text)
    mesh = read_mesh(tmp_path / "a.usda")
    assert mesh.corners.tolist() == [0, 1, 2, 3, 4, 5, 6, 7]
    assert mesh.points[4:].tolist() == [[10, 0, 0], [11, 0, 0], [11, 1, 0], [10, 1, 0]]


@pytest.mark.parametrize("left_handed", [False, True])
@pytest.mark.parametrize("mirrored", [False, True])
def test_usd_faces_turn_as_they_are_seen(tmp_path: Path, left_handed: bool, mirrored: bool) -> None:
    lines = []
    if left_handed:
        lines += ['uniform token orientation = "leftHanded"']
    if mirrored:
        lines += ["double3 xformOp:scale = (-1, 1, 1)"]
        lines += ['uniform token[] xformOpOrder = ["xformOp:scale"]']
    text = "#usda 1.0\n" + USD_SQUARE.replace("{\n", "\n".join(["{", *lines, ""]), 1)
    (tmp_path / "a.usda").write_text(text)
    mesh = read_mesh(tmp_path / "a.usda")
    expected = [0, 3, 2, 1] if left_handed != mirrored else [0, 1, 2, 3]
    assert mesh.corners.tolist() == expected
    assert mesh.points[1, 0] == (-1 if mirrored else 1)


REFUSED_USD = [
    (USD_SQUARE.replace("3]", "4]"), "/square: faceVertexIndices[3] names point 4"),
    (USD_SQUARE.replace("3]", "-1]"), "/square: faceVertexIndices[3] names point -1"),
    (USD_SQUARE.replace("[4]", "[5]"), "sum to 5"),
    (USD_SQUARE.replace("[4]", "[2, 2]"), "at least 3 each"),
    (USD_SQUARE.replace("(0, 1, 0)", "(0, nan, 0)"), "not finite"),
    (USD_SQUARE.replace("int[] faceVertexI", "float[] faceVertexI"), "list of integers"),
    (USD_SQUARE.replace("}", ""), "USD cannot read the file"),
    (USD_SQUARE.replace("Mesh", "Xform"), "no faces"),
    ('def "a" (references = @b.usda@)\n{\n}\n', "composed of other files, such as 'b.usda'"),
    ('def "a" (references = </nowhere>)\n{\n}\n', "prim path </nowhere> introduced by </a>"),
    (USD_SQUARE.replace("{\n", "{\nint[] holeIndices = [1]\n", 1), "holeIndices[0] names face 1"),
    (USD_SQUARE.replace("{\n", "{\nint[] holeIndices = [-1]\n", 1), "holeIndices[0] names face -1"),
    (
        USD_SQUARE.replace("{\n", '{\nuniform token purpose = "guide"\n', 1),
        "are guides or",
    ),
    (USD_SQUARE.replace("{\n", "{\nint[] holeIndices = [0]\n", 1), "no faces"),
    ("", "no faces"),
]


def _usd_strip(*lines: str, name: str = "strip") -> str:
    """A prim of two quads in a row."""
    return "\n".join(
        [
            f'def Mesh "{name}"',
            "{",
            "int[] faceVertexCounts = [4, 4]",
            "int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]",
            "point3f[] points = [(0,0,0), (1,0,0), (2,0,0), (0,1,0), (1,1,0), (2,1,0)]",
            *lines,
            "}",
        ]
    )


def _read_usd(tmp_path: Path, text: str) -> PolygonMesh:
    (tmp_path / "a.usda").write_text("#usda 1.0\n" + text)
    return read_mesh(tmp_path / "a.usda")


def test_usd_faces_that_are_declared_holes_are_left_out(tmp_path: Path) -> None:
    mesh = _read_usd(tmp_path, _usd_strip("int[] holeIndices = [0, 0]"))
    assert mesh.faces() == [[1, 2, 5, 4]] and len(mesh.points) == 6
    # Read backwards, a left-handed mesh has the same holes; those of other prims are their own.
    left = _usd_strip("int[] holeIndices = [1]", 'uniform token orientation = "leftHanded"')
    mesh = _read_usd(tmp_path, left + "\n" + _usd_strip(name="other"))
    assert mesh.faces() == [[0, 3, 4, 1], [6, 7, 10, 9], [7, 8, 11, 10]]


@pytest.mark.parametrize(
    "line", ['uniform token purpose = "guide"', 'token visibility = "invisible"']
)
@pytest.mark.parametrize("above", [False, True])
def test_usd_guides_and_invisible_meshes_are_left_out(
    tmp_path: Path, line: str, above: bool
) -> None:
    hidden = _usd_strip(name="hidden") if above else _usd_strip(line, name="hidden")
    if above:
        hidden = f'def Xform "above"\n{{\n{line}\ndef Scope "between"\n{{\n{hidden}\n}}\n}}'
    mesh = _read_usd(tmp_path, hidden + "\n" + USD_SQUARE)
    assert mesh.faces() == [[0, 1, 2, 3]] and len(mesh.points) == 4


def test_usd_references_within_the_file_are_followed(tmp_path: Path) -> None:
    shape = 'class "shape"\n{\n' + USD_SQUARE + "}\n"
    uses = [f'def Xform "{name}" ({how} = </shape>)\n{{\n}}\n' for name, how in REFERENCES]
    assert _read_usd(tmp_path, shape + "".join(uses)).n_faces == len(REFERENCES)


REFERENCES = [("a", "references"), ("b", "prepend references"), ("c", "payload"), ("d", "inherits")]


@pytest.mark.parametrize(("text", "part"), REFUSED_USD)
def test_refuses_usd(tmp_path: Path, text: str, part: str) -> None:
    _refused(tmp_path / "a.usda", "#usda 1.0\n" + text, part)


def test_usd_without_its_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.usda").write_text("#usda 1.0\n" + USD_SQUARE)
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(MissingExtraError, match=r'pip install "usd-core'):
        read_mesh(tmp_path / "a.usda")


@pytest.mark.parametrize("name", ["a.vtk", "a.usda"])
@pytest.mark.parametrize(
    ("fate", "part"),
    [
        ("kill -SEGV $$", "crashed on the file (SIGSEGV)"),
        ("exit 1", "crashed on the file (exit code 1)"),
        ("echo hello", "gave no mesh"),
        ("sleep 30", "did not finish within 0.2 s"),
    ],
)
def test_what_befalls_a_library_befalls_it_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, fate: str, part: str
) -> None:
    library = tmp_path / "library"
    library.write_text(f"#!/bin/sh\n{'exec ' if fate.startswith('sleep') else ''}{fate}\n")
    library.chmod(0o755)
    (tmp_path / name).write_text("content")
    monkeypatch.setattr(sys, "executable", str(library))
    with pytest.raises(MeshFileError) as caught:
        read_mesh(tmp_path / name, limits=ReadLimits(max_library_seconds=0.2))
    assert part in str(caught.value)


def test_what_libraries_print_is_kept_to_themselves(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    _refused(tmp_path / "a.vtk", VTK_HEAD + VTK_POINTS + "POLYGONS 1 5\n4 0\n", "VTK cannot read")
    _refused(tmp_path / "a.usda", "#usda 1.0\n(", "USD cannot read")
    assert capfd.readouterr() == ("", "")


def _refused(path: Path, text: str, part: str) -> None:
    path.write_text(text)
    with pytest.raises(MeshFileError) as caught:
        parse(text.encode(), path)
    assert any(one in str(caught.value) for one in part.split(" | "))
    assert str(caught.value).startswith(str(path))
