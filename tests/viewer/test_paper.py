"""Pages as PNG: polygons and letters are where the page has them, without the system's fonts."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from numpy.typing import NDArray

from viewer import style
from viewer.paper import DPI, POINTS_PER_INCH, Page, list_font_files


def paint(page: Page, dpi: float = DPI) -> NDArray[np.float64]:
    """(h, w, 3) the pixels of a page, 0 to 1."""
    image = pytest.importorskip("matplotlib.image")
    return np.asarray(image.imread(io.BytesIO(page.encode_png(dpi))), np.float64)[..., :3]


def square(low: float, high: float) -> NDArray[np.float64]:
    return np.array([[low, low], [high, low], [high, high], [low, high]])


def test_a_png_has_the_pixels_that_its_inches_ask_for() -> None:
    page = Page(72.0, 36.0)
    assert struct.unpack(">II", page.encode_png()[16:24]) == (DPI, DPI // 2)
    assert struct.unpack(">II", page.encode_png(300.0)[16:24]) == (300, 150)
    assert page.encode_png() == page.encode_png()


def test_polygons_are_painted_in_order_where_they_are() -> None:
    page = Page(10.0, 10.0)
    page.polygons(np.stack([square(0.0, 8.0), square(0.0, 4.0)]), faces=np.eye(3)[:2])
    page.polygons(square(6.0, 10.0)[None], line="#000000", width=1.0)
    seen = paint(page, POINTS_PER_INCH)
    # The lower left of the page is the last row's first pixel.
    assert seen[9, 0].tolist() == [0.0, 1.0, 0.0] and seen[5, 5].tolist() == [1.0, 0.0, 0.0]
    assert seen[0, 0] == pytest.approx(style.parse_colour(style.PAPER), abs=0.01)
    assert 0.4 < seen[2, 6, 0] < 0.6 and seen[2, 8].tolist() == seen[0, 0].tolist()


def test_polygons_of_one_colour_have_no_seam() -> None:
    page = Page(10.0, 10.0)
    halves = np.array(
        [[[1.3, 1], [5.37, 1], [5.37, 9], [1.3, 9]], [[5.37, 1], [9, 1], [9, 9], [5.37, 9]]]
    )
    page.polygons(halves, face="#204080")
    row = paint(page, POINTS_PER_INCH)[5, 2:9]
    assert np.abs(row - style.parse_colour("#204080")).max() < 0.01
    assert (
        page.format_svg().count("<path") == 2 and page.format_svg(joined=True).count("<path") == 1
    )


@pytest.mark.parametrize("mono", [False, True])
@pytest.mark.parametrize("bold", [False, True])
def test_text_is_lettered_with_the_fonts_that_come_along(bold: bool, mono: bool) -> None:
    assert len(list_font_files()) == 4

    def ink(text: str, *, bold: bool = bold) -> float:
        page = Page(100.0, 20.0)
        page.text(50.0, 6.0, text, 10.0, bold=bold, mono=mono)
        return float((1.0 - paint(page)).sum())

    assert ink("Äb ×→ ≤ é Ж π") > ink("Äb ×") > ink("") == pytest.approx(0.0)
    assert ink("patterns", bold=True) > 1.1 * ink("patterns", bold=False)


@pytest.mark.parametrize(("align", "middle"), [("left", 57.2), ("center", 50.0), ("right", 42.8)])
def test_a_line_stands_where_it_is_aligned(align: str, middle: float) -> None:
    page = Page(100.0, 20.0)
    page.text(50.0, 6.0, "HHH", 8.0, mono=True, align=align)
    dark = np.flatnonzero((paint(page, POINTS_PER_INCH).mean(axis=2) < 0.7).any(axis=0))
    assert abs(dark.mean() + 0.5 - middle) < 0.8
