"""Patterns, fills and sheets of them show themselves in a notebook."""

from __future__ import annotations

import re
import struct
import xml.etree.ElementTree as ET

import pytest

import patterndb
from patterndb.notebook import draw_sheet


def _fills(source: object, limit: int = 5) -> list[patterndb.Fill]:
    boundary = patterndb.Boundary((3, 5, 4, 6))
    return list(source.fills(boundary, limit=limit))  # type: ignore[arg-type]


def _assert_svg(text: str, quads: int | None = None) -> None:
    root = ET.fromstring(text)
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    if quads is not None:
        (group,) = (e for e in root.iter() if e.get("id") == "quads")
        assert len(list(group.iter("{http://www.w3.org/2000/svg}path"))) == quads


def _assert_png(data: bytes) -> None:
    assert data.startswith(b"\x89PNG\r\n\x1a\n") and data.endswith(b"IEND\xaeB`\x82")
    width, height = struct.unpack(">II", data[16:24])
    assert width > 100 and height > 100


def test_a_pattern_and_a_fill_are_pictures(source: patterndb.Database) -> None:
    fill = _fills(source, 1)[0]
    _assert_svg(fill._repr_svg_(), len(fill.quads))
    _assert_png(fill._repr_png_())
    _assert_svg(fill.pattern._repr_svg_(), fill.pattern.n_quads)
    _assert_png(fill.pattern._repr_png_())
    assert fill.pattern.name in fill._repr_svg_()


def test_a_sheet_is_a_list_and_a_picture_of_all(source: patterndb.Database) -> None:
    boundary = patterndb.Boundary((3, 5, 4, 6))
    sheet = patterndb.Sheet(source.fills(boundary), 5, title="five fills")
    assert len(sheet) == 5 and isinstance(sheet, list)
    svg = sheet._repr_svg_()
    assert svg is not None and "five fills" in svg
    _assert_svg(svg)
    png = sheet._repr_png_()
    assert png is not None
    _assert_png(png)
    mixed = patterndb.Sheet([sheet[0], sheet[0].pattern])
    assert mixed._repr_svg_() is not None


def test_an_empty_sheet_is_no_picture() -> None:
    empty = patterndb.Sheet([])
    assert empty._repr_svg_() is None and empty._repr_png_() is None
    assert repr(empty) == "[]"
    with pytest.raises(ValueError, match="empty"):
        draw_sheet([], ".svg")


def test_reprs_are_one_line_of_facts(source: patterndb.Database) -> None:
    fill = _fills(source, 1)[0]
    assert re.fullmatch(
        r"<Fill of sides 3, 5, 4, 6: \d+ quads, 2 irregular, learned pattern [0-9a-f]{16}>",
        repr(fill),
    )
    assert re.fullmatch(
        r"<Pattern [0-9a-f]{16}: 4 sides, 2 irregular \(valences 3, 5\), seen [\d,]+×>",
        repr(fill.pattern),
    )
    assert re.fullmatch(r"<Database .*: [\d,]+ patterns of \d+ meshes, open to read>", repr(source))
