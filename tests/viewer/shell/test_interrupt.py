"""Ctrl-C in the terminal, wherever the program is just then."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from tests.support.viewer import events  # noqa: F401  (no screen)
from viewer.shell.application import run_application, start_application
from viewer.shell.settings import ShellSettings


class Window:
    """Can be closed; what it was doing when it was."""

    def __init__(self, app: QApplication) -> None:
        self.app = app
        self.painting = False
        self.closed: list[bool] = []

    def paint(self) -> None:
        """Paint, and be interrupted meanwhile."""
        self.painting = True
        signal.raise_signal(signal.SIGINT)
        self.painting = False

    def quit_now(self) -> None:
        self.closed.append(self.painting)
        self.app.quit()

    def tell_error(self, error: BaseException) -> None:
        raise error


def test_a_window_is_not_closed_while_it_paints(tmp_path: Path) -> None:
    app = start_application(ShellSettings(tmp_path / "windows.ini"))
    window = Window(app)
    before = signal.getsignal(signal.SIGINT)
    # Whatever happens, the test ends.
    rescue = QTimer()
    rescue.setSingleShot(True)
    rescue.timeout.connect(app.quit)
    rescue.start(20_000)
    QTimer.singleShot(0, window.paint)
    with pytest.raises(KeyboardInterrupt):
        run_application(app, window)
    assert window.closed == [False]
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_before_the_window_runs_closes_it(tmp_path: Path) -> None:
    app = start_application(ShellSettings(tmp_path / "windows.ini"))
    window = Window(app)
    run = type(app).exec

    def interrupted() -> int:
        window.paint()
        return run()

    app.exec = interrupted
    try:
        with pytest.raises(KeyboardInterrupt):
            run_application(app, window)
    finally:
        del app.exec
    assert window.closed == [False]
