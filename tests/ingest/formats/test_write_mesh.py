"""Writing meshes: what is written reads back as it was, in every format of the registry."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.formats import FORMATS, ReadLimits, parse, read_mesh, write_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError, UnsupportedFormatError
from tests.support.formats.meshwriters import Soup, assert_is, same, soups

WRITTEN = [suffix for entry in FORMATS if entry.spell for suffix in entry.suffixes]
READ_ONLY = [suffix for entry in FORMATS if not entry.spell for suffix in entry.suffixes]
SQUARE = (np.eye(4, 3), [[0, 1, 2, 3]])


@pytest.mark.parametrize("suffix", WRITTEN)
@given(soup=soups())
def test_reading_what_was_written_is_the_identity(suffix: str, soup: Soup) -> None:
    mesh = PolygonMesh.from_faces(soup.points, soup.faces)
    (spell,) = (entry.spell for entry in FORMATS if suffix in entry.suffixes)
    assert spell is not None
    again = parse(spell(mesh), f"a{suffix}")
    assert_is(again, soup)
    assert same(again, mesh)


@pytest.mark.parametrize("suffix", WRITTEN)
def test_takes_a_mesh_or_points_and_faces(tmp_path: Path, suffix: str) -> None:
    a, b, c = (tmp_path / f"{name}{suffix}" for name in "abc")
    write_mesh(a, SQUARE)
    write_mesh(str(b), (np.eye(4, 3).tolist(), np.array([[0, 1, 2, 3]])))
    write_mesh(c, read_mesh(a))
    assert a.read_bytes() == b.read_bytes() == c.read_bytes()
    assert read_mesh(a).faces() == [[0, 1, 2, 3]]


@pytest.mark.parametrize("suffix", WRITTEN)
def test_faces_of_any_arity(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    faces = [list(range(300)), [0, 1, 2], [5, 4, 3, 2, 1]]
    write_mesh(path, (np.random.default_rng(1).normal(size=(300, 3)), faces))
    assert read_mesh(path, limits=ReadLimits(max_arity=300)).faces() == faces


@pytest.mark.parametrize("suffix", WRITTEN)
def test_a_file_that_cannot_be_written_is_left(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text("old")
    for points, faces, words in (
        (np.eye(4, 3), [], "no faces"),
        (np.eye(4, 3), [[0, 1, 2], [0, 1]], r"face 1 .* 2 corners"),
        (np.full((3, 3), np.inf), [[0, 1, 2]], "vertex 0 .* not finite"),
        (np.eye(3, 3), [[0, 1, 3]], r"outside 0\.\.2"),
        (np.eye(3, 2), [[0, 1, 2]], r"\(v, 3\)"),
        (np.eye(3, 3), [[0.0, 1.0, 2.0]], "whole numbers"),
        ([["x"]], [[0, 1, 2]], r"\(v, 3\) numbers"),
    ):
        with pytest.raises(InvalidMeshError, match=words):
            write_mesh(path, (points, faces))
    with pytest.raises(OSError):
        write_mesh(tmp_path / "nowhere" / f"a{suffix}", SQUARE)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("suffix", READ_ONLY)
def test_what_is_read_only_is_said_to_be(suffix: str) -> None:
    with pytest.raises(UnsupportedFormatError, match=r"not written; written are \.obj \.ply"):
        write_mesh(f"a{suffix}", SQUARE)


@pytest.mark.parametrize("name", ["a", "a.glb", "a.xyz"])
def test_unknown_formats_are_refused(name: str) -> None:
    with pytest.raises(UnsupportedFormatError):
        write_mesh(name, SQUARE)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=9, max_size=9))
def test_points_keep_every_bit(numbers: list[float]) -> None:
    numbers += [sys.float_info.min, -0.0, 5e-324]
    mesh = PolygonMesh.from_faces(np.reshape(numbers, (4, 3)), [[0, 1, 2, 3]])
    for entry in FORMATS:
        if entry.spell is not None:
            found = parse(entry.spell(mesh), f"a{entry.suffixes[0]}")
            assert found.points.tobytes() == mesh.points.tobytes()
