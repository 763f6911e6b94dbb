from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import ReadLimits, obj, parse, read_mesh
from ingest.formats.files import DEFAULT_LIMITS
from patterndb.errors import MeshFileError
from tests.support.formats import referenceobj
from tests.support.formats.meshwriters import (
    ObjStyle,
    Soup,
    assert_is,
    mutations,
    obj_bytes,
    obj_styles,
    patient,
    same,
    soups,
)
from tests.support.meshes import examples, models
from tests.support.shared import MESHES

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
TOKENS = (
    b"v f vt fo g usemtl # \\ \\\n \n \r\n \r - + . / // 0 -1 1 1/1 1//1 1/1/1 1/ "
    b"nan inf 1_0 0x1 1e5 1e999 1. .5 -.5e-3 007 99999999999 call \0 \t \x0b \x0c \xa0 \xd9\xa1"
).split(b" ")

#: Files to read: examples, models, and artists' meshes where these are.
FILES = [*examples(), *models(), *sorted(MESHES.glob("*.obj"))]


def count_elements(path: Path) -> tuple[int, int, int]:
    """Count vertices, faces and quads: by the index of the artists' meshes, else by lines."""
    if path.parent == MESHES:
        rows = csv.DictReader((MESHES / "INDEX.csv").read_text().splitlines())
        row = next(row for row in rows if row["file"] == path.name)
        return int(row["nv"]), int(row["nf"]), int(row["quads"])
    lines = [line.split() for line in path.read_text().splitlines()]
    faces = [line for line in lines if line[:1] == ["f"]]
    n_points = sum(line[:1] == ["v"] for line in lines)
    return n_points, len(faces), sum(len(face) == 5 for face in faces)


@patient
@given(soups(), obj_styles)
def test_every_spelling_reads_back_exactly(soup: Soup, style: ObjStyle) -> None:
    assert_is(parse(obj_bytes(soup, style), "a.obj"), soup)


@patient
@given(soups(), obj_styles, st.integers(1, 200))
def test_the_size_of_chunks_does_not_show(soup: Soup, style: ObjStyle, size: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(obj, "CHUNK_BYTES", size)
        assert_is(parse(obj_bytes(soup, style), "a.obj"), soup)


@patient
@given(soups(), obj_styles)
def test_the_line_parser_alone_reads_the_same(soup: Soup, style: ObjStyle) -> None:
    data = obj_bytes(soup, style)
    fast = parse(data, "a.obj")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(obj, "_parse_chunk", lambda chunk, limits: None)
        assert same(parse(data, "a.obj"), fast)


@settings(patient, max_examples=200)
@given(st.data())
def test_accepts_what_the_reference_accepts(data: st.DataObject) -> None:
    tame = st.floats(-9, 9, allow_subnormal=False).map(lambda x: round(x, 2))
    clean = obj_bytes(data.draw(soups(tame)), data.draw(obj_styles))
    text = data.draw(mutations(clean, TOKENS))
    try:
        points, faces = referenceobj.read(text)
    except referenceobj.RefusedError:
        with pytest.raises(MeshFileError):
            parse(text, "a.obj")
    else:
        assert_is(parse(text, "a.obj"), Soup([], faces), points)


def test_relative_indices_count_from_the_vertices_read_so_far() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\nf 1 2 -1 -2\n"
    mesh = parse(text.encode(), "a.obj")
    assert mesh.corners.tolist() == [0, 1, 2, 0, 2, 3, 0, 1, 3, 2]
    assert mesh.offsets.tolist() == [0, 3, 6, 10]


def test_a_face_may_come_before_its_vertices() -> None:
    assert parse(f"f 1 2 3 4\n{SQUARE}".encode(), "a.obj").corners.tolist() == [0, 1, 2, 3]


def test_a_name_that_ends_in_a_backslash_swallows_nothing() -> None:
    text = f"{SQUARE}mtllib C:\\textures\\\nf 1 2 3\nusemtl a\\\nf 1 2 3 4\n# b\\\nf 4 3 2\n"
    assert parse(text.encode(), "a.obj").arities().tolist() == [3, 4, 3]


def test_bytes_that_are_no_utf8_may_stand_in_names_and_comments() -> None:
    text = b"# caf\xe9\ng \xff\xfe\n" + SQUARE.encode() + b"usemtl \x80\nf 1 2 3 4 # \xe9\n"
    assert parse(text, "a.obj").n_faces == 1


REFUSED = [
    # text, line, token, part of the message
    (SQUARE + "f 1 2 3 5\n", 5, "5", "does not define: it has 4"),
    (SQUARE + "f 1/1 2/2 99/3\n", 5, "99/3", "does not define"),
    (SQUARE + "f 1 2 0 4\n", 5, "0", "from 1"),
    (SQUARE + "f 1 2 -0\n", 5, "-0", "from 1"),
    (SQUARE + "f -1 -2 -5\n", 5, "-5", "4 were read so far"),
    ("v 0 0 0\nf -1 -1 -2\n" + SQUARE, 2, "-2", "1 were read so far"),
    (SQUARE + "f 1 2\n", 5, "1 2", "3 are the fewest"),
    (SQUARE + "f\n", 5, "", "3 are the fewest"),
    (SQUARE + "f" + " 1" * 100_001 + "\n", 5, "1" + " 1" * 15, "100,000 are the most"),
    (SQUARE + "f 1 2 x\n", 5, "x", "not a corner"),
    (SQUARE + "f 1 2 3.0\n", 5, "3.0", "not a corner"),
    (SQUARE + "f 1 2 +3\n", 5, "+3", "not a corner"),
    (SQUARE + "f 1 2 /3\n", 5, "/3", "not a corner"),
    (SQUARE + "f 1 2 3/1/1/1\n", 5, "3/1/1/1", "not a corner"),
    (SQUARE + "f 1 2 99999999999999999999\n", 5, "99999999999999999999", "so many"),
    (SQUARE + "f 1 2 4294967297\n", 5, "4294967297", "does not define"),
    (SQUARE + "f 1 2 -9223372036854775809\n", 5, "-9223372036854775809", "so many"),
    (SQUARE + "f 1 2 " + "9" * 5000 + "\n", 5, "9" * 59 + "…", "so many"),
    ("v 0 nan 0\n" + SQUARE + "f 1 2 3\n", 1, "nan", "finite"),
    ("v 0 -inf 0\n" + SQUARE + "f 1 2 3\n", 1, "-inf", "finite"),
    ("v 0 1e999 0\n" + SQUARE + "f 1 2 3\n", 1, "1e999", "too large"),
    ("v 0 0 0 0 1e999 .5\n" + SQUARE + "f 1 2 3\n", 1, "1e999", "too large"),
    ("v 0 0 0 1E+0999\n" + SQUARE + "f 1 2 3\n", 1, "1E+0999", "too large"),
    ("v 0 0 0 " + "9" * 320 + "\n" + SQUARE + "f 1 2 3\n", 1, None, "too large"),
    ("v 0 1_000 0\n" + SQUARE + "f 1 2 3\n", 1, "1_000", "not a number"),
    ("v 0 0x10 0\n" + SQUARE + "f 1 2 3\n", 1, "0x10", "not a number"),
    ("v 0 ١ 0\n" + SQUARE + "f 1 2 3\n", 1, "١", "not a number"),
    ("v 0 1,5 0\n" + SQUARE + "f 1 2 3\n", 1, "1,5", "as a point"),
    ("v 0 1e 0\n" + SQUARE + "f 1 2 3\n", 1, "1e", "not a number"),
    ("v 0 . 0\n" + SQUARE + "f 1 2 3\n", 1, ".", "not a number"),
    ("v 0 0\n" + SQUARE + "f 1 2 3\n", 1, "0 0", "has 2"),
    ("v 0 0 0 0 0\n" + SQUARE + "f 1 2 3\n", 1, "0 0 0 0 0", "has 5"),
    (SQUARE + "face 1 2 3\n", 5, "face", "keyword"),
    (SQUARE + "f 1 2 3\n1 2 3\n", 6, "1", "keyword"),
    (SQUARE + "F 1 2 3\n", 5, "F", "keyword"),
    (SQUARE + "call other.obj\n", 5, "call", "includes"),
    (SQUARE + "csh rm\n", 5, "csh", "shell"),
    (SQUARE + "f 1 2 3 \\\n", 5, None, "continued"),
    (SQUARE + "f 1 2 \\\n 3 \\\n 9\nf 1 2 3\n", 5, "9", "does not define"),
    (SQUARE + "f 1 2 \\ \n 3\n", 5, "\\", "not a corner"),
    (SQUARE + "g a\0b\nf 1 2 3\n", 5, None, "NUL"),
    (SQUARE.replace("\n", "\r\n") + "\r\nf 1 2 7\r\n", 6, "7", "does not define"),
    (SQUARE.replace("\n", "\r") + "\rf 1 2 7\r", 6, "7", "does not define"),
    (SQUARE + "# " + "x" * 2**22 + "\nf 1 2 3\n", 5, None, "longer than"),
    (SQUARE + "f 1 2 3 \\\n" * 2**20, 5, None, "longer than"),
    (SQUARE, None, None, "no faces"),
    ("\n", None, None, "no faces"),
]


@pytest.mark.parametrize(("text", "line", "token", "part"), REFUSED)
def test_refuses(text: str, line: int | None, token: str | None, part: str) -> None:
    with pytest.raises(MeshFileError) as caught:
        parse(text.encode(), "a.obj")
    message = str(caught.value)
    assert part in message
    assert caught.value.line == line
    assert message.startswith("a.obj:" if line is None else f"a.obj:{line}: ")
    if token is not None:
        assert len(token) > 59 or caught.value.token == token
        assert repr(token) in message


def test_refuses_utf16() -> None:
    with pytest.raises(MeshFileError, match="UTF-16"):
        parse((SQUARE + "f 1 2 3\n").encode("utf-16"), "a.obj")


def test_limits_are_the_callers() -> None:
    text = (SQUARE + "f 1 2 3 4 1 2\n").encode()
    assert parse(text, "a.obj", ReadLimits(max_arity=6)).n_faces == 1
    with pytest.raises(MeshFileError, match="5 are the most"):
        parse(text, "a.obj", ReadLimits(max_arity=5))
    assert parse(text, "a.obj", ReadLimits(max_line_bytes=13)).n_faces == 1
    with pytest.raises(MeshFileError, match="longer than 12 bytes"):
        parse(text, "a.obj", ReadLimits(max_line_bytes=12))


def test_an_error_far_into_a_large_file_has_its_line() -> None:
    n = 60_000
    lines = [f"v {i} 0 0" for i in range(n)] + [f"f {i} {i + 1} {i + 2}" for i in range(1, n - 1)]
    assert len("\n".join(lines)) > obj.CHUNK_BYTES // 2
    for at in (100, n + 5, len(lines) - 1):
        broken = [*lines, *lines[n:]]
        broken[at] += " x"
        with pytest.raises(MeshFileError) as caught:
            parse("\n".join(broken).encode(), "a.obj")
        assert caught.value.line == at + 1
        assert caught.value.token in ("x", f"{at} 0 0 x")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_have_the_counts_of_their_index(path: Path) -> None:
    mesh = read_mesh(path)
    counts = (len(mesh.points), mesh.n_faces, len(mesh.quads()[0]))
    assert counts == count_elements(path)


@pytest.mark.parametrize("path", [*FILES[:12:3], *FILES[12::8]], ids=lambda path: path.name)
def test_files_read_as_the_reference_reads_them(path: Path) -> None:
    data = path.read_bytes()
    points, faces = referenceobj.read(data)
    assert_is(obj.parse_obj(data, path.name, DEFAULT_LIMITS), Soup([], faces), np.array(points))
