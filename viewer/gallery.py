"""Contact sheets: many disks on a page, in rank order, with one legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from viewer import style
from viewer.card import Card
from viewer.drawing import DiskDrawing, draw_disk
from viewer.painting import paint_disk, paint_legend
from viewer.paper import Page, check_suffix

#: (items, columns, cell in points): the first row that holds a page's items is taken.
LAYOUTS = ((3, 3, 150.0), (8, 4, 132.0), (20, 5, 116.0), (42, 6, 104.0), (80, 8, 92.0))

#: For more than the last of LAYOUTS.
WIDEST = (10, 84.0)

GAP = 16.0
CAPTION = 24.0
MARGIN = 26.0
TITLE = 34.0
LEGEND = 26.0

#: Points of a line of facts, and the least that all of a page are set in for one of them; below,
#: a long line is set smaller than the others.
FACTS = 7.0
LEAST_FACTS = 5.5

#: Items a page holds unless asked otherwise, and at most.
PER_PAGE = 60
MOST_PER_PAGE = 200


@dataclass(frozen=True, slots=True)
class Grid:
    """How a page's cells lie; lengths in points."""

    columns: int
    rows: int
    cell: float

    @classmethod
    def of(cls, n_items: int) -> Grid:
        """The grid for a page of so many items."""
        columns, cell = next(((c, s) for n, c, s in LAYOUTS if n_items <= n), WIDEST)
        columns = max(1, min(columns, n_items))
        return cls(columns, max(1, math.ceil(n_items / columns)), cell)

    @property
    def width(self) -> float:
        # A title needs room even above a single cell.
        return max(2.0 * MARGIN + self.columns * (self.cell + GAP) - GAP, 330.0)

    @property
    def height(self) -> float:
        rows = self.rows * (self.cell + CAPTION + GAP) - GAP
        return 2.0 * MARGIN + TITLE + rows + LEGEND

    def centre(self, item: int) -> tuple[float, float]:
        """Centre of an item's square, the first at the upper left."""
        row, column = divmod(item, self.columns)
        used = self.columns * (self.cell + GAP) - GAP
        x = (self.width - used) / 2.0 + column * (self.cell + GAP) + self.cell / 2.0
        top = self.height - MARGIN - TITLE
        return x, top - row * (self.cell + CAPTION + GAP) - self.cell / 2.0


def save_gallery(
    path: Path | str,
    cards: Sequence[Card],
    *,
    title: str = "",
    per_page: int = PER_PAGE,
    tinted: bool = True,
) -> list[Path]:
    """Draw a contact sheet; several if there are more than ``per_page`` cards.

    path: ends in .png or .svg. One page is written to it; of several, page k to the name
    with -k before the suffix (sheet-1.png, sheet-2.png). Returns the paths, none for no
    cards.

    Raises PictureFormatError for another suffix, ValueError if per_page is not in
    1..MOST_PER_PAGE, and OSError as writing does.
    """
    path = Path(path)
    check_suffix(path)
    if not 1 <= per_page <= MOST_PER_PAGE:
        raise ValueError(f"a page holds 1 to {MOST_PER_PAGE} items, not {per_page}")
    pages = [cards[i : i + per_page] for i in range(0, len(cards), per_page)]
    paths: list[Path] = []
    for number, items in enumerate(pages, start=1):
        name, counter = path, ""
        if len(pages) > 1:
            name = path.with_name(f"{path.stem}-{number}{path.suffix}")
            counter = f"page {number} of {len(pages)}"
        # The last page keeps the others' cells: a reader compares across pages.
        grid = Grid.of(len(items) if len(pages) == 1 else per_page)
        grid = Grid(grid.columns, math.ceil(len(items) / grid.columns), grid.cell)
        _page(grid, items, title, counter, tinted).save(name)
        paths.append(name)
    return paths


def _page(grid: Grid, cards: Sequence[Card], title: str, counter: str, tinted: bool) -> Page:
    page = Page(grid.width, grid.height)
    middle = grid.width / 2.0
    head = grid.height - MARGIN - 10.0
    if title:
        page.text(MARGIN, head, title, 13.0, bold=True, align="left")
    if counter:
        right = grid.width - MARGIN
        page.text(right, head, counter, 8.0, colour=style.FAINT_TEXT, align="right")
    drawings: list[DiskDrawing] = []
    longest = max(len(card.facts) for card in cards)
    size = max(LEAST_FACTS, _fitting(longest, grid.cell))
    for i, card in enumerate(cards):
        drawing = draw_disk(card.disk, tinted=tinted, points=card.points, marks=card.marks)
        drawings.append(drawing)
        x, y = grid.centre(i)
        paint_disk(page, drawing, x, y, grid.cell, f"quads-{i + 1}")
        _caption(page, card, x, y - grid.cell / 2.0 - 10.0, grid.cell, size)
    paint_legend(page, drawings, middle, MARGIN - 4.0, 8.0)
    return page


def _fitting(letters: int, cell: float) -> float:
    """The size, in points, at which a line of facts fits a cell."""
    return min(FACTS, cell / (0.56 * max(letters, 1)))


def _caption(page: Page, card: Card, x: float, y: float, cell: float, facts: float) -> None:
    # 0.602: the width of a DejaVu Sans Mono letter; 16 hex digits must fit the cell.
    title = card.title
    size = min(6.5, cell / (0.602 * max(len(title) + 5, 1)))
    if card.rank is not None:
        width = 0.602 * size * (len(title) + 1)
        rank = f"{card.rank}"
        left = x - (width + 0.64 * 7.0 * len(rank)) / 2.0
        page.text(left, y, rank, 7.0, bold=True, align="left")
        left += 0.7 * 7.0 * len(rank) + 0.602 * size
        page.text(left, y, title, size, mono=True, colour=style.FAINT_TEXT, align="left")
    elif title:
        page.text(x, y, title, size, mono=True, colour=style.FAINT_TEXT)
    if card.facts:
        page.text(x, y - 10.5, card.facts, min(facts, _fitting(len(card.facts), cell)))
