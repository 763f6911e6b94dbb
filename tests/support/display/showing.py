"""A program that shows windows on a real display, and tells what became of them: JSON by lines.

``showing.py FOLDER`` reads {"open": name, "folder": for its files}, {"tell": expression} and
{"end": true}, and answers {"told": value}. The expression is of Python, with ``window`` and
``state`` of the window that was opened last, and ``app``. ``showing.py FOLDER NAME`` shows one
window as the command line does, and ends with its code; ``showing.py FOLDER NAME kept`` as the
library's ``show`` does, which keeps what is not saved in case of a crash, and answers, too.
Settings go into the folder.
"""

from __future__ import annotations

import json
import sys
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from queue import Empty, Queue
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from PySide6 import QtGui, QtWidgets
from PySide6.QtCore import QTimer

from patterndb.errors import PatternDBError
from tests.support.display.six_windows import KEEPERS, MAKERS, OPENING
from viewer.shell.application import run_application, start_application, telling_errors
from viewer.shell.settings import ShellSettings
from viewer.shell.window import ShellWindow

#: Milliseconds between two looks at what is asked.
PATIENCE = 5


class Showing:
    """Windows, opened one after another, and what is asked about them."""

    def __init__(self, folder: Path) -> None:
        self.settings = ShellSettings(folder / "windows.ini")
        self.app = start_application(self.settings)
        self.app.setQuitOnLastWindowClosed(False)
        # Names of Qt's that are asked about.
        self.known: dict[str, Any] = vars(QtGui) | vars(QtWidgets) | {"app": self.app}
        self.asked: Queue[dict[str, Any] | None] = Queue()

    def listen(self, run: Callable[[], object]) -> None:
        """Obey what is asked on stdin while something runs that has a loop of events."""

        def read() -> None:
            for line in sys.stdin:
                self.asked.put(json.loads(line))
            self.asked.put(None)

        threading.Thread(target=read, daemon=True).start()
        # Also while a question is asked: its loop of events has this clock, too.
        clock = QTimer()
        clock.timeout.connect(self._obey)
        clock.start(PATIENCE)
        with telling_errors(self):
            run()

    def quit_now(self) -> None:
        """End it all."""
        self.app.quit()

    def tell_error(self, error: BaseException) -> None:
        """Tell of an error in the window that is open, as the windows of the program do."""
        if "window" in self.known:
            self.known["window"].tell_error(error)

    def _obey(self) -> None:
        if "window" not in self.known:
            for window in self.app.topLevelWidgets():
                if isinstance(window, ShellWindow):
                    self.known.update(window=window, state=window.state)
        try:
            message = self.asked.get_nowait()
        except Empty:
            return
        if message is None or "end" in message:
            self.quit_now()
        told: object = None
        if message is not None and "open" in message:
            self._open(message["open"], Path(message["folder"]))
        elif message is not None and "tell" in message:
            try:
                told = eval(message["tell"], self.known)
            except Exception as error:
                told = f"{type(error).__name__}: {error}"
        print(json.dumps({"told": told}), flush=True)

    def _open_file(self, name: str, path: Path) -> Any:
        """Open a file, whatever is in it, unless its name begins with "bad"."""
        if path.name.startswith("bad"):
            raise PatternDBError(f"{path.name} is no such file")
        window = MAKERS[name](self.settings, path.parent)
        # Its clock would take what is new in the state from the window that is shown.
        window.deleteLater()
        return window.saver

    def _open(self, name: str, folder: Path) -> None:
        more = {"opener": partial(self._open_file, name)} if name in OPENING else {}
        window = MAKERS[name](self.settings, folder, **more)
        window.resize(900, 600)
        window.show()
        window.picture.setFocus()
        state = window.saver.state
        moves: list[tuple[float, float]] = []
        self.known.update(window=window, state=state, moves=moves)
        if not hasattr(state, "move"):
            return
        move = state.move

        def watched(x: float, y: float) -> bool:
            moves.append((x, y))
            return bool(move(x, y))

        state.move = watched


def show_one(folder: Path, name: str) -> None:
    """Show one window until it is closed, or interrupted."""
    settings = ShellSettings(folder / "windows.ini")
    app = start_application(settings)
    window = MAKERS[name](settings, folder)
    window.show()
    QTimer.singleShot(0, lambda: print("shown", flush=True))
    try:
        run_application(app, window)
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    if len(sys.argv) > 3:
        showing = Showing(Path(sys.argv[1]))
        showing.listen(partial(KEEPERS[sys.argv[2]], Path(sys.argv[1])))
    elif len(sys.argv) > 2:
        show_one(Path(sys.argv[1]), sys.argv[2])
    else:
        showing = Showing(Path(sys.argv[1]))
        showing.listen(showing.app.exec)
