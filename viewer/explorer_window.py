"""The fill explorer's window: the shell of all windows, with docks of the next fills and wishes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from query import Boundary, Fill, Stroke
from viewer.card import format_count
from viewer.drawing import draw_disk
from viewer.explorer_state import ExplorerState
from viewer.fillcard import make_fill_card
from viewer.finder import MAX_TOLERANCE
from viewer.shell.docks import Dock, PictureKey, Thumbnail, ThumbnailList, make_count_field
from viewer.shell.qtpaint import paint_thumbnail
from viewer.shell.window import ShellWindow

#: Fills that have a picture in the list: those before and after the one that is looked at.
SHOWN = 60

#: Limits of what can be wished; the least of each stands for "any number".
MOST_IRREGULAR, VALENCES = 99, (3, 12)


def paint_fill(
    fill: Fill,
    boundary: Boundary | None,
    strokes: Sequence[Stroke],
    tolerance: int,
    size: int,
    density: float,
) -> QPixmap:
    """Paint a small picture of a fill, with the strokes that were asked for."""
    assert boundary is not None
    card = make_fill_card(fill, boundary, strokes, tolerance)
    drawing = draw_disk(card.disk, points=card.points, marks=card.marks)
    return paint_thumbnail(drawing, size, density)


class ExplorerWindow(ShellWindow):
    """Shows fills with small pictures of the next ones, and what they shall be like."""

    state: ExplorerState

    def make_docks(self) -> list[Dock]:
        """Make the lists of fills and of wishes."""
        fills = Dock("Fills", self)
        self.thumbnails = ThumbnailList(
            self._choose, empty="fills of the boundary appear here; click one to see it"
        )
        fills.setWidget(self.thumbnails)
        wishes = Dock("Wishes", self)
        wishes.show_scrolled(self._make_wishes())
        return [fills, wishes]

    def refresh_docks(self) -> None:
        """Show the fills and the wishes as they are now."""
        finder = self.state.finder
        first = self._first()
        listed = finder.fills[first : first + SHOWN]
        wanted = [
            Thumbnail(
                PictureKey(fill),
                f"{first + number + 1}: {fill.n_quads}q",
                partial(paint_fill, fill, finder.boundary, tuple(finder.strokes), finder.tolerance),
                f"{fill.pattern.name}: {format_count(fill.n_quads, 'quad')}, "
                f"{fill.n_irregular} irregular, {fill.origin}",
            )
            for number, fill in enumerate(listed)
        ]
        self.thumbnails.show_thumbnails(wanted, finder.rank - first if wanted else None)
        self._refresh_wishes()

    def _first(self) -> int:
        """The rank of the first fill in the list of pictures."""
        rank = self.state.finder.rank
        return max(0, rank - rank % SHOWN)

    def _choose(self, number: int) -> None:
        self.state.finder.look_at(self._first() + number)
        self.show_change()

    # What fills shall be like

    def _make_wishes(self) -> QWidget:
        whole = QWidget()
        layout = QVBoxLayout(whole)
        form = QFormLayout()
        self.order = QComboBox()
        self.order.setToolTip("What comes first")
        self.order.activated.connect(self._choose_order)
        # Of whatever state is shown then: another boundary may be opened.
        self.irregular = make_count_field(
            (-1, MOST_IRREGULAR), "Fills with at most so many irregular vertices",
            lambda most: self._wish(lambda: self.state.finder.limit_irregular(most)), "any number",
        )  # fmt: skip
        self.valence = make_count_field(
            VALENCES, "Fills whose inner vertices have at most so many quads",
            lambda most: self._wish(lambda: self.state.finder.limit_valence(most)), "any",
        )  # fmt: skip
        self.tolerance = make_count_field(
            (0, MAX_TOLERANCE), "Edges that a strand's ends may be off its stroke's",
            lambda edges: self._wish(lambda: self.state.finder.choose_tolerance(edges or 0)),
        )  # fmt: skip
        self.folded = QCheckBox("one fill of each pattern")
        self.folded.setToolTip("List one fill of each pattern, with its variants under it")
        self.folded.clicked.connect(lambda _: self._wish(self.state.finder.toggle_folded))
        form.addRow("order", self.order)
        form.addRow("irregular vertices", self.irregular)
        form.addRow("highest valence", self.valence)
        form.addRow("tolerance", self.tolerance)
        form.addRow(self.folded)
        layout.addLayout(form)
        self.even = QWidget()
        self._even_layout = QVBoxLayout(self.even)
        self._even_layout.setContentsMargins(0, 0, 0, 0)
        self._even_shown: list[tuple[int, int]] = []
        layout.addWidget(self.even)
        layout.addStretch(1)
        return whole

    def _wish(self, do: Callable[[], object]) -> None:
        """A wish is a step that can be taken back."""
        self.change(lambda: (do(), self.state.keep_step()))

    def _choose_order(self, number: int) -> None:
        name = self.order.itemData(number)
        self._wish(lambda: self.state.finder.choose_order(name))

    def _refresh_wishes(self) -> None:
        finder = self.state.finder
        named = [(f"{finder.default_order} (by default)", None)]
        named += [(name, name) for name in finder.list_orders()]
        if [self.order.itemText(i) for i in range(self.order.count())] != [n for n, _ in named]:
            self.order.clear()
            for text, name in named:
                self.order.addItem(text, name)
        self.order.setCurrentIndex(max(0, self.order.findData(finder.order)))
        most, valence = finder.max_irregular, finder.max_valence
        self.irregular.setValue(-1 if most is None else most)
        self.valence.setValue(VALENCES[0] if valence is None else valence)
        self.tolerance.setValue(finder.tolerance)
        self.tolerance.setEnabled(bool(finder.strokes))
        self.folded.setChecked(finder.folded)
        self._refresh_even()

    def _refresh_even(self) -> None:
        """Where the perimeter is odd, offer what would make it even."""
        found = self.state.list_even_lengths()
        if found == self._even_shown:
            return
        self._even_shown = found
        while (item := self._even_layout.takeAt(0)) is not None:
            if (widget := item.widget()) is not None:
                widget.deleteLater()
        if not found:
            return
        label = QLabel("The perimeter is odd. Make it even:")
        label.setWordWrap(True)
        self._even_layout.addWidget(label)
        for side, length in found:
            button = QPushButton(f"side {side}: {length} edges")
            button.setToolTip(f"Give side {side} {length} edges instead")
            button.clicked.connect(partial(self._make_even, side, length))
            self._even_layout.addWidget(button)

    def _make_even(self, side: int, length: int) -> None:
        self._wish(lambda: self.state.choose_length(side, length))
