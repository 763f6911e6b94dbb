"""STL and 3MF: what printers read, and nothing else does."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import PRINTED, SUPPORTED_SUFFIXES, read_mesh, write_mesh
from patterndb.errors import UnsupportedFormatError

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def read_stl(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """(t, 3) normals and (t, 3, 3) corners."""
    data = path.read_bytes()
    count = int(np.frombuffer(data, "<u4", 1, 80)[0])
    assert len(data) == 84 + 50 * count
    rows = np.frombuffer(data[84:], np.uint8).reshape(count, 50)[:, :48].copy().view("<f4")
    return rows[:, :3], rows[:, 3:].reshape(-1, 3, 3)


def test_stl_has_triangles_that_turn_as_the_faces_do(tmp_path: Path) -> None:
    write_mesh(tmp_path / "cube.stl", (CUBE, SIDES))
    normals, corners = read_stl(tmp_path / "cube.stl")
    assert len(corners) == 12
    six = (np.cross(corners[:, 0], corners[:, 1]) * corners[:, 2]).sum()
    assert six == pytest.approx(6.0)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.allclose(across, normals)
    outward = (normals * (corners.mean(axis=1) - 0.5)).sum(axis=1)
    assert (outward > 0.4).all()


@pytest.mark.parametrize("sense", [1, -1])
def test_concave_faces_are_cut_within_themselves(tmp_path: Path, sense: int) -> None:
    points = np.array([[0, 0, 0], [2, 1, 0], [0, 2, 0], [0.5, 1, 0]], float)
    write_mesh(tmp_path / "arrow.stl", (points, [[0, 1, 2, 3][::sense]]))
    normals, corners = read_stl(tmp_path / "arrow.stl")
    assert np.allclose(normals, [0, 0, sense])
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2.0 == pytest.approx(1.5)


def test_3mf_names_its_model_and_shares_vertices(tmp_path: Path) -> None:
    write_mesh(tmp_path / "cube.3mf", (CUBE * 1e-3, SIDES))
    data = (tmp_path / "cube.3mf").read_bytes()
    archive = zipfile.ZipFile(io.BytesIO(data))
    assert archive.testzip() is None
    parts = {name: ElementTree.fromstring(archive.read(name)) for name in archive.namelist()}
    (link,) = parts["_rels/.rels"]
    model = parts[link.attrib["Target"].lstrip("/")]
    assert model.attrib["unit"] == "millimeter"
    vertices = [one for one in model.iter() if one.tag.endswith("}vertex")]
    places = np.array([[float(one.attrib[c]) for c in "xyz"] for one in vertices])
    assert np.array_equal(places, CUBE * 1e-3)
    rows = [one for one in model.iter() if one.tag.endswith("}triangle")]
    triangles = np.array([[int(one.attrib[f"v{k}"]) for k in (1, 2, 3)] for one in rows])
    edges = {(a, b) for t in triangles.tolist() for a, b in zip(t, t[1:] + t[:1], strict=True)}
    assert len(triangles) == 12 and len(edges) == 36
    assert edges == {(b, a) for a, b in edges}
    (item,) = [one for one in model.iter() if one.tag.endswith("}item")]
    assert item.attrib["objectid"] == "1"
    write_mesh(tmp_path / "again.3mf", (CUBE * 1e-3, SIDES))
    assert (tmp_path / "again.3mf").read_bytes() == data


@pytest.mark.parametrize("form", PRINTED, ids=lambda form: form.name)
def test_what_printers_read_is_not_read_here(tmp_path: Path, form: object) -> None:
    suffix = form.suffixes[0]  # pyright: ignore[reportAttributeAccessIssue]
    path = tmp_path / f"cube{suffix}"
    write_mesh(path, (CUBE, SIDES))
    assert suffix not in SUPPORTED_SUFFIXES
    with pytest.raises(UnsupportedFormatError, match="triangles only"):
        read_mesh(path)
