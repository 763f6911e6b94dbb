"""Contact sheets: many disks on a page, in rank order, with one legend."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence, Sized
from dataclasses import dataclass
from pathlib import Path

from patterndb.errors import TimeLimitError
from patterndb.system.deadline import extend_deadline, run_until_late
from patterndb.system.files import replace_file
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

#: Seconds after a deadline in which a page may be painted of what was drawn before: enough for
#: sixty fills of some hundred quads.
PAINTING_SECONDS = 0.25


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
    cards: Iterable[Card],
    *,
    title: str = "",
    per_page: int = PER_PAGE,
    tinted: bool = True,
) -> list[Path]:
    """Draw a contact sheet; several if there are more than ``per_page`` cards.

    path: ends in .png or .svg. One page is written to it; of several, page k to the name
    with -k before the suffix (sheet-1.png, sheet-2.png). Returns the paths, none for no
    cards. cards: taken one at a time; only those of a page are held.

    Raises PictureFormatError for another suffix, ValueError if per_page is not in
    1..MOST_PER_PAGE, OSError as writing does, and TimeLimitError where the thread's deadline
    (:mod:`patterndb.system.deadline`) passes before all is drawn; what was drawn is written then.
    """
    n_cards = len(cards) if isinstance(cards, Sized) else None
    sheet = GallerySheet(path, title=title, per_page=per_page, tinted=tinted, n_cards=n_cards)
    late: TimeLimitError | None = None
    for card in cards:
        try:
            sheet.add(card)
        except TimeLimitError as error:
            late = error
            break
    paths = sheet.close()
    if late is not None:
        raise late
    return paths


class GallerySheet:
    """A contact sheet that grows card by card; see :func:`save_gallery`.

    n_cards: how many cards there will be, where that is known: pages are counted then.
    written: how many cards are on the pages written so far. paths: of these pages.
    """

    def __init__(
        self,
        path: Path | str,
        *,
        title: str = "",
        per_page: int = PER_PAGE,
        tinted: bool = True,
        n_cards: int | None = None,
    ) -> None:
        self.written = 0
        self.paths: list[Path] = []
        self._path = Path(path)
        check_suffix(self._path)
        if not 1 <= per_page <= MOST_PER_PAGE:
            raise ValueError(f"a page holds 1 to {MOST_PER_PAGE} items, not {per_page}")
        self._title, self._per_page, self._tinted = title, per_page, tinted
        self._of = "" if n_cards is None else f" of {math.ceil(n_cards / per_page)}"
        self._drawn: list[DrawnCard] = []

    def add(self, card: Card) -> None:
        """Draw a card; a page that it does not fit on any more is written first.

        Raises TimeLimitError where the thread's deadline passes before; the card is left out.
        """
        if len(self._drawn) == self._per_page:
            self._write_page(False)

        def draw() -> DiskDrawing:
            return draw_disk(card.disk, tinted=self._tinted, points=card.points, marks=card.marks)

        self._drawn.append(DrawnCard(card, run_until_late(draw, "the picture was drawn")))

    def close(self) -> list[Path]:
        """Write the last page; return the paths of all.

        After the thread's deadline, it may take PAINTING_SECONDS. Raises TimeLimitError where that
        is not enough.
        """
        if self._drawn:
            self._write_page(True)
        return self.paths

    def _write_page(self, last: bool) -> None:
        cards = self._drawn
        name, counter = self._path, ""
        alone = last and not self.paths
        if not alone:
            number = len(self.paths) + 1
            name = self._path.with_name(f"{self._path.stem}-{number}{self._path.suffix}")
            counter = f"page {number}{self._of}"
        # The last page keeps the others' cells: a reader compares across pages.
        grid = Grid.of(len(cards) if alone else self._per_page)
        grid = Grid(grid.columns, math.ceil(len(cards) / grid.columns), grid.cell)

        def paint() -> bytes:
            return _page(grid, cards, self._title, counter).encode(name)

        with extend_deadline(PAINTING_SECONDS):
            content = run_until_late(paint, "the picture was painted")
        replace_file(name, content)
        self.paths.append(name)
        self.written += len(cards)
        self._drawn = []


@dataclass(frozen=True, slots=True, eq=False)
class DrawnCard:
    """A card with its disk laid out."""

    card: Card
    drawing: DiskDrawing


def _page(grid: Grid, cards: Sequence[DrawnCard], title: str, counter: str) -> Page:
    page = Page(grid.width, grid.height)
    middle = grid.width / 2.0
    head = grid.height - MARGIN - 10.0
    if title:
        page.text(MARGIN, head, title, 13.0, bold=True, align="left")
    if counter:
        right = grid.width - MARGIN
        page.text(right, head, counter, 8.0, colour=style.FAINT_TEXT, align="right")
    longest = max(len(one.card.facts) for one in cards)
    size = max(LEAST_FACTS, _fitting(longest, grid.cell))
    for i, one in enumerate(cards):
        x, y = grid.centre(i)
        paint_disk(page, one.drawing, x, y, grid.cell, f"quads-{i + 1}")
        _caption(page, one.card, x, y - grid.cell / 2.0 - 10.0, grid.cell, size)
    paint_legend(page, [one.drawing for one in cards], middle, MARGIN - 4.0, 8.0)
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
