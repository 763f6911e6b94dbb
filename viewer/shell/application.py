"""The one QApplication, set up so that windows draw fast, tell of every event, and heed Ctrl-C."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Protocol

# Must be said before pyvistaqt is imported: it asks QtPy, which takes the first that it finds.
os.environ["QT_API"] = "pyside6"

import PySide6
from PySide6.QtCore import QCoreApplication, Qt, QTimer
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QApplication

from viewer.shell.settings import ShellSettings

#: Milliseconds between two moments in which Python may look at signals: Qt's loop runs in C++.
SIGNALS = 100

#: References that will not be used up: at a million a second they last for days.
SPARE_REFERENCES = 2**40

Role = QPalette.ColorRole

#: Colours of dark windows where the system has none, and of what cannot be done in them.
DARK = {
    Role.Window: "#2e3136",
    Role.WindowText: "#e6e8eb",
    Role.Base: "#1f2226",
    Role.AlternateBase: "#282b30",
    Role.ToolTipBase: "#3a3e45",
    Role.ToolTipText: "#e6e8eb",
    Role.PlaceholderText: "#8b919a",
    Role.Text: "#e6e8eb",
    Role.Button: "#50555e",
    Role.ButtonText: "#e6e8eb",
    Role.BrightText: "#ffffff",
    Role.Link: "#7db7f0",
    Role.Highlight: "#2f6ea8",
    Role.HighlightedText: "#ffffff",
    Role.Light: "#666c76",
    Role.Midlight: "#5a606a",
    Role.Mid: "#25282c",
    Role.Dark: "#1a1c1f",
    Role.Shadow: "#101113",
}
DARK_DISABLED = "#7a8089"

#: The inside of a box that can be checked, in a dark window.
DARK_BOX = "#5d646f"

SCHEMES = {
    "system": Qt.ColorScheme.Unknown,
    "light": Qt.ColorScheme.Light,
    "dark": Qt.ColorScheme.Dark,
}


def start_application(settings: ShellSettings) -> QApplication:
    """Return the application, made and set up if there is none yet."""
    there = QApplication.instance()
    if isinstance(there, QApplication):
        app = there
    else:
        protect_constants()
        app = QApplication(sys.argv[:1])
        app.setApplicationName("patterndb")
        app.setStyle("fusion")
    # After the application is made: before, the attribute reads True again, and of forty moves
    # in half a second five arrive.
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_CompressHighFrequencyEvents, False)
    use_theme(app, settings.theme)
    return app


def protect_constants() -> None:
    """Keep Python alive under PySide6 6.12.0.

    It takes a reference from None, True or False with every call that returns one: before Python
    3.12, where they cannot be freed, some ten thousand calls end the process ("none_dealloc").
    pyproject.toml refuses that release, but it may be there.
    """
    if sys.version_info < (3, 12) and PySide6.__version__ == "6.12.0":
        for constant in (None, True, False):
            ctypes.c_ssize_t.from_address(id(constant)).value += SPARE_REFERENCES


def use_theme(app: QApplication, theme: str) -> None:
    """Have all windows light or dark, or as the system is."""
    app.styleHints().setColorScheme(SCHEMES[theme])
    if theme == "system":
        app.setPalette(QPalette())
    elif is_dark(app) is not (theme == "dark"):
        # A bare X11 knows no schemes: the wish comes to nothing there.
        app.setPalette(make_dark_palette() if theme == "dark" else app.style().standardPalette())
    boxes = QPalette()
    if is_dark(app):
        # The style draws the rim of a box darker than the window: an empty one would not be seen.
        boxes.setColor(Role.Base, QColor(DARK_BOX))
    # PySide takes text, whatever its stubs say.
    app.setPalette(boxes, "QCheckBox")  # pyright: ignore[reportArgumentType]


def make_dark_palette() -> QPalette:
    """Make the colours of dark windows."""
    palette = QPalette()
    for role, colour in DARK.items():
        palette.setColor(role, QColor(colour))
    for role in (Role.WindowText, Role.Text, Role.ButtonText, Role.HighlightedText):
        palette.setColor(QPalette.ColorGroup.Disabled, role, QColor(DARK_DISABLED))
    return palette


def is_dark(app: QApplication) -> bool:
    """Are the windows dark just now?"""
    return app.palette().window().color().lightness() < 128


def run_application(app: QApplication, window: ErrorTeller) -> None:
    """Run until the window is closed; Ctrl-C in the terminal closes it without asking.

    An error in an event's handler is told in the window, which stays: there may be work in it.
    Raises KeyboardInterrupt after Ctrl-C.
    """
    with _heeding_interrupts(window) as seen, telling_errors(window):
        app.exec()
    if seen:
        raise KeyboardInterrupt


class ErrorTeller(Protocol):
    """A window that can be closed, and told of errors."""

    def quit_now(self) -> None: ...
    def tell_error(self, error: BaseException) -> None: ...


@contextmanager
def _heeding_interrupts(window: ErrorTeller) -> Generator[list[int]]:
    """Have Ctrl-C close the window."""
    seen: list[int] = []

    def interrupt(number: int, _frame: Any) -> None:
        seen.append(number)
        # Not now: this may be in the middle of a picture, and OpenGL would abort the process.
        QTimer.singleShot(0, window.quit_now)

    before = signal.signal(signal.SIGINT, interrupt)
    clock = QTimer()
    clock.timeout.connect(lambda: None)
    clock.start(SIGNALS)
    try:
        yield seen
    finally:
        clock.stop()
        signal.signal(signal.SIGINT, before)


@contextmanager
def telling_errors(window: ErrorTeller) -> Generator[None]:
    """Have the window tell of an error that an event's handler raises; it is printed, too."""
    before = sys.excepthook

    def tell(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        before(kind, error, trace)
        window.tell_error(error)

    sys.excepthook = tell
    try:
        yield
    finally:
        sys.excepthook = before
