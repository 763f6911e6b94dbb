"""The window of the viewer of surfaces: the shell of all windows, with alpha and the method."""

from __future__ import annotations

from PySide6.QtWidgets import QComboBox, QLabel, QVBoxLayout, QWidget

from viewer.shell.docks import Dock, SliderPanel, SliderRow
from viewer.shell.window import ShellWindow
from viewer.surfacing.state import ALPHA, SurfacingState


class SurfacingWindow(ShellWindow):
    """Shows a surface, with what it is made by."""

    state: SurfacingState

    def make_docks(self) -> list[Dock]:
        """Make the dock of alpha and the method."""
        dock = Dock("Settings", self)
        whole = QWidget()
        layout = QVBoxLayout(whole)
        row = SliderRow(
            ALPHA,
            lambda: self.state.surfaces.settings.alpha,
            self._change_alpha,
            tip="The price of chords: left of it more of them, right of it fewer",
        )
        self.sliders = SliderPanel([row], self.show_change)
        self.method = QComboBox()
        self.method.addItems(self.state.surfaces.list_methods())
        self.method.setToolTip("How patches become surfaces")
        self.method.textActivated.connect(self._choose_method)
        layout.addWidget(self.sliders)
        layout.addWidget(QLabel("method of all patches"))
        layout.addWidget(self.method)
        layout.addStretch(1)
        dock.show_scrolled(whole)
        return [dock]

    def refresh_docks(self) -> None:
        """Show alpha and the method as they are now."""
        self.sliders.refresh()
        self.method.setCurrentText(self.state.surfaces.edits.method)

    def _change_alpha(self, alpha: float) -> None:
        self.state.surfaces.change_alpha(alpha)

    def _choose_method(self, name: str) -> None:
        self.state.message = ""
        self.state.surfaces.choose_method(name)
        self.show_change()
