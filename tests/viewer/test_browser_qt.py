"""The pattern browser's window on the shell: its page, the selected pattern, and filters."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QCheckBox

from tests.support.viewer.disks import expand
from tests.support.viewer.events import Events, check_actions
from tests.viewer.test_browser import SOURCE
from viewer.browser import BrowserSaver
from viewer.browser_state import PER_PAGE, BrowserState
from viewer.browser_window import BrowserWindow
from viewer.shell.application import is_dark, start_application, use_theme
from viewer.shell.settings import ShellSettings


def test_the_window_does_what_it_is_told(tmp_path: Path) -> None:
    state = BrowserState(SOURCE, n_sides=4, expand=expand)
    saver = BrowserSaver(state, lambda p: ["cow.obj"], tmp_path, (900, 600))
    events = Events(saver, tmp_path, BrowserWindow)
    window = events.window
    try:
        check_actions(events)
        assert window.picture.list.count() == PER_PAGE
        window.picture.list.setCurrentRow(3)
        assert state.position == 3
        events.do("next-page")
        assert state.page == 1 and window.hint_label.text().startswith("page 2")
        assert state.selected is not None
        facts = window.facts.label.text()
        assert state.selected.name in facts and "cow.obj" in facts
        events.do("chord-after", "wider")
        assert max(state.widths) == 2 and "is chosen" in window.facts.label.text()
        window.irregular.setValue(0)
        events.work()
        assert state.n_irregular == 0 and all(
            state.patterns.n_irregular[row] == 0 for row in state.rows
        )
        events.do("more-sides")
        assert window.sides.currentText() == str(state.patterns.n_sides)
        assert window.close(), "there is nothing to lose"
    finally:
        events.close()


def test_an_empty_box_is_seen_in_a_dark_window(tmp_path: Path) -> None:
    app = start_application(ShellSettings(tmp_path / "windows.ini"))
    box = QCheckBox()
    try:
        for theme, dark in (("dark", True), ("light", False), ("dark", True)):
            use_theme(app, theme)
            app.processEvents()
            box.ensurePolished()
            inside, window = (
                box.palette().color(role).lightness()
                for role in (QPalette.ColorRole.Base, QPalette.ColorRole.Window)
            )
            assert is_dark(app) is dark and (inside > window + 40 if dark else inside > 240)
    finally:
        use_theme(app, "light")
