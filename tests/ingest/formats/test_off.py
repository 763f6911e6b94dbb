"""OFF files: every way to spell a mesh, and a precise refusal of what is none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.formats import ReadLimits, off, parse
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import MeshFileError
from tests.support.formats.meshwriters import Soup, assert_is, mutations, same, soups

SQUARE = b"OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"


@dataclass(frozen=True)
class OffStyle:
    """One way to write an OFF file."""

    keyword: str = "OFF"
    extra: int = 0
    counts_behind: bool = False
    edges: bool = True
    newline: str = "\n"
    bom: bool = False
    last_newline: bool = True
    blank: str = " "
    colour: str = ""
    tail: str = ""
    between: str = ""


off_styles = st.builds(
    lambda vertex, **rest: OffStyle(*vertex, **rest),
    st.sampled_from(
        [("OFF", 0), ("COFF", 3), ("COFF", 4), ("NOFF", 3), ("CNOFF", 7), ("STCNOFF", 9)]
    ),
    counts_behind=st.booleans(),
    edges=st.booleans(),
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    bom=st.booleans(),
    last_newline=st.booleans(),
    blank=st.sampled_from([" ", "\t", "   ", " \t "]),
    colour=st.sampled_from(["", " 7", " 255 0 10", " 0.5 .25 1 1e0"]),
    tail=st.sampled_from(["", " ", "\t", " # said by hand", "#"]),
    between=st.sampled_from(["", "\n", "# 1 2 3\n", "  # OFF\n\n"]),
)


def off_bytes(soup: Soup, style: OffStyle = OffStyle()) -> bytes:
    """The soup as an OFF file."""
    counts = style.blank.join(
        [str(len(soup.points)), str(len(soup.faces)), *(["0"] if style.edges else [])]
    )
    heads = [f"{style.keyword} {counts}"] if style.counts_behind else [style.keyword, counts]
    rows = [style.blank.join([*map(repr, p), *["0.5"] * style.extra]) for p in soup.points]
    rows += [style.blank.join(map(str, [len(f), *f])) + style.colour for f in soup.faces]
    text = "".join(line + style.tail + "\n" + style.between for line in [*heads, *rows])
    if not style.last_newline:
        text = text.rstrip("\n")
    return (b"\xef\xbb\xbf" if style.bom else b"") + text.replace("\n", style.newline).encode()


@given(soups(), off_styles)
def test_reads_every_spelling_exactly(soup: Soup, style: OffStyle) -> None:
    assert_is(parse(off_bytes(soup, style), "a.off"), soup)


@given(soups(), off_styles)
def test_line_by_line_the_same_is_read(soup: Soup, style: OffStyle) -> None:
    data = off_bytes(soup, style)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(off._Rows, "peek_block", lambda self, count: None)
        assert_is(parse(data, "a.off"), soup)


def test_a_colour_that_is_too_large_is_told_as_a_coordinate_is() -> None:
    with pytest.raises(MeshFileError, match=r"too large for a coordinate.*1e999"):
        parse(b"COFF\n1 1 0\n0 0 0 1e999 0.5 0.5 0.5\n3 0 0 0\n", "a.off")


@given(soups(coordinates=st.integers(-9, 9).map(float)), off_styles, st.data())
def test_damaged_files_fare_the_same_either_way(
    soup: Soup, style: OffStyle, data: st.DataObject
) -> None:
    tokens = [b"-1", b"3", b"1e9", b"\n", b"#", b"x", b".", b"nan", b"64", b"1e999"]
    damaged = data.draw(mutations(off_bytes(soup, style), tokens))
    with pytest.MonkeyPatch.context() as patch:
        fast = _outcome(damaged)
        patch.setattr(off._Rows, "peek_block", lambda self, count: None)
        slow = _outcome(damaged)
    if isinstance(fast, str) or isinstance(slow, str):
        assert fast == slow
    else:
        assert same(fast, slow)


def _outcome(data: bytes) -> PolygonMesh | str:
    try:
        return parse(data, "a.off")
    except MeshFileError as error:
        assert str(error).startswith("a.off")
        return str(error)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        (b"OFF\n", b"", 1, "first word must be OFF"),
        (b"OFF", b"OFFF", 1, "first word must be OFF"),
        (b"OFF", b"4OFF", 1, "more than three coordinates"),
        (b"OFF", b"nOFF", 1, "more than three coordinates"),
        (b"OFF", b"OFF BINARY", 1, "binary"),
        (b"4 1 0", b"4 1 0 9", 2, "counts are three numbers"),
        (b"4 1 0", b"4 -1 0", 2, "natural number"),
        (b"4 1 0", b"4 0 0", 2, "no faces"),
        (b"4 1 0", b"4000000 1 0", 2, "promise at least"),
        (b"4 1 0", b"99999999999999999999 1 0", 2, "natural number"),
        (b"4 1 0", b"5 1 0", 7, "a vertex has 3 numbers"),
        (b"4 1 0", b"4 2 0", 7, "cut short"),
        (b"4 1 0", b"3 1 0", 6, "face 0 has 0 corners"),
        (b"1 1 0", b"1 1", 5, "a vertex has 3 numbers, this one has 2"),
        (b"1 1 0", b"1 1 0 255 0 0", 5, "begins with COFF"),
        (b"OFF", b"COFF", 3, "with its colour has 6 or 7 numbers"),
        (b"1 1 0", b"1 nan 0", 5, "finite"),
        (b"1 1 0", b"1 0,5 0", 5, "decimal sign"),
        (b"1 1 0", b"1 1_0 0", 5, "not a number"),
        (b"1 1 0", b"1 1e999 0", 5, "too large"),
        (b"4 0 1 2 3", b"2 0 1", 7, "face 0 has 2 corners"),
        (b"4 0 1 2 3", b"4 0 1 2", 7, "here 3 numbers follow"),
        (b"4 0 1 2 3", b"3 0 1 2 3 4", 7, "here 5 numbers follow"),
        (b"4 0 1 2 3", b"4 0 1 2 4", 7, "names vertex 4, but the vertices are 0 to 3"),
        (b"4 0 1 2 3", b"4 0 1 2 -1", 7, "natural number"),
        (b"4 0 1 2 3", b"4 0 1 2 1.0", 7, "natural number"),
        (b"4 0 1 2 3", b"4 0 1 2 3 red", 7, "not a number"),
        (b"4 0 1 2 3\n", b"4 0 1 2 3\n\n3 0 1 2\n", 9, "more lines"),
        (b"1 1 0", b"1 1 0\0", 5, "NUL"),
    ],
)
def test_refusals_name_file_line_and_reason(old: bytes, new: bytes, line: int, words: str) -> None:
    with pytest.raises(MeshFileError) as caught:
        parse(SQUARE.replace(old, new, 1), "mesh/a.off")
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"mesh/a.off:{line}: ")
    assert caught.value.line == line


def test_limits_hold() -> None:
    big = b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n100001" + b" 0" * 100_001 + b"\n"
    with pytest.raises(MeshFileError, match="100,001 corners; 100,000 are the most"):
        parse(big, "a.off")
    assert parse(big, "a.off", ReadLimits(max_arity=100_001)).n_faces == 1
    with pytest.raises(MeshFileError, match=r"a\.off:1: the line is longer"):
        parse(b"OFF #" + b"x" * 2**22, "a.off")


def test_colours_do_not_shift_what_follows() -> None:
    mesh = parse(
        b"OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 2 0\n4 0 1 2 3 255 0 0\n3 3 2 4 .5 .5 .5 1\n",
        "a.off",
    )
    assert mesh.faces() == [[0, 1, 2, 3], [3, 2, 4]]
    assert np.array_equal(mesh.points[4], [0, 2, 0])
