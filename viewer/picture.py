"""A picture of one disk, as PNG or SVG."""

from __future__ import annotations

from pathlib import Path

from viewer import style
from viewer.card import Card
from viewer.drawing import draw
from viewer.painting import paint_disk, paint_legend
from viewer.paper import Page, check_suffix

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

    Raises PictureFormatError for another suffix, and OSError as writing does.
    """
    path = Path(path)
    check_suffix(path)
    drawing = draw(card.disk, mirrored=mirrored, tinted=tinted)
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
    page.save(path)
    return path
