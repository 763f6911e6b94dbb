"""A display of its own with a window manager, and hands on the windows that another process shows
there: pointer and keys by XTest, as a person's."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import numpy as np
import pytest

#: Seconds that anything may take on a slow and busy machine; nothing waits so long but to fail.
PATIENCE = 60.0

SCREEN = (1100, 760)

PROGRAM = Path(__file__).with_name("showing.py")
ROOT = Path(__file__).resolve().parents[3]


def end(process: subprocess.Popen[Any]) -> None:
    """End a process, whatever it is doing."""
    process.terminate()
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@contextmanager
def open_display(folder: Path) -> Iterator[dict[str, str]]:
    """Open a screen with a window manager, under a number that nobody has; gives the environment
    of programs on it. folder: for what they keep of a user."""
    read, write = os.pipe()
    screen = f"{SCREEN[0]}x{SCREEN[1]}x24"
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", screen, "-nolisten", "tcp"],
        pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(write)
    manager: subprocess.Popen[Any] | None = None
    try:
        number = read_within(read)
        if not number:
            pytest.skip("Xvfb does not start here")
        environment = {
            name: value
            for name, value in os.environ.items()
            if name not in ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY", "QT_SCALE_FACTOR")
        } | {
            "DISPLAY": f":{number}",
            "XDG_CONFIG_HOME": str(folder),
            "XDG_RUNTIME_DIR": str(folder),
            "PYTHONPATH": str(ROOT),
            # The same windows on every machine.
            "LC_ALL": "C.UTF-8",
        }
        manager = subprocess.Popen(
            ["openbox"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        yield environment
    finally:
        if manager is not None:
            end(manager)
        end(server)


def read_within(pipe: int) -> str:
    """Read a line from a pipe; "" if none comes in time, or it is closed."""
    found: Queue[str] = Queue()

    def read() -> None:
        with os.fdopen(pipe) as file:
            found.put(file.readline().strip())

    threading.Thread(target=read, daemon=True).start()
    try:
        return found.get(timeout=PATIENCE)
    except Empty:
        return ""


class Shown:
    """Windows in another process, and a hand on them.

    Places are points from the middle of the window's picture, y upward.
    """

    def __init__(self, environment: dict[str, str], folder: Path, *words: str) -> None:
        """words: what the program is told after its folder."""
        #: Where windows that are opened save what they have.
        self.folder = folder
        self.environment = environment
        self._errors = folder / "stderr"
        with self._errors.open("w") as errors:
            self.process = subprocess.Popen(
                [sys.executable, str(PROGRAM), str(folder), *words], env=environment, text=True,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors,
            )  # fmt: skip
        self._answers: Queue[str] = Queue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._answers.put(line)
        self._answers.put("")

    def ask(self, **message: object) -> Any:
        """Ask the process for something, and return what it tells."""
        assert self.process.stdin is not None
        try:
            print(json.dumps(message), file=self.process.stdin, flush=True)
            line = self._answers.get(timeout=PATIENCE)
        except (Empty, BrokenPipeError) as error:
            self.process.kill()
            pytest.fail(f"no answer to {message} ({error!r}): {self.said()}")
        if not line:
            pytest.fail(f"the process ended at {message}: {self.said()}")
        return json.loads(line)["told"]

    def said(self) -> str:
        """What it wrote on stderr."""
        return self._errors.read_text()

    def tell(self, expression: str) -> Any:
        """Return what an expression is there."""
        told = self.ask(tell=expression)
        assert not (isinstance(told, str) and "Error: " in told), f"{expression}: {told}"
        return told

    def until(self, expression: str) -> Any:
        """Wait until an expression holds, and return it."""
        limit = time.monotonic() + PATIENCE
        while not (told := self.tell(expression)):
            if time.monotonic() > limit:
                pytest.fail(f"{expression} is {told!r}; {self.tell('state.message')!r}")
            time.sleep(0.03)
        return told

    def open(self, name: str) -> None:
        """Open a window, and wait until it has the focus."""
        self.ask(open=name, folder=str(self.folder))
        self.until("window.isActiveWindow() and window.picture.width() > 100")

    def check_quiet(self) -> None:
        """All windows are closed, and nobody told of an error."""
        self.until("not any(w.isVisible() for w in app.topLevelWidgets())")
        assert "Traceback" not in self.said(), self.said()

    def finish(self) -> None:
        """End the process, which must end well."""
        self.ask(end=True)
        code = self.process.wait(PATIENCE)
        assert code == 0, f"it ended with {code}: {self.said()}"
        assert "Traceback" not in self.said(), self.said()

    # The hand

    def do(self, *arguments: object) -> None:
        """Have xdotool do something."""
        subprocess.run(
            ["xdotool", *map(str, arguments)], env=self.environment, check=True, timeout=PATIENCE
        )
        # All of it shall arrive: what is asked below comes after events of the display.
        time.sleep(0.05)
        self.tell("0")

    def keys(self, *keys: str) -> None:
        """Press keys, one after another."""
        for key in keys:
            self.do("key", "--clearmodifiers", key)

    def find_middle(self) -> tuple[float, float]:
        """Find the middle of the picture on the screen."""
        left, top, width, height = self.tell(
            "(lambda p, v: (p.x(), p.y(), v.width(), v.height()))"
            "(window.picture.mapToGlobal(window.picture.rect().topLeft()), window.picture)"
        )
        return left + width / 2.0, top + height / 2.0

    def find_pixels(self, places: np.ndarray) -> np.ndarray:
        """Find the pixels (n, 2) of the screen at places (n, 2)."""
        return np.round(np.array(self.find_middle()) + places * (1.0, -1.0)).astype(int)

    def drag(self, places: np.ndarray, seconds: float = 0.2, *, button: int = 1) -> np.ndarray:
        """Press at the first place, go through the others, and let go at the last.

        Returns where the pointer was in fact: places (n, 2) of whole pixels.
        """
        pixels = self.find_pixels(places)
        words: list[object] = ["mousemove", *pixels[0], "mousedown", button]
        for pixel in pixels[1:]:
            words += ["mousemove", *pixel, "sleep", seconds / len(pixels)]
        self.do(*words, "mouseup", button)
        return (pixels - np.array(self.find_middle())) * (1.0, -1.0)

    def click(self, place: np.ndarray) -> None:
        """Click at a place."""
        self.do("mousemove", *self.find_pixels(place[None])[0], "click", 1)

    def close_by_manager(self) -> None:
        """Close the active window as its close button does."""
        self.do("key", "--clearmodifiers", "alt+F4")

    def press_button(self, text: str) -> None:
        """Click a button of the question that is asked."""
        self.until("isinstance(app.activeModalWidget(), QMessageBox)")
        self.until("app.activeModalWidget().isActiveWindow()")
        place = self.until(
            "next(((lambda p: (p.x(), p.y()))(b.mapToGlobal(b.rect().center()))"
            " for b in app.activeModalWidget().buttons()"
            f" if b.text().replace('&', '') == {text!r}), None)"
        )
        self.do("mousemove", *place, "click", 1)
        self.until("not isinstance(app.activeModalWidget(), QMessageBox)")

    def name_file(self, path: Path, *, asked: bool = False) -> None:
        """Type a path into the dialog that asks for a file; asked: a question comes after it."""
        self.until("isinstance(app.activeModalWidget(), QFileDialog)")
        self.until("app.activeModalWidget().isActiveWindow()")
        self.keys("ctrl+a")
        self.do("type", path)
        self.keys("Return")
        after = "isinstance(app.activeModalWidget(), QMessageBox)" if asked else "False"
        self.until(f"app.activeModalWidget() is None or {after}")
