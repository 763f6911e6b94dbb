"""How patterns and fills show themselves in a notebook, one by one or as a sheet.

``Pattern`` and ``Fill`` know nothing of drawing. Their ``_repr_svg_`` and ``_repr_png_`` ask what
the face has named (:mod:`patterndb.core.display`), which is :func:`draw`; only then is the viewer
imported. Beside the face, this is the one module here that knows what stands above.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from patterndb.core.display import Suffix
from patterndb.core.pattern import Pattern

if TYPE_CHECKING:
    from query.fill import Fill

#: Pictures that a sheet has unless asked otherwise: as many as one page holds.
SHEET_LENGTH = 60


class Sheet(list["Pattern | Fill"]):
    """A list of patterns or fills that a notebook shows as one sheet of pictures.

    Example: ``patterndb.Sheet(db.fills((3, 5, 4, 6)))``
    """

    def __init__(
        self, items: Iterable[Pattern | Fill], limit: int = SHEET_LENGTH, *, title: str = ""
    ) -> None:
        """Take the first ``limit`` of the items, which may be a stream of fills."""
        super().__init__(islice(items, limit))
        self.title = title

    def _repr_svg_(self) -> str | None:
        return draw_sheet(self, ".svg", self.title).decode() if self else None

    def _repr_png_(self) -> bytes | None:
        return draw_sheet(self, ".png", self.title) if self else None


def draw(item: Pattern | Fill, suffix: Suffix) -> bytes:
    """Return a picture of one pattern or fill, as the bytes of an SVG or PNG file."""
    from viewer import save_picture

    with tempfile.TemporaryDirectory() as folder:
        return save_picture(Path(folder) / f"picture{suffix}", _card_of(item)).read_bytes()


def draw_sheet(items: Iterable[Pattern | Fill], suffix: Suffix, title: str = "") -> bytes:
    """Return a sheet of patterns and fills, as the bytes of an SVG or PNG file."""
    from viewer import save_gallery

    cards = [_card_of(item, rank) for rank, item in enumerate(items, 1)]
    if not cards:
        raise ValueError("there is nothing to draw: the list is empty")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"sheet{suffix}"
        (page,) = save_gallery(path, cards, title=title, per_page=max(len(cards), 1))
        return page.read_bytes()


def _card_of(item: Pattern | Fill, rank: int | None = None) -> Any:
    from viewer.card import Card

    if isinstance(item, Pattern):
        return Card.of_pattern(item, rank)
    return Card.of_disk(item.disk(), item.pattern.name, rank)
