"""A hand on a window without a screen: mouse and keys as Qt tells of them; and pictures."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

# Before Qt is imported: no test of this process may open a window on somebody's screen.
os.environ["QT_QPA_PLATFORM"] = "offscreen"

from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QKeySequence, QMouseEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

from viewer.commands import spell_key
from viewer.saver import Saver
from viewer.shell.application import start_application
from viewer.shell.settings import ShellSettings
from viewer.shell.window import ShellWindow

Place = tuple[float, float]

BUTTONS = {
    "Left": Qt.MouseButton.LeftButton,
    "Middle": Qt.MouseButton.MiddleButton,
    "Right": Qt.MouseButton.RightButton,
}


class Events:
    """Opens a window on what a saver draws, and sends it events; close it at the end.

    folder: for settings. settle: waits for what the window has asked for. Places are points from
    the middle of the picture.
    """

    def __init__(
        self,
        saver: Saver,
        folder: Path,
        kind: type[ShellWindow] = ShellWindow,
        settle: Callable[[], object] = lambda: None,
        opener: Any = None,
    ) -> None:
        settings = ShellSettings(folder / "windows.ini")
        self.app = start_application(settings)
        self.window: Any = kind(saver, "test", settings, opener)
        self.window.resize(1000, 700)
        self.window.show()
        self.window.activateWindow()
        self.window.picture.setFocus()
        self._settle = settle
        self.work()

    def close(self) -> None:
        """Close the window without asking."""
        self.window.quit_now()
        self.app.processEvents()

    def work(self) -> None:
        """Wait for what was asked for, and show it."""
        self.app.processEvents()
        self._settle()
        self.window._poll()
        self.window.refresh()
        self.app.processEvents()

    def _send(self, kind: QEvent.Type, at: Place, button: Any, down: Any, held: Any) -> None:
        view = self.window.picture
        width, height = view.room
        place = QPointF(at[0] + width / 2.0, height / 2.0 - at[1])
        event = QMouseEvent(kind, place, view.mapToGlobal(place), button, down, held)
        QApplication.sendEvent(view, event)

    def move(self, at: Place, held: Any = Qt.KeyboardModifier.NoModifier) -> None:
        """Move the pointer to a place."""
        none = Qt.MouseButton.NoButton
        self._send(QEvent.Type.MouseMove, at, none, none, held)
        self.work()

    def drag(
        self, *places: Place, button: str = "Left", held: Any = Qt.KeyboardModifier.NoModifier
    ) -> None:
        """Move to the first place, press, move through the others, and let go at the last."""
        one, none = BUTTONS[button], Qt.MouseButton.NoButton
        self.move(places[0])
        self._send(QEvent.Type.MouseButtonPress, places[0], one, one, held)
        for place in places[1:]:
            self._send(QEvent.Type.MouseMove, place, none, one, held)
        self._send(QEvent.Type.MouseButtonRelease, places[-1], one, none, held)
        self.work()

    def press(self, at: Place, button: str = "Left") -> None:
        """Press a button, and hold it."""
        one = BUTTONS[button]
        self._send(QEvent.Type.MouseButtonPress, at, one, one, Qt.KeyboardModifier.NoModifier)

    def wheel(self, at: Place, steps: int = 1, held: Any = Qt.KeyboardModifier.NoModifier) -> None:
        """Turn the wheel with the pointer at a place."""
        view = self.window.picture
        width, height = view.room
        place = QPointF(at[0] + width / 2.0, height / 2.0 - at[1])
        event = QWheelEvent(
            place, view.mapToGlobal(place), QPoint(), QPoint(0, 120 * steps),
            Qt.MouseButton.NoButton, held, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(view, event)
        self.work()

    def keys(self, *keys: str) -> None:
        """Press keys by their names in commands, with the picture in focus."""
        for key in keys:
            self.window.picture.setFocus()
            QTest.keySequence(self.window.picture, QKeySequence(spell_key(key)))
            self.work()

    def do(self, *names: str) -> None:
        """Obey commands by their names, as if chosen in a menu; each must be one that can be."""
        for name in names:
            action = self.window.table.bound[name].action
            assert action.isEnabled(), f"{name} cannot be done now"
            action.trigger()
            self.work()


def answer(monkeypatch: Any, button: QMessageBox.StandardButton) -> list[str]:
    """Answer every question with a button; returns the texts of the questions, as they come."""
    asked: list[str] = []

    def question(_parent: object, _title: str, text: str, *_: object) -> object:
        asked.append(text)
        return button

    monkeypatch.setattr(QMessageBox, "question", question)
    return asked


def check_looking(events: Events, seer: Any) -> None:
    """A drag with the right or the middle button turns the view, the wheel zooms, the middle one
    with Shift shifts; seer: the camera."""
    for button in ("Right", "Middle"):
        axes = seer.view.axes
        events.drag((0.0, 0.0), (40.0, 30.0), button=button)
        assert not np.allclose(seer.view.axes, axes)
    scale, focus = seer.view.scale, seer.view.focus
    events.wheel((0.0, 0.0))
    assert seer.view.scale > scale
    axes = seer.view.axes
    shift = Qt.KeyboardModifier.ShiftModifier
    events.drag((0.0, 0.0), (20.0, 10.0), button="Middle", held=shift)
    assert np.allclose(seer.view.axes, axes)
    assert np.linalg.norm(seer.view.focus - focus) > 0.0
    events.do("frame-all")


def check_actions(events: Events) -> None:
    """Every command has a place in a menu and a tooltip; no two have one key."""
    table = events.window.table
    seen: dict[str, str] = {}
    for name, one in table.bound.items():
        assert one.action in table.menu(one.command.menu).actions()
        assert one.action.toolTip()
        for key in table.list_keys(one):
            assert seen.setdefault(key, name) == name, f"{key}: {name} and {seen[key]}"


def read(path: Path) -> np.ndarray:
    """(h, w, 3) the colours of a PNG."""
    from matplotlib.image import imread

    return np.asarray(imread(path))[..., :3]
