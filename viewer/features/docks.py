"""The window of the viewer of feature curves: the shell of all windows, with curves and sliders."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QListWidget,
    QListWidgetItem,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from patterndb_sketch.features.edits import DrawnCurve
from viewer import style
from viewer.card import format_count
from viewer.commands import Command
from viewer.features.sliders import AXIS_OF, DEGREES, SLIDERS, get_slider_value, name_axis
from viewer.features.state import FeatureState
from viewer.shell.docks import Dock, SliderPanel, SliderRow, make_form
from viewer.shell.window import ShellWindow
from viewer.style import choose_curve_colour

#: What the sliders do.
TIPS = {
    "alpha": "What is followed: the angle of normals to the axis, or bends of the surface",
    "stiffness": "How closely the curve follows: all of it, or straight on",
    "angle": "The angle of normals to the axis that is followed where alpha is below 1",
}


def paint_swatch(colour: str) -> QIcon:
    """Paint a curve's colour on paper, so that it is seen in a row that is selected, too."""
    swatch = QPixmap(16, 8)
    swatch.fill(QColor(style.PAPER))
    painter = QPainter(swatch)
    painter.fillRect(1, 2, 14, 4, QColor(colour))
    painter.end()
    icon = QIcon(swatch)
    icon.addPixmap(swatch, QIcon.Mode.Selected)
    return icon


class FeatureWindow(ShellWindow):
    """Shows curves on a model, with their names and what they follow."""

    state: FeatureState

    def make_docks(self) -> list[Dock]:
        """Make the docks of curves and of sliders."""
        curves = Dock("Curves", self)
        self.curves = QListWidget()
        self.curves.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        self.curves.setToolTip("Click to select, double click to name")
        self.curves.currentRowChanged.connect(self._select)
        self.curves.itemChanged.connect(self._rename)
        curves.setWidget(self.curves)
        fit = Dock("Fit", self)
        rows = [self._slider_row(name) for name in SLIDERS]
        self.sliders = SliderPanel(rows, self.show_change)
        self.axis, self.degree = QComboBox(), QSpinBox()
        self.axis.addItems(list(AXIS_OF))
        self.axis.setPlaceholderText("another direction")
        self.axis.setToolTip("The axis that the isophote angle is measured from")
        self.axis.textActivated.connect(
            lambda name: self.change(lambda: self.state.editing.choose_axis(AXIS_OF[name]))
        )
        self.degree.setRange(*DEGREES)
        self.degree.setToolTip("The degree of the spline")
        self.degree.setKeyboardTracking(False)
        self.degree.valueChanged.connect(
            lambda degree: self.change(lambda: self.state.editing.choose_degree(degree))
        )
        whole = QWidget()
        layout = QVBoxLayout(whole)
        layout.addWidget(self.sliders)
        layout.addWidget(make_form([("axis", self.axis), ("degree", self.degree)]))
        layout.addStretch(1)
        fit.show_scrolled(whole)
        return [curves, fit]

    def _slider_row(self, name: str) -> SliderRow:
        # Of whatever state is shown then: another model may be opened.
        return SliderRow(
            SLIDERS[name],
            lambda: get_slider_value(self.state.editing.shown_settings, name),
            lambda value: self.state.slide_to(name, value),
            lambda: self.state.begin_sliding(),  # noqa: PLW0108
            lambda: self.state.end_sliding(),  # noqa: PLW0108
            lambda: name != "angle" or self.state.editing.shown_settings.alpha < 1.0,
            TIPS[name],
        )

    def run_command(self, command: Command[Any]) -> None:
        """Obey a command; a curve is named in the list."""
        if command.name != "name-curve":
            super().run_command(command)
            return
        item = self.curves.currentItem()
        if item is None:
            self.state.message = "select a curve first: click on it"
            self.show_change()
            return
        dock = self.docks[1]
        dock.show()
        dock.raise_()
        # All of the name is selected then: what is typed replaces it.
        self.curves.setFocus()
        self.curves.editItem(item)

    def refresh_docks(self) -> None:
        """Show the curves and the sliders as they are now."""
        if self.curves.state() != QAbstractItemView.State.EditingState:
            self._refresh_curves()
        self.sliders.refresh()
        settings = self.state.editing.shown_settings
        self.axis.setCurrentText(name_axis(settings) or "")
        if name_axis(settings) is None:
            self.axis.setCurrentIndex(-1)
        self.degree.setValue(settings.degree)

    def _refresh_curves(self) -> None:
        edits, chosen = self.state.editing.edits, self.state.row_of_selected()
        while self.curves.count() > len(edits.curves):
            self.curves.takeItem(self.curves.count() - 1)
        for row, curve in enumerate(edits.curves):
            item = self.curves.item(row)
            if item is None:
                item = QListWidgetItem()
                item.setFlags(item.flags() | Qt.ItemFlag.ItemIsEditable)
                self.curves.addItem(item)
            if item.text() != curve.name:
                item.setText(curve.name)
            if item.data(Qt.ItemDataRole.UserRole) != curve.key:
                item.setData(Qt.ItemDataRole.UserRole, curve.key)
                item.setIcon(paint_swatch(choose_curve_colour(curve.key)))
            item.setToolTip(self._tell_curve(curve))
        self.curves.setCurrentRow(-1 if chosen is None else chosen)

    def _tell_curve(self, curve: DrawnCurve) -> str:
        trouble = self.state.editing.trouble(curve)
        pins = format_count(len(curve.constraints), "pin") if curve.constraints else "no pin"
        return trouble or f"{curve.name}: {pins}; double click to name it"

    def _select(self, row: int) -> None:
        curves = self.state.editing.edits.curves
        if not self._refreshing and 0 <= row < len(curves):
            self.state.editing.select(curves[row].key)
            self.show_change()

    def _rename(self, item: QListWidgetItem) -> None:
        key, name = item.data(Qt.ItemDataRole.UserRole), item.text().strip()
        self.change(lambda: (self.state.editing.select(key), self.state.editing.rename(name)))
