"""Docks beside a picture: facts, sliders, and lists of small pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QIcon, QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import (
    QDockWidget,
    QDoubleSpinBox,
    QFormLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QListView,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QSlider,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from viewer.facts import FactSheet
from viewer.slider import Slider

#: Steps of a slider from end to end.
STEPS = 1000

#: Width of docks at first, in logical pixels.
DOCK_WIDTH = 300


class Dock(QDockWidget):
    """A dock that is remembered by its title."""

    def __init__(self, title: str, parent: QWidget) -> None:
        super().__init__(title, parent)
        # Its place is remembered by this name.
        self.setObjectName(title.replace(" ", "-").lower())
        self.setMinimumWidth(220)

    def show_scrolled(self, widget: QWidget) -> None:
        """Show a widget, with a bar where it is higher than there is room for."""
        area = QScrollArea(self)
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setWidget(widget)
        self.setWidget(area)


class FactsDock(Dock):
    """Facts, as a sheet gives them; they can be selected and copied."""

    def __init__(self, parent: QWidget, title: str = "Facts") -> None:
        super().__init__(title, parent)
        self.label = QLabel()
        self.label.setWordWrap(True)
        self.label.setTextFormat(Qt.TextFormat.RichText)
        self.label.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.label.setMargin(8)
        self.label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.show_scrolled(self.label)
        self._shown = ""

    def show_facts(self, sheet: FactSheet) -> None:
        """Show a sheet; a text that is selected stays so while the facts are the same."""
        text = sheet.format_html()
        if text != self._shown:
            self._shown = text
            self.label.setText(text)


@dataclass(frozen=True, slots=True)
class SliderRow:
    """A number to choose.

    slider: its ends and steps. get: what it is now. set: makes it another one. begin, end: of
    a drag, which is one step for undo. enabled: does it do anything now? tip: what it does.
    note: what is said behind the name. chosen: is it the one that keys change?
    """

    slider: Slider
    get: Callable[[], float]
    set: Callable[[float], object]
    begin: Callable[[], object] = lambda: None
    end: Callable[[], object] = lambda: None
    enabled: Callable[[], bool] = lambda: True
    tip: str = ""
    note: Callable[[], str] = lambda: ""
    chosen: Callable[[], bool] = lambda: False


class SliderPanel(QWidget):
    """Sliders under each other, each with a field for its number.

    changed: called after a value was changed.
    """

    def __init__(self, rows: Sequence[SliderRow], changed: Callable[[], object]) -> None:
        super().__init__()
        self._changed = changed
        self._refreshing = False
        self.rows: list[tuple[SliderRow, QLabel, QSlider, QDoubleSpinBox]] = []
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 4, 8, 4)
        for row in rows:
            layout.addLayout(self._make_row(row))
        layout.addStretch(1)
        self.refresh()

    def _make_row(self, row: SliderRow) -> QVBoxLayout:
        slider = row.slider
        line, field = QSlider(Qt.Orientation.Horizontal), QDoubleSpinBox()
        line.setRange(0, STEPS)
        field.setRange(slider.low, slider.high)
        field.setDecimals(slider.decimals)
        field.setSuffix(slider.unit)
        field.setSingleStep(slider.step or 10.0**-slider.decimals)
        # A half typed number is no number yet.
        field.setKeyboardTracking(False)
        ends = " … ".join(end for end in slider.ends if end)
        tip = row.tip or (f"{slider.label}: {ends}" if ends else slider.label)
        for widget in (line, field):
            widget.setToolTip(tip)
            widget.setAccessibleName(slider.label)
        line.sliderPressed.connect(row.begin)
        line.sliderReleased.connect(lambda: self._end(row))
        line.valueChanged.connect(lambda at: self._take(row, slider.value(at / STEPS), line))
        field.valueChanged.connect(lambda value: self._take(row, value, None))
        name = QLabel(slider.label)
        name.setBuddy(field)
        head = QHBoxLayout()
        head.addWidget(name, 1)
        head.addWidget(field)
        whole = QVBoxLayout()
        whole.setSpacing(0)
        whole.addLayout(head)
        whole.addWidget(line)
        self.rows.append((row, name, line, field))
        return whole

    def _take(self, row: SliderRow, value: float, line: QSlider | None) -> None:
        if self._refreshing or value == row.get():
            return
        held = line is not None and line.isSliderDown()
        if not held:
            row.begin()
        row.set(value)
        if not held:
            row.end()
        self._changed()

    def _end(self, row: SliderRow) -> None:
        row.end()
        self._changed()

    def refresh(self) -> None:
        """Show what the numbers are now."""
        self._refreshing = True
        try:
            for row, name, line, field in self.rows:
                value = row.get()
                name.setText(("▸ " if row.chosen() else "") + row.slider.label + row.note())
                if not line.isSliderDown():
                    line.setValue(round(STEPS * row.slider.share(value)))
                if not field.hasFocus() or abs(field.value() - value) > 10.0 ** -field.decimals():
                    field.setValue(value)
                for widget in (line, field):
                    widget.setEnabled(row.enabled())
        finally:
            self._refreshing = False


class PictureKey:
    """What a small picture is of, told apart by identity: it holds what it names."""

    def __init__(self, *things: object) -> None:
        self._things = things

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PictureKey) and self._ids() == other._ids()

    def __hash__(self) -> int:
        return hash(self._ids())

    def _ids(self) -> tuple[int, ...]:
        return tuple(id(thing) for thing in self._things)


@dataclass(frozen=True, slots=True)
class Thumbnail:
    """key: what the picture is of; it is painted once. label: below it. paint: paints it, of so
    many logical pixels at a density, whatever has changed since. tip: more of it."""

    key: object
    label: str
    paint: Callable[[int, float], QPixmap] = field(compare=False)
    tip: str = ""


class ThumbnailList(QListWidget):
    """Small pictures in rows; one can be chosen with a click or the arrow keys.

    They are painted one after another, while nothing else goes on. choose: called with the
    number of the one that was chosen. empty: what is said where there are none.
    """

    def __init__(
        self, choose: Callable[[int], object], size: int = 108, lines: int = 1, empty: str = ""
    ) -> None:
        super().__init__()
        self._empty = empty
        self._choose, self._size = choose, size
        self._shown: list[Thumbnail] = []
        self._icons: dict[tuple[object, float], QIcon] = {}
        self._waiting: list[int] = []
        self._refreshing = False
        self._painter = QTimer(self)
        self._painter.timeout.connect(self._paint_next)
        self.setViewMode(QListView.ViewMode.IconMode)
        self.setResizeMode(QListView.ResizeMode.Adjust)
        self.setMovement(QListView.Movement.Static)
        self.setIconSize(QSize(size, size))
        self.setGridSize(QSize(size + 12, size + 10 + 18 * lines))
        self.setWordWrap(True)
        self.setUniformItemSizes(True)
        self.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.currentRowChanged.connect(self._chosen)

    def _chosen(self, row: int) -> None:
        if not self._refreshing and row >= 0:
            self._choose(row)

    def show_thumbnails(self, wanted: Sequence[Thumbnail], chosen: int | None) -> None:
        """Show these, one of them chosen; pictures that were painted are kept."""
        self._refreshing = True
        try:
            if list(wanted) != self._shown:
                self._fill(wanted)
            row = -1 if chosen is None else chosen
            if row != self.currentRow():
                self.setCurrentRow(row)
                item = self.item(row)
                if item is not None:
                    self.scrollToItem(item)
        finally:
            self._refreshing = False

    def _fill(self, wanted: Sequence[Thumbnail]) -> None:
        kept = 0
        while kept < min(len(wanted), len(self._shown)) and wanted[kept] == self._shown[kept]:
            kept += 1
        while self.count() > kept:
            self.takeItem(self.count() - 1)
        self._shown = list(wanted)
        # A picture that waits has its room already.
        blank = QPixmap(self._size, self._size)
        blank.fill(Qt.GlobalColor.transparent)
        for one in wanted[kept:]:
            item = QListWidgetItem(QIcon(blank), one.label)
            item.setToolTip(one.tip or one.label)
            item.setTextAlignment(Qt.AlignmentFlag.AlignHCenter)
            self.addItem(item)
        keys = {one.key for one in wanted}
        self._icons = {key: icon for key, icon in self._icons.items() if key[0] in keys}
        self._waiting = [n for n in self._waiting if n < kept] + list(range(kept, len(wanted)))
        self._painter.start(0)

    def paintEvent(self, e: QPaintEvent) -> None:
        """Paint the pictures, or say that there are none."""
        super().paintEvent(e)
        if not self.count() and self._empty:
            painter = QPainter(self.viewport())
            painter.setPen(self.palette().placeholderText().color())
            around = self.viewport().rect().adjusted(12, 12, -12, -12)
            flags = Qt.AlignmentFlag.AlignHCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(around, int(flags), self._empty)
            painter.end()

    @property
    def is_painting(self) -> bool:
        """Are there pictures that wait to be painted?"""
        return bool(self._waiting)

    def _paint_next(self) -> None:
        """Paint one picture; those after it wait for what else there is to do."""
        if not self._waiting:
            self._painter.stop()
            return
        number, density = self._waiting.pop(0), self.devicePixelRatioF()
        key = (self._shown[number].key, density)
        if key not in self._icons:
            painted = self._shown[number].paint(self._size, density)
            self._icons[key] = icon = QIcon(painted)
            # As it is where it is chosen, too: its colours say something.
            icon.addPixmap(painted, QIcon.Mode.Selected)
        item = self.item(number)
        if item is not None:
            item.setIcon(self._icons[key])


#: Buttons of tools: the one in use stands out, in dark windows too, and is as large as the others,
#: as the picture must not be moved by taking it.
TOOL_BUTTONS = """
QToolButton {border: 1px solid transparent; border-radius: 3px; padding: 2px 6px}
QToolButton:hover, QToolButton:focus {border-color: palette(highlight)}
QToolButton:checked {background: palette(highlight); color: palette(highlighted-text)}
"""


def make_form(rows: Sequence[tuple[str, QWidget]]) -> QWidget:
    """Make a widget of named rows."""
    widget = QWidget()
    form = QFormLayout(widget)
    for name, entry in rows:
        form.addRow(name, entry)
    return widget


def make_count_field(
    ends: tuple[int, int], tip: str, choose: Callable[[int | None], object], least: str = ""
) -> QSpinBox:
    """Make a field for a whole number; least: what the least one stands for, None, if it does."""
    field = QSpinBox()
    field.setRange(*ends)
    field.setSpecialValueText(least)
    field.setToolTip(tip)
    # A half typed number is no number yet.
    field.setKeyboardTracking(False)
    field.valueChanged.connect(lambda value: choose(None if least and value == ends[0] else value))
    return field
