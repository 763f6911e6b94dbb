"""The fill explorer's window: the shell of all windows, with docks of the next fills and wishes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QGridLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from patterndb_sketch.fillfinder import MAX_TOLERANCE
from query import Boundary, Fill, Stroke
from viewer.card import format_count
from viewer.drawing import draw_disk
from viewer.explorer_state import ExplorerState
from viewer.fillcard import make_fill_card
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


class EvenOffers(QScrollArea):
    """Buttons for numbers of edges that would make an odd perimeter even, a row for each side.

    choose: called with a side and its number. mean: called with the side whose button the pointer
    or the keyboard is on, and with None when it leaves.
    """

    def __init__(
        self, choose: Callable[[int, int], object], mean: Callable[[int | None], object]
    ) -> None:
        super().__init__()
        self._choose, self._mean = choose, mean
        self._lengths: tuple[int, ...] = ()
        self._sides: dict[QObject, int] = {}
        self.offered: list[tuple[int, int]] = []
        self.setWidgetResizable(True)

    def offer(self, lengths: tuple[int, ...], offered: list[tuple[int, int]]) -> None:
        """Offer (side, edges) for sides with these edges."""
        if (lengths, offered) == (self._lengths, self.offered):
            return
        self._lengths, self.offered, self._sides = lengths, offered, {}
        whole = QWidget()
        grid = QGridLayout(whole)
        label = QLabel("The perimeter is odd: no quads fill it. Give one side another number:")
        label.setWordWrap(True)
        grid.addWidget(label, 0, 0, 1, 3)
        for side, length in offered:
            button = QPushButton(str(length))
            button.setToolTip(f"{format_count(length, 'edge')} on this side instead")
            button.clicked.connect(partial(self._choose, side, length))
            button.installEventFilter(self)
            self._sides[button] = side
            grid.addWidget(QLabel(f"side of {lengths[side]}"), side + 1, 0)
            grid.addWidget(button, side + 1, 1 if length < lengths[side] else 2)
        grid.setRowStretch(len(lengths) + 1, 1)
        self.setWidget(whole)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Tell which side is meant."""
        side = self._sides.get(watched)
        if side is not None and event.type() in (QEvent.Type.Enter, QEvent.Type.FocusIn):
            self._mean(side)
        elif side is not None and event.type() in (QEvent.Type.Leave, QEvent.Type.FocusOut):
            self._mean(None)
        return super().eventFilter(watched, event)


class ExplorerWindow(ShellWindow):
    """Shows fills with small pictures of the next ones, and what they shall be like."""

    state: ExplorerState

    def make_docks(self) -> list[Dock]:
        """Make the lists of fills and of wishes."""
        fills = Dock("Fills", self)
        self.thumbnails = ThumbnailList(
            self._choose, empty="fills of the boundary appear here; click one to see it"
        )
        self.even = EvenOffers(self._make_even, self._mean_side)
        # In place of the fills, which there are none of then.
        both = QWidget()
        layout = QVBoxLayout(both)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.even)
        layout.addWidget(self.thumbnails)
        fills.setWidget(both)
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
        layout.addStretch(1)
        return whole

    def _wish(self, do: Callable[[], object]) -> None:
        """A wish is a step that can be taken back."""
        self.change(lambda: (do(), self.state.exploration.keep_step()))

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
        contour = self.state.contour
        self.even.offer(
            () if contour is None else contour.lengths, self.state.exploration.list_even_lengths()
        )
        self.even.setVisible(bool(self.even.offered))
        self.thumbnails.setVisible(not self.even.offered)

    def _make_even(self, side: int, length: int) -> None:
        self._mean_side(None)
        self._wish(lambda: self.state.exploration.choose_length(side, length))

    def _mean_side(self, side: int | None) -> None:
        """Show which side a button is about."""
        if self.state.meant_side != side:
            self.state.meant_side = side
            self.show_change()
