"""The window of retopology: the shell of all windows, with tools, their options, and next fills."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QGridLayout,
    QLabel,
    QLineEdit,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling.choice import Choice
from patterndb_sketch.retopo.filling.placing import fill_of
from viewer.card import format_count
from viewer.drawing import draw_disk
from viewer.retopo.modes import ToolMode, ToolOption
from viewer.retopo.state import RetopoState
from viewer.shell.docks import TOOL_BUTTONS, Dock, PictureKey, Thumbnail, ThumbnailList
from viewer.shell.qtpaint import paint_thumbnail
from viewer.shell.scene import SceneView
from viewer.shell.window import ShellWindow

#: Columns of the tools' buttons, and fills of a patch that have a picture.
COLUMNS, SHOWN = 2, 40


def paint_choice(choice: Choice, size: int, density: float) -> QPixmap:
    """Paint a small picture of a fill that a patch can have."""
    return paint_thumbnail(draw_disk(fill_of(choice).disk()), size, density)


class RetopoView(SceneView):
    """A picture whose wheel and left button know the keys that are held down with them."""

    state: RetopoState

    def press_left(self, at: tuple[float, float], modifiers: Qt.KeyboardModifier) -> None:
        """Use the tool; with Ctrl, move curves nearby."""
        tweak = bool(modifiers & Qt.KeyboardModifier.ControlModifier)
        if self.state.press(*at, tweak=tweak):
            self.changed.emit()

    def turn_wheel(self, steps: float, modifiers: Qt.KeyboardModifier) -> bool:
        """Nearer or farther off; with Ctrl or Shift, edges of the curve at the pointer."""
        keys = Qt.KeyboardModifier
        shift, modifier = (
            bool(modifiers & keys.ShiftModifier),
            bool(modifiers & keys.ControlModifier),
        )
        return self.state.wheel(steps, shift=shift, modifier=modifier)


#: Buttons that stand alone are seen to be some.
RAISED = """
QToolButton:!checked {background: palette(button)}
QToolButton:!checked:!hover:!focus {border-color: palette(mid)}
"""


class RetopoWindow(ShellWindow):
    """Shows a network of curves, with the tools that change it."""

    state: RetopoState

    def make_picture(self) -> SceneView:
        """Make the widget in the middle."""
        view = RetopoView(self, self.saver.state)
        view.changed.connect(self.show_change)
        view.asked.connect(self.refresh)
        return view

    def make_docks(self) -> list[Dock]:
        """Make the docks of tools, of the tool's options, and of fills."""
        tools = Dock("Tools", self)
        tools.show_scrolled(self._make_tools())
        fills = Dock("Fills of the patch", self)
        self.fills = ThumbnailList(self._take, 84, empty="point at a patch: its fills appear here")
        fills.setWidget(self.fills)
        self._patch: int | None = None
        self._choices: tuple[Choice, ...] = ()
        return [fills, tools]

    def arrange_docks(self) -> None:
        """Tools stand at the left; facts and fills at the right."""
        super().arrange_docks()
        self.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, self.docks[2])

    def _make_tools(self) -> QWidget:
        whole = QWidget()
        layout = QVBoxLayout(whole)
        whole.setStyleSheet(TOOL_BUTTONS + RAISED)
        grid = QGridLayout()
        grid.setSpacing(2)
        for number, mode in enumerate(self.state.tool.modes):
            button = QToolButton()
            button.setDefaultAction(self.table.bound[f"tool-{mode.tool}"].action)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            grid.addWidget(button, number // COLUMNS, number % COLUMNS)
            self._last_button = button
        layout.addLayout(grid)
        self.brush = QLabel()
        self.brush.setToolTip("[ and ] make it smaller and larger")
        layout.addWidget(self.brush)
        self._options = QWidget()
        self._form = QFormLayout(self._options)
        self._form.setContentsMargins(0, 0, 0, 0)
        self._rows: list[tuple[ToolMode, ToolOption, QComboBox | QLineEdit]] = []
        self._mode: ToolMode | None = None
        layout.addWidget(self._options)
        layout.addStretch(1)
        return whole

    def refresh_docks(self) -> None:
        """Show the tool's options and the fills of the patch that was pointed at last."""
        self._refresh_options()
        self._refresh_fills()

    def _refresh_options(self) -> None:
        state, mode = self.state, self.state.tool.mode
        if mode is not self._mode:
            self._mode = mode
            while self._form.rowCount():
                self._form.removeRow(0)
            self._rows = []
            self._add_rows(mode)
            # Tools that act at once are never in use: what they are told is always there.
            for other in state.tool.modes:
                if other.gesture == "act" and other.options:
                    self._form.addRow(QLabel(f"<b>{other.title}</b>"))
                    self._add_rows(other)
            self._order_rows()
        for own, option, row in self._rows:
            value = state.tool.option(own, option)
            if isinstance(row, QComboBox):
                row.setCurrentIndex(option.values.index(value))
            elif not row.hasFocus():
                row.setText(option.spell(value))
        name = "target edge" if mode.brush == "edge" else "radius of snapping"
        name = "brush" if mode.given_as else name
        value = state.sizes.edge if mode.brush == "edge" else state.tool.brush
        share = 100.0 * value / state.surface.diagonal
        self.brush.setText(f"{name}: {share:.1f} %   [ ]" if mode.brush else "no brush")

    def _add_rows(self, mode: ToolMode) -> None:
        """Make a row for every option of a tool."""
        for option in mode.options:
            if option.typed is not None:
                row = QLineEdit()
                row.setPlaceholderText(
                    "by itself" if option.values[0] is None else str(option.values[0])
                )
                row.editingFinished.connect(partial(self._type_option, len(self._rows)))
            else:
                row = QComboBox()
                for value in option.values:
                    said = {None: "by itself", True: "yes", False: "no"}
                    text = said[value] if value is None or isinstance(value, bool) else str(value)
                    row.addItem(text, value)
                row.activated.connect(partial(self._choose_option, len(self._rows)))
            row.setToolTip(option.help)
            row.setAccessibleName(f"{mode.title}: {option.name}")
            self._rows.append((mode, option, row))
            self._form.addRow(option.name, row)

    def _order_rows(self) -> None:
        """Put the rows behind the last tool's button in the order of Tab."""
        # Qt puts new widgets at the end of the window's order, behind those of other docks.
        before: QWidget = self._last_button
        for _, _, row in self._rows:
            QWidget.setTabOrder(before, row)
            before = row

    @property
    def _combos(self) -> list[QComboBox]:
        return [row for _, _, row in self._rows if isinstance(row, QComboBox)]

    def _choose_option(self, number: int, value: int) -> None:
        mode, option, _ = self._rows[number]
        self.state.turn_option(option, option.values[value], mode)
        self.show_change()

    def _type_option(self, number: int) -> None:
        mode, option, row = self._rows[number]
        assert isinstance(row, QLineEdit)
        try:
            self.state.turn_option(option, option.read(row.text()), mode)
        except InvalidRetopoError as error:
            self.state.message = str(error)
        self.show_change()

    def _refresh_fills(self) -> None:
        state = self.state
        under = state.tool.patch_under()
        if under is not None:
            self._patch = under
        if self._patch is not None and self._patch not in state.network.patches:
            self._patch = None
        if self._patch is not None and not state.editing.waiting:
            state.editing.want_list(self._patch)
        found = () if self._patch is None else state.editing.list_choices(self._patch)
        self._choices = found[:SHOWN]
        wanted = [
            Thumbnail(
                PictureKey(choice),
                f"{number + 1}: {len(choice.faces)}q",
                partial(paint_choice, choice),
                f"{format_count(len(choice.faces), 'quad')}, {choice.n_irregular} irregular; "
                "click to take it",
            )
            for number, choice in enumerate(self._choices)
        ]
        place = None if self._patch is None else state.editing.place_in_list(self._patch)
        number = None if place is None else place.number
        chosen = number if number is not None and number < len(wanted) else None
        self.fills.show_thumbnails(wanted, chosen)

    def _take(self, number: int) -> None:
        if self._patch is not None:
            self.state.message = ""
            self.state.editing.choose_fill(self._patch, number)
            self.show_change()
