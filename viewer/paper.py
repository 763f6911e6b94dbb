"""Paints drawings on a page measured in points, and writes it to a file: PNG or SVG.

A page keeps what is painted on it, in order, positions, line widths and type all in points of 1/72
inch. An SVG has text as text, and one path for every polygon; a PNG is what resvg paints of it,
with the fonts in viewer/fonts, so that a machine without fonts letters it alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import PatternDBError
from patterndb.system.deadline import run_until_late
from patterndb.system.files import replace_file
from viewer import style
from viewer.card import Card
from viewer.drawing import draw_disk
from viewer.painting import PaintedPolygons, PaintTarget, Text, paint_disk, paint_legend

#: Pixels of a PNG per inch.
DPI = 160

POINTS_PER_INCH = 72.0

#: Suffixes a picture may have.
SUFFIXES = (".png", ".svg")

#: Digits of a point that an SVG gives: a hundredth is far below what can be seen.
SVG_DIGITS = 2

#: What an SVG's text is set in: the first that there is.
SVG_FONTS = {False: "'DejaVu Sans', Verdana, sans-serif", True: "'DejaVu Sans Mono', monospace"}

SVG_ANCHORS = {"left": "start", "center": "middle", "right": "end"}


class PictureFormatError(PatternDBError, ValueError):
    """A picture's file name does not say a format that pictures can have."""


class Page(PaintTarget):
    """A blank page, width and height in points, origin at the lower left."""

    def __init__(self, width: float, height: float) -> None:
        self.width = width
        self.height = height
        self.items: list[PaintedPolygons | Text] = []

    def add(self, item: PaintedPolygons | Text) -> None:
        """Keep one more thing."""
        self.items.append(item)

    def save(self, path: Path) -> None:
        """Write the page; the same page gives the same bytes."""
        replace_file(path, self.encode(path))

    def encode(self, path: Path) -> bytes:
        """Return the page as the bytes of a file of this name."""
        vector = check_suffix(path) == ".svg"
        return self.format_svg().encode() if vector else self.encode_png()

    def encode_png(self, dpi: float = DPI) -> bytes:
        """Return the page as the bytes of a PNG file, with this many pixels to the inch."""
        from resvg_py import svg_to_bytes

        text = self.format_svg(joined=True)
        return bytes(
            svg_to_bytes(text, dpi=dpi, skip_system_fonts=True, font_files=list_font_files())
        )

    def format_svg(self, *, joined: bool = False) -> str:
        """Return the page as the text of an SVG file.

        joined: one path for polygons of one colour that follow each other, which is painted much
        faster, and without seams between them.
        """
        size = f'width="{self.width:g}pt" height="{self.height:g}pt"'
        lines = [
            '<?xml version="1.0" encoding="utf-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} '
            f'viewBox="0 0 {self.width:g} {self.height:g}">',
            f'<rect width="100%" height="100%" fill="{style.PAPER}"/>',
        ]
        for item in self.items:
            if isinstance(item, Text):
                lines.append(self._format_text(item))
            else:
                lines += self._format_polygons(item, joined)
        return "\n".join((*lines, "</svg>", ""))

    def _format_text(self, item: Text) -> str:
        weight = ' font-weight="bold"' if item.bold else ""
        return (
            f'<text x="{_number(item.x)}" y="{_number(self.height - item.y)}" '
            f'font-size="{_number(item.size)}" font-family="{SVG_FONTS[item.mono]}"{weight} '
            f'text-anchor="{SVG_ANCHORS[item.align]}" fill="{item.colour}" '
            f'xml:space="preserve">{escape(item.text)}</text>'
        )

    def _format_polygons(self, item: PaintedPolygons, joined: bool) -> Iterator[str]:
        named = "" if item.gid is None else f" id={quoteattr(item.gid)}"
        stroke = "" if item.line == "none" else f' stroke="{item.line}"'
        if stroke:
            stroke += f' stroke-width="{item.width:.3g}" stroke-linejoin="round"'
        same = item.faces is None or bool((item.faces == item.faces[:1]).all())
        shared = ""
        if item.faces is None:
            shared = ' fill="none"'
        elif same and len(item.faces):
            shared = f' fill="{_hex(item.faces[0])}"'
        yield f"<g{named}{shared}{stroke}>"
        places = (item.corners * (1.0, -1.0) + (0.0, self.height)).tolist()
        ways = [f"M{'L'.join(f'{_number(x)} {_number(y)}' for x, y in one)}Z" for one in places]
        fills = [""] * len(ways)
        if not same and item.faces is not None:
            fills = [f' fill="{_hex(face)}"' for face in item.faces]
        # Polygons with a face and a line lie over each other, line over face: they stay apart.
        if joined and (item.faces is None or not stroke):
            runs = groupby(zip(fills, ways, strict=True), itemgetter(0))
            for fill, run in runs:
                yield f'<path{fill} d="{"".join(way for _, way in run)}"/>'
        else:
            for fill, way in zip(fills, ways, strict=True):
                yield f'<path{fill} d="{way}"/>'
        yield "</g>"


@cache
def list_font_files() -> list[str]:
    """List the files of the fonts that PNGs are lettered with."""
    folder = files("viewer") / "fonts"
    return sorted(str(one) for one in folder.iterdir() if one.name.endswith(".ttf"))


def _number(value: float) -> str:
    """A length in an SVG, without zeros at its end."""
    return f"{value:.{SVG_DIGITS}f}".rstrip("0").rstrip(".")


def _hex(colour: NDArray[np.float64]) -> str:
    return "#" + "".join(f"{round(part * 255.0):02x}" for part in colour.tolist())


def check_suffix(path: Path) -> str:
    """Return the picture's suffix, lower case; PictureFormatError if it is not one of SUFFIXES."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise PictureFormatError(
            f"{path}: a picture's name ends in {' or '.join(SUFFIXES)}, "
            f"not in {suffix or 'nothing'}"
        )
    return suffix


# A picture of one disk, as PNG or SVG.

#: Side of the square a disk is drawn in, in points.
SIZE = 300.0

MARGIN = 18.0


def save_picture(
    path: Path | str, card: Card, *, mirrored: bool = False, tinted: bool = True
) -> Path:
    """Draw one disk with its caption and legend.

    path: ends in .png or .svg, which says the format. mirrored: draw the mirror image.
    tinted: with the polychords' bands. Returns the path. The same input gives the same
    bytes; an SVG keeps its text as text and one path per quad in the group "quads".

    Raises PictureFormatError for another suffix, OSError as writing does, and TimeLimitError where
    the thread's deadline (:mod:`patterndb.system.deadline`) passes before.
    """
    path = Path(path)
    check_suffix(path)

    def paint() -> bytes:
        return _paint_card(card, mirrored, tinted).encode(path)

    replace_file(path, run_until_late(paint, "the picture was drawn"))
    return path


def _paint_card(card: Card, mirrored: bool, tinted: bool) -> Page:
    """The page of one disk with its caption and legend."""
    drawing = draw_disk(
        card.disk, mirrored=mirrored, tinted=tinted, points=card.points, marks=card.marks
    )
    lines = [card.facts, *card.details]
    lines = [line for line in lines if line]
    head = (16.0 if card.title else 0.0) + 12.0 * len(lines)
    foot = 26.0
    half_height = float(drawing.points[:, 1].max()) * SIZE / 2.0
    width = SIZE + 2.0 * MARGIN
    height = 2.0 * half_height + head + foot + 2.0 * MARGIN
    page = Page(width, height)
    middle = width / 2.0
    paint_disk(page, drawing, middle, height - MARGIN - half_height, SIZE, "quads")
    y = height - MARGIN - 2.0 * half_height - 20.0
    if card.title:
        title = card.title if card.rank is None else f"{card.rank}   {card.title}"
        page.text(middle, y, title, 11.0, mono=True, bold=True)
        y -= 15.0
    for line in lines:
        page.text(middle, y, line, 8.0, colour=style.FAINT_TEXT)
        y -= 12.0
    paint_legend(page, [drawing], middle, 13.0, 7.0)
    return page
