from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ingest.formats import ReadLimits, parse
from ingest.formats.plybody import TextBody
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError
from tests.support.formats.meshwriters import (
    PlyStyle,
    Soup,
    assert_is,
    mutations,
    patient,
    ply_bytes,
    ply_styles,
    same,
    soups,
)

SQUARE = Soup([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [[0, 1, 2, 3], [0, 1, 2]])
HEADER = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""
POINTS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
TEXT = HEADER + POINTS + "4 0 1 2 3\n"
TOKENS = (
    b"0 1 3 4 -1 1.5 nan inf 1e999 1_0 0x1 255 4294967295 99999999999 007 \n \n\n \r \0 \t "
    b"property element vertex face list uchar int float x end_header"
).split(b" ")


@settings(patient, max_examples=100)
@given(soups(), ply_styles)
def test_every_spelling_reads_back_exactly(soup: Soup, style: PlyStyle) -> None:
    assert_is(parse(ply_bytes(soup, style), "a.ply"), soup)


@patient
@given(soups(st.floats(width=32, allow_nan=False, allow_infinity=False)), st.sampled_from("<>"))
def test_single_precision_keeps_its_value(soup: Soup, order: str) -> None:
    assert_is(parse(ply_bytes(soup, PlyStyle(order=order, number="float")), "a.ply"), soup)


@patient
@given(
    soups(st.integers(-128, 127)),
    st.sampled_from(["", "<", ">"]),
    st.sampled_from(["char", "int16"]),
)
def test_coordinates_may_be_integers(soup: Soup, order: str, number: str) -> None:
    assert_is(parse(ply_bytes(soup, PlyStyle(order=order, number=number)), "a.ply"), soup)


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_faces_of_one_arity_and_of_several(order: str) -> None:
    points = [(float(i), 0.0, 1.0) for i in range(70)]
    for arities in ([4] * 50, [4, 3] * 25, [3, 64, 4]):
        soup = Soup(points, [[(i + k) % 70 for k in range(n)] for i, n in enumerate(arities)])
        assert_is(parse(ply_bytes(soup, PlyStyle(order=order)), "a.ply"), soup)


@settings(patient, max_examples=150)
@given(st.data())
def test_lines_one_by_one_read_as_all_at_once(data: st.DataObject) -> None:
    style = data.draw(ply_styles.filter(lambda style: style.order == ""))
    tame = st.floats(-9, 9, allow_subnormal=False).map(lambda x: round(x, 2))
    text = data.draw(mutations(ply_bytes(data.draw(soups(tame)), style), TOKENS))
    fast = _outcome(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(TextBody, "_take_uniform", lambda self, element, pattern: None)
        slow = _outcome(text)
    assert type(fast) is type(slow)
    if isinstance(fast, PolygonMesh) and isinstance(slow, PolygonMesh):
        assert same(fast, slow)
    else:
        assert str(fast) == str(slow)


def _outcome(data: bytes) -> PolygonMesh | MeshFileError:
    try:
        return parse(data, "a.ply")
    except MeshFileError as error:
        return error


def test_values_nobody_asked_for_may_be_anything() -> None:
    text = TEXT.replace("float z\n", "float z\nproperty float quality\n")
    text = text.replace(POINTS, POINTS.replace("0\n", "0 nan\n"))
    assert parse(text.encode(), "a.ply").n_faces == 1


def test_the_last_newline_may_be_missing() -> None:
    assert parse(TEXT.rstrip().encode(), "a.ply").corners.tolist() == [0, 1, 2, 3]


REFUSED = [
    # what is replaced, by what, line, token, part of the message
    ("ply\n", "plyx\n", 1, None, "not a PLY file"),
    ("ply\n", "", 1, None, "not a PLY file"),
    ("ascii 1.0", "ascii 2.0", 2, "format ascii 2.0", "unknown format"),
    ("format ascii 1.0\n", "", 8, None, "no 'format'"),
    ("float x", "real x", 4, "real", "unknown type"),
    ("property float x\n", "", 3, None, "no number x"),
    ("float x", "list uchar float x", 3, None, "no number x"),
    ("float y", "float x", 5, "x", "second property"),
    ("element face 1", "element vertex 1", 7, "vertex", "second element"),
    ("element vertex 4\n", "", 3, "property float x", "before any element"),
    ("vertex 4", "vertex -4", 3, "-4", "natural number"),
    ("vertex 4", "vertex 4.0", 3, "4.0", "natural number"),
    ("vertex 4", "vertex 4000000000", 3, None, "promises 4,000,000,000"),
    ("face 1", "face 999999999999999999", 7, None, "promises"),
    ("face 1", "face 0", 7, None, "no faces"),
    ("vertex 4", "vertex 3", 13, "0 1 0", "exactly one face"),
    ("vertex 4", "vertex 5", 14, "4 0 1 2 3", "exactly one vertex"),
    ("face 1", "face 2", 14, None, "cut short"),
    ("vertex_indices", "corners", 7, None, "no list vertex_indices"),
    ("list uchar int", "list uchar float", 7, None, "integer type"),
    ("list uchar int", "int", 7, None, "integer type"),
    ("list uchar int", "list float int", 8, "float", "integer type"),
    ("list uchar int", "list uchar", 8, "list uchar vertex_indices", "property is"),
    ("element face 1", "element tristrips 1", 7, None, "strips"),
    ("end_header\n", "", 9, "0", "not a line of a PLY header"),
    ("end_header\n" + POINTS + "4 0 1 2 3\n", "", 9, None, "no 'end_header'"),
    ("1 1 0\n", "1 nan 0\n", 12, "nan", "finite"),
    ("1 1 0\n", "1 1e400 0\n", 12, "1e400", "too large"),
    ("1 1 0\n", "1 1_0 0\n", 12, "1_0", "not a number"),
    ("1 1 0\n", "1 1\n", 12, "1 1", "too many or too few"),
    ("1 1 0\n", "1 1 0 0\n", 12, "1 1 0 0", "too many or too few"),
    ("4 0 1 2 3", "4 0 1 2 4", 14, "4", "names vertex 4"),
    ("4 0 1 2 3", "4 0 1 2 -1", 14, "-1", "natural number"),
    ("4 0 1 2 3", "4 0 1 2 3.0", 14, "3.0", "natural number"),
    ("4 0 1 2 3", "4 0 1 2 99999999999999999999", 14, "99999999999999999999", "natural number"),
    ("4 0 1 2 3", "4 0 1 2 4294967296", 14, "4294967296", "names vertex"),
    ("4 0 1 2 3", "4 0 1 2", 14, "4 0 1 2", "too many or too few"),
    ("4 0 1 2 3", "3 0 1 2 3", 14, "3 0 1 2 3", "too many or too few"),
    ("4 0 1 2 3", "2 0 1", 14, "2", "has 2 corners"),
    ("4 0 1 2 3", "100001" + " 0" * 100_001, 14, "100001", "has 100,001 corners"),
    ("4 0 1 2 3", "999999999999999999 0", 14, None, "too many or too few"),
    ("4 0 1 2 3\n", "4 0 1 2 3\n\n0\n", 16, "0", "more lines"),
    ("4 0 1 2 3\n", "\n\n", 15, None, "cut short"),
    ("1 1 0\n", "1 1\0 0\n", 12, None, "NUL"),
    ("float x", "float\0x", 4, None, "NUL"),
    ("1 1 0\n", "1 1 0" + " " * 2**22 + "\n", 12, None, "longer than"),
]


@pytest.mark.parametrize(("old", "new", "line", "token", "part"), REFUSED)
def test_refuses(old: str, new: str, line: int | None, token: str | None, part: str) -> None:
    with pytest.raises(MeshFileError) as caught:
        parse(TEXT.replace(old, new, 1).encode(), "a.ply")
    assert part in str(caught.value)
    assert caught.value.line == line
    if token is not None:
        assert caught.value.token is not None
        assert caught.value.token.startswith(token)


@pytest.mark.parametrize("order", ["<", ">"])
class TestBinary:
    def test_every_truncation_is_refused(self, order: str) -> None:
        for after in (None, "list uchar float"):
            data = ply_bytes(SQUARE, PlyStyle(order=order, face_after=after))
            for length in range(len(data)):
                with pytest.raises(MeshFileError):
                    parse(data[:length], "a.ply")

    def test_trailing_bytes_are_refused(self, order: str) -> None:
        data = ply_bytes(SQUARE, PlyStyle(order=order))
        with pytest.raises(MeshFileError, match=f"1 bytes too many .* from byte {len(data)}"):
            parse(data + b"\n", "a.ply")

    def test_promises_are_not_believed(self, order: str) -> None:
        data = ply_bytes(SQUARE, PlyStyle(order=order, count="uint32"))
        for count in (b"3", b"4000000000", b"999999999999999999"):
            for old in (b"vertex 4", b"face 2"):
                with pytest.raises(MeshFileError):
                    parse(data.replace(old, old[:-1] + count), "a.ply")
        # the length of a list
        at = len(data) - 4 * (1 + 3)
        huge = data[:at] + struct.pack(order + "I", 2**32 - 1) + data[at + 4 :]
        with pytest.raises(MeshFileError, match="ends at byte"):
            parse(huge, "a.ply")
        first = at - 4 * (1 + 4)
        huge = data[:first] + struct.pack(order + "I", 2**32 - 1) + data[first + 4 :]
        with pytest.raises(MeshFileError, match="ends at byte"):
            parse(huge, "a.ply")

    def test_a_negative_length_is_refused(self, order: str) -> None:
        data = ply_bytes(SQUARE, PlyStyle(order=order, count="char"))
        at = len(data) - 1 - 4 * 3
        with pytest.raises(MeshFileError, match=f"negative length -1 at byte {at}"):
            parse(data[:at] + b"\xff" + data[at + 1 :], "a.ply")

    def test_a_wrong_index_has_its_face_and_byte(self, order: str) -> None:
        data = ply_bytes(SQUARE, PlyStyle(order=order))
        for index in (4, -1, 2**31 - 1, -(2**31)):
            wrong = data[:-4] + struct.pack(order + "i", index)
            where = f"face 1 at byte {len(data) - 13} names vertex {index},"
            with pytest.raises(MeshFileError, match=where):
                parse(wrong, "a.ply")

    def test_an_unsigned_index_does_not_wrap(self, order: str) -> None:
        data = ply_bytes(SQUARE, PlyStyle(order=order, index="uint"))
        with pytest.raises(MeshFileError, match="names vertex 4294967295"):
            parse(data[:-4] + b"\xff" * 4, "a.ply")

    @pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize("extra", [None, "list uchar float"])
    def test_a_point_that_is_not_finite_is_refused(
        self, order: str, number: float, extra: str | None
    ) -> None:
        points = [*SQUARE.points[:2], (0.0, number, 0.0), SQUARE.points[3]]
        style = PlyStyle(order=order, vertex_extra=extra)
        with pytest.raises(MeshFileError, match=r"vertex 2 at byte \d+ is not finite"):
            parse(ply_bytes(Soup(points, SQUARE.faces), style), "a.ply")

    @pytest.mark.parametrize(
        "faces", [[[0, 1]], [[0, 1, 2], [0, 1]], [[0] * 101], [[0] * 3, [0] * 101]]
    )
    def test_arities_out_of_bounds_are_refused(self, order: str, faces: list[list[int]]) -> None:
        data = ply_bytes(Soup(SQUARE.points, faces), PlyStyle(order=order))
        with pytest.raises(MeshFileError, match=f"has {len(faces[-1])} corners; (3|100) are"):
            parse(data, "a.ply", ReadLimits(max_arity=100))

    def test_an_unused_list_may_be_long(self, order: str) -> None:
        data = ply_bytes(SQUARE, PlyStyle(order=order))
        data = data.replace(b"end_header", b"element x 1\nproperty list int uchar y\nend_header")
        assert parse(data + struct.pack(order + "i", 500) + bytes(500), "a.ply").n_faces == 2


def test_many_properties_are_read_in_linear_time() -> None:
    names = "".join(f"property uchar p{i}\n" for i in range(40_000))
    text = TEXT.replace("float z\n", "float z\n" + names)
    with pytest.raises(MeshFileError, match="promises 4 of element vertex"):
        parse(text.encode(), "a.ply")


def test_a_header_without_end_is_given_up() -> None:
    with pytest.raises(MeshFileError, match="end_header"):
        parse(b"ply\n" + b"comment x\n" * 200_000, "a.ply")


def test_limits_are_the_callers() -> None:
    with pytest.raises(MeshFileError, match="3 are the most"):
        parse(TEXT.encode(), "a.ply", ReadLimits(max_arity=3))
