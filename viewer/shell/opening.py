"""Opens a window on what a saver draws, and waits until it is closed."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QTimer

from viewer.keymap import Effect
from viewer.saver import Saver
from viewer.shell.application import run_application, start_application
from viewer.shell.settings import ShellSettings
from viewer.shell.window import Opener, ShellWindow


def open_window(
    saver: Saver,
    pressed: Sequence[str],
    title: str,
    kind: type[ShellWindow] = ShellWindow,
    opener: Opener | None = None,
    settings: ShellSettings | None = None,
) -> Saver:
    """Press keys first, then show the saver's state in a window until it is closed.

    pressed: as :meth:`viewer.keymap.KeyMap.check` gives them; if one of them quits no window is
    opened. kind: of window. opener: as for :class:`viewer.shell.window.ShellWindow`. settings:
    the user's by default.

    Returns the saver of what was shown last, which has ended. Raises KeyboardInterrupt after
    Ctrl-C.
    """
    # Closing asks what to do with work that is not saved; Ctrl-C does not, and keeps it.
    asked = False
    try:
        if saver.play(pressed) is not Effect.QUIT:
            settings = ShellSettings() if settings is None else settings
            app = start_application(settings)
            window = kind(saver, title, settings, opener)
            window.show()
            window.picture.setFocus()
            QTimer.singleShot(0, window.offer_lost_work)
            try:
                run_application(app, window)
            finally:
                saver = window.saver
                window.deleteLater()
        asked = True
    finally:
        saver.end(discarded=asked)
    return saver
