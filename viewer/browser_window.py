"""The pattern browser's window: a page of small pictures, the selected pattern, and filters."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPixmap, QResizeEvent
from PySide6.QtWidgets import QCheckBox, QComboBox, QSplitter, QWidget

from patterndb.core.pattern import Pattern
from viewer.browser_state import PER_PAGE, VALENCE_RANGES, BrowserState
from viewer.card import format_valences
from viewer.drawing import draw_disk
from viewer.scene import Scene
from viewer.shell.docks import Dock, Thumbnail, ThumbnailList, make_count_field, make_form
from viewer.shell.qtpaint import paint_scene, paint_thumbnail
from viewer.shell.scene import GROUNDS
from viewer.shell.window import ShellWindow
from viewer.stage import Drawn

#: Most irregular vertices that can be asked for.
MOST_IRREGULAR = 99


class FlatPane(QWidget):
    """Shows a flat scene."""

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumSize(160, 160)
        self._scene: Scene | None = None
        self._ground = GROUNDS[False]

    def show_scene(self, scene: Scene, ground: str) -> None:
        """Show another."""
        self._scene, self._ground = scene, ground
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Paint it."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(self._ground))
        if self._scene is not None:
            paint_scene(painter, self._scene)
        painter.end()


def paint_pattern(
    pattern: Pattern, mirrored: bool, tinted: bool, size: int, density: float
) -> QPixmap:
    """Paint a small picture of a pattern."""
    drawing = draw_disk(pattern.disk(), mirrored=mirrored, tinted=tinted)
    return paint_thumbnail(drawing, size, density)


class PatternPane(QSplitter):
    """A page of small pictures, and the selected pattern at its side.

    changed: another pattern was selected. asked: a picture is due.
    """

    changed = Signal()
    asked = Signal()

    def __init__(self, parent: QWidget, state: BrowserState) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        self.state = state
        self.list = ThumbnailList(self._choose, size=112)
        self.pane = FlatPane()
        self.addWidget(self.list)
        self.addWidget(self.pane)
        self.setSizes([560, 440])
        self.setFocusProxy(self.list)
        self._ground = GROUNDS[False]
        self._pending = QTimer(self)
        self._pending.setSingleShot(True)
        self._pending.timeout.connect(self.asked.emit)
        self.splitterMoved.connect(lambda *_: self.ask_picture())

    @property
    def room(self) -> tuple[float, float]:
        """Width and height of the selected pattern's picture, in points."""
        return float(max(self.pane.width(), 1)), float(max(self.pane.height(), 1))

    def set_ground(self, *, dark: bool) -> None:
        """Choose the ground's colour for light or dark windows."""
        self._ground = GROUNDS[dark]

    def ask_picture(self) -> None:
        """Have the pictures drawn soon."""
        if not self._pending.isActive():
            self._pending.start(0)

    def show_picture(self, drawn: Drawn) -> None:
        """Show the page and the selected pattern."""
        self.pane.show_scene(drawn.scene, self._ground)
        state = self.state
        first = state.page * PER_PAGE
        patterns = [state.patterns.pattern(int(row)) for row in state.page_rows()]
        looks = (state.mirrored, state.tinted)
        wanted = [
            Thumbnail(
                (pattern.code.tobytes(), looks),
                f"{first + number + 1}: {format_valences(pattern.valences)}",
                partial(paint_pattern, pattern, *looks),
                f"{pattern.name}: {format_valences(pattern.valences)}, "
                f"seen {pattern.frequency:,} times",
            )
            for number, pattern in enumerate(patterns)
        ]
        self.list.show_thumbnails(wanted, state.position - first if wanted else None)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw anew."""
        super().resizeEvent(event)
        self.ask_picture()

    def _choose(self, number: int) -> None:
        self.state.message = ""
        self.state.select(self.state.page * PER_PAGE + number)
        self.changed.emit()


class BrowserWindow(ShellWindow):
    """Shows patterns, with filters and facts."""

    state: BrowserState

    picture: PatternPane

    def make_picture(self) -> PatternPane:
        """Make the widget in the middle."""
        pane = PatternPane(self, self.saver.state)
        pane.asked.connect(self.refresh)
        pane.changed.connect(self.show_change)
        return pane

    def make_docks(self) -> list[Dock]:
        """Make the dock of filters."""
        dock = Dock("Filters", self)
        # Of whatever state is shown then: another database may be opened.
        self.sides = QComboBox()
        self.sides.setToolTip("Patterns of so many sides")
        self.sides.activated.connect(
            lambda row: self.change(lambda: self.state.choose_class(self.state.classes[row]))
        )
        self.irregular = make_count_field(
            (-1, MOST_IRREGULAR), "Patterns of so many irregular vertices",
            lambda count: self.change(lambda: self.state.limit_irregular(count)), "any number",
        )  # fmt: skip
        self.valences = QComboBox()
        for one in VALENCE_RANGES:
            self.valences.addItem("any" if one is None else f"{one[0]} to {one[1]}")
        self.valences.setToolTip("Patterns whose irregular vertices have so many quads")
        self.valences.activated.connect(
            lambda row: self.change(lambda: self.state.choose_valences(VALENCE_RANGES[row]))
        )
        self.convex = QCheckBox("convex patterns only")
        self.convex.setToolTip("Patterns without a reflex corner")
        self.convex.clicked.connect(lambda _: self.change(self.state.toggle_convex))
        rows = [
            ("sides", self.sides),
            ("irregular vertices", self.irregular),
            ("valences", self.valences),
            ("", self.convex),
        ]
        dock.show_scrolled(make_form(rows))
        return [dock]

    def refresh_docks(self) -> None:
        """Show the filters as they are now."""
        state = self.state
        classes = [str(n) for n in state.classes]
        if classes != [self.sides.itemText(row) for row in range(self.sides.count())]:
            self.sides.clear()
            self.sides.addItems(classes)
        self.sides.setCurrentIndex(state.classes.index(state.patterns.n_sides))
        self.irregular.setValue(-1 if state.n_irregular is None else state.n_irregular)
        self.valences.setCurrentIndex(VALENCE_RANGES.index(state.valences))
        self.convex.setChecked(state.convex_only)
