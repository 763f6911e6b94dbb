"""Paints drawings on a matplotlib page measured in points, and writes it to a file.

A page is one axes over the whole figure whose data unit is 1/72 inch, so that positions,
line widths and type are all in one unit. Nothing of matplotlib's global state is used.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from viewer import style
from viewer.card import Card
from viewer.drawing import draw_disk
from viewer.painting import paint_disk, paint_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes


#: Pixels of a PNG per inch.
DPI = 160

POINTS_PER_INCH = 72.0

#: Suffixes a picture may have.
SUFFIXES = (".png", ".svg")


class PictureFormatError(PatternDBError, ValueError):
    """A picture's file name does not say a format that pictures can have."""


class Page:
    """A blank page, width and height in points, origin at the lower left."""

    def __init__(self, width: float, height: float) -> None:
        # matplotlib takes a third of a second to import; most verbs draw nothing.
        from matplotlib.figure import Figure

        inches = (width / POINTS_PER_INCH, height / POINTS_PER_INCH)
        self.figure = Figure(figsize=inches, dpi=DPI, facecolor=style.PAPER)
        axes: Axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_xlim(0.0, width)
        axes.set_ylim(0.0, height)
        axes.axis("off")
        self.axes = axes

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float,
        *,
        colour: str = style.TEXT,
        bold: bool = False,
        mono: bool = False,
        align: str = "center",
    ) -> None:
        """Write a line whose baseline is at y; align: "left", "center" or "right"."""
        options: dict[str, Any] = {
            "fontsize": size,
            "color": colour,
            "ha": align,
            "va": "baseline",
            "fontweight": "bold" if bold else "normal",
            "family": "DejaVu Sans Mono" if mono else "DejaVu Sans",
            # A dollar sign in a caption is a dollar sign.
            "parse_math": False,
        }
        self.axes.text(x, y, text, **options)

    def polygons(
        self,
        corners: Points,
        *,
        face: str = "none",
        faces: Points | None = None,
        line: str = "none",
        width: float = 0.0,
        gid: str | None = None,
    ) -> None:
        """Paint (n, c, 2) polygons, one colour for all or (n, 3) colours."""
        from matplotlib.collections import PolyCollection

        verts: Any = corners
        paint: Any = face if faces is None else faces
        collection = PolyCollection(
            verts, facecolors=paint, edgecolors=line, linewidths=width, joinstyle="round"
        )
        collection.set_gid(gid)
        self.axes.add_collection(collection, autolim=False)

    def save(self, path: Path) -> None:
        """Write the page; the same page gives the same bytes."""
        import matplotlib as mpl

        vector = check_suffix(path) == ".svg"
        settings: dict[Any, Any] = {"svg.fonttype": "none", "svg.hashsalt": "patterndb"}
        metadata: dict[str, None] = {"Date": None} if vector else {"Software": None}
        with mpl.rc_context(settings):
            self.figure.savefig(path, format=path.suffix[1:].lower(), metadata=metadata, dpi=DPI)


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

    Raises PictureFormatError for another suffix, and OSError as writing does.
    """
    path = Path(path)
    check_suffix(path)
    drawing = draw_disk(card.disk, mirrored=mirrored, tinted=tinted)
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
