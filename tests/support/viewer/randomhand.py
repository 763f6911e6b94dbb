"""Do random things in a window, and check that it stays whole.

Commands of menus, keys, drags with any button, in the middle of which other things are done, the
wheel, sliders, lists and fields of docks, other sizes; all in one process, with its loop of events.
A window fails if an exception comes out of it, an invariant of what it shows does not hold, or some
steps taken back and done again do not lead to where it was.
"""

from __future__ import annotations

import os
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QKeySequence, QMouseEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractSlider,
    QApplication,
    QCheckBox,
    QComboBox,
    QDialog,
    QListWidget,
    QSpinBox,
)

from patterndb.errors import PatternDBError
from tests.support.display.six_windows import MAKERS
from viewer.shell.application import start_application
from viewer.shell.settings import ShellSettings

#: What ends a window, or the run.
LEFT_OUT = ("close",)

#: Actions between two looks at the invariants, and at some steps back and forward.
LOOKS, TURNS = 20, 200

#: Actions between two lines that say how far a run is.
TOLD = 1000

#: Steps back and forward at most.
STEPS = 6

#: Sizes that a window is given.
SIZES = ((700, 480), (900, 600), (1400, 900))

#: Corners of a boundary that is drawn first where fills are explored, in parts of the picture.
CORNERS = ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2))

#: How likely each kind of action is.
KINDS = {"command": 30, "key": 20, "drag": 30, "wheel": 5, "dock": 12, "size": 2, "wait": 1}

BUTTONS = (Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton, Qt.MouseButton.MiddleButton)
HELD = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.ShiftModifier,
)

#: Kilobytes to a page of memory.
PAGE = os.sysconf("SC_PAGE_SIZE") / 1e6


def read_memory() -> float:
    """Read the memory of this process, in megabytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE


def check_browser(state: Any) -> None:
    assert 0 <= state.position < max(1, len(state.rows))
    assert all(width >= 1 for width in state.widths)
    if state.selected is not None:
        assert len(state.selected_disk().quads) > 0


def check_explorer(state: Any) -> None:
    finder = state.finder
    assert 0 <= finder.rank < max(1, len(finder.fills))
    placed = finder.placed
    if placed is not None and finder.boundary is not None:
        assert np.isfinite(placed.placement.vertices).all()
        assert len(placed.placement.vertices) >= finder.boundary.perimeter
    if state.contour is not None:
        assert min(state.contour.lengths) >= 1


def check_retopo(state: Any) -> None:
    from patterndb_sketch.retopo.network import check_network

    check_network(state.network, patches=False)
    mesh = state.shown.body.mesh
    assert np.isfinite(mesh.vertices).all()
    assert len(mesh.quads) == 0 or mesh.quads.max() < len(mesh.vertices)


def check_surfacing(state: Any) -> None:
    made = state.surfaces.made
    if made is not None and made.surfacing is not None:
        assert np.isfinite(made.surfacing.points).all()
        assert made.surfacing.triangles.max(initial=-1) < len(made.surfacing.points)
    assert 0.0 <= state.surfaces.settings.alpha <= 1.0


def check_features(state: Any) -> None:
    curves = state.editing.edits.curves
    assert len({curve.key for curve in curves}) == len(curves)
    assert len({curve.name for curve in curves}) == len(curves)
    for curve in curves:
        look = state.editing.look(curve)
        assert look is None or np.isfinite(look.line).all()


def check_shapes(state: Any) -> None:
    assert np.isfinite(state.shaping.points).all()
    assert np.abs(state.shaping.sigmas).max() <= 3.0 + 1e-6


def digest_retopo(state: Any) -> object:
    chains = state.network.chains
    return [(n, chains[n].count, chains[n].points.tobytes()) for n in sorted(chains)]


def digest_features(state: Any) -> object:
    return [
        (curve.key, curve.name, curve.clicked.tobytes(), len(curve.constraints), curve.settings)
        for curve in state.editing.edits.curves
    ]


def digest_explorer(state: Any) -> object:
    contour = state.contour
    shown = None if contour is None else (contour.lengths, contour.corners)
    return shown, [id(stroke) for stroke in state.finder.strokes], state.finder.tolerance


def digest_shapes(state: Any) -> object:
    return state.shaping.choice.coefficients.tobytes(), sorted(state.shaping.choice.held)


#: What must hold of a state, and what of it undo and redo bring back.
CHECKS: dict[str, tuple[Callable[[Any], None], Callable[[Any], object] | None]] = {
    "browse": (check_browser, None),
    "explore": (check_explorer, digest_explorer),
    "retopo": (check_retopo, digest_retopo),
    "surface": (check_surfacing, lambda state: state.surfaces.edits),
    "features": (check_features, digest_features),
    "shape-model": (check_shapes, digest_shapes),
}


@dataclass(slots=True)
class Tried:
    """What became of a window."""

    window: str
    actions: int = 0
    failures: list[str] = field(default_factory=list)
    slowest: float = 0.0
    slowest_action: str = ""
    early: float = 0.0
    late: float = 0.0
    seconds: float = 0.0


class RandomHand:
    """Does random things in a window.

    window: that is open. folder: that all is saved into. rng: what is done goes by it; what is made
    in the background comes when it comes, so that two runs need not be the same.
    """

    def __init__(self, window: Any, folder: Path, rng: np.random.Generator) -> None:
        self.window, self.folder, self.rng = window, folder, rng
        self._held: Any = None
        self.done = ""

    @property
    def state(self) -> Any:
        """What is shown."""
        return self.window.saver.state

    def act(self) -> None:
        """Do something; ``done`` says what."""
        kinds = list(KINDS)
        odds = np.array([KINDS[kind] for kind in kinds], np.float64)
        kind = kinds[int(self.rng.choice(len(kinds), p=odds / odds.sum()))]
        getattr(self, f"_do_{kind}")()
        QApplication.processEvents()
        for dialog in QApplication.topLevelWidgets():
            if isinstance(dialog, QDialog) and dialog.isVisible():
                dialog.reject()

    def draw_boundary(self) -> None:
        """Draw a boundary: without one there are no fills to do anything with."""
        self.window.table.bound["draw-boundary"].action.trigger()
        width, height = self.window.picture.room
        for x, y in CORNERS:
            for kind in (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonRelease):
                self._send(kind, (x * width, y * height), BUTTONS[0])
        self.window.table.bound["close-boundary"].action.trigger()
        self.settle()

    def turn_back_and_forth(self) -> bool:
        """Take some steps back and do them again; True if as many could be done again."""
        undo, redo = (self.window.table.bound[name].action for name in ("undo", "redo"))
        count = 0
        while count < STEPS and undo.isEnabled():
            undo.trigger()
            self.settle()
            count += 1
        for _ in range(count):
            if not redo.isEnabled():
                return False
            redo.trigger()
            self.settle()
        return True

    def settle(self) -> None:
        """Let go of everything, and wait for what was asked for."""
        if self._held is not None:
            self._send(QEvent.Type.MouseButtonRelease, (0.0, 0.0), self._held)
            self._held = None
        settle = getattr(self.state, "settle", None)
        if settle is not None and not (
            self.window.saver.kind == "explore" and self.state.finder.boundary is None
        ):
            try:
                settle()
            except PatternDBError as error:
                # A window tells it: a question without an answer, say.
                self.state.message = str(error)
        self.window._poll()
        self.window.refresh()
        QApplication.processEvents()

    def _place(self) -> tuple[float, float]:
        width, height = self.window.picture.room
        return tuple((self.rng.normal(size=2) * (width / 6.0, height / 6.0)).tolist())

    def _do_command(self) -> None:
        bound = self.window.table.bound
        names = [n for n in bound if n not in LEFT_OUT and bound[n].action.isEnabled()]
        name = names[int(self.rng.integers(len(names)))]
        self.done = f"command {name}"
        bound[name].action.trigger()

    def _do_key(self) -> None:
        bound = self.window.table.bound
        keys = [
            key for name, one in bound.items() if name not in LEFT_OUT
            for key in self.window.table.list_keys(one)
        ]  # fmt: skip
        key = keys[int(self.rng.integers(len(keys)))]
        self.done = f"key {key}"
        self.window.picture.setFocus()
        QTest.keySequence(self.window.picture, QKeySequence(key))

    def _do_drag(self) -> None:
        button = BUTTONS[int(self.rng.choice(3, p=(0.8, 0.1, 0.1)))]
        held = HELD[int(self.rng.choice(3, p=(0.8, 0.1, 0.1)))]
        at = self._place()
        steps = int(self.rng.integers(0, 12))
        self.done = f"drag of {steps} with {button.name}, {held.name}"
        self._send(QEvent.Type.MouseMove, at, None, held)
        self._send(QEvent.Type.MouseButtonPress, at, button, held)
        self._held = button
        for _ in range(steps):
            at = (at[0] + self.rng.normal() * 25.0, at[1] + self.rng.normal() * 25.0)
            self._send(QEvent.Type.MouseMove, at, button, held)
            if self.rng.random() < 0.03:
                done = self.done
                (self._do_command if self.rng.random() < 0.5 else self._do_key)()
                self.done = f"{self.done} within {done}"
            if self.rng.random() < 0.1:
                QApplication.processEvents()
        self._send(QEvent.Type.MouseButtonRelease, at, button, held)
        self._held = None

    def _send(self, kind: Any, at: Any, button: Any, held: Any = HELD[0]) -> None:
        view = self.window.picture
        if not hasattr(view, "place_of"):
            # Small pictures take no drags.
            return
        width, height = view.room
        place = QPointF(at[0] + width / 2.0, height / 2.0 - at[1])
        none = Qt.MouseButton.NoButton
        button = none if button is None else button
        pressed = none if kind == QEvent.Type.MouseButtonRelease else button
        which = none if kind == QEvent.Type.MouseMove else button
        event = QMouseEvent(kind, place, view.mapToGlobal(place), which, pressed, held)
        QApplication.sendEvent(view, event)

    def _do_wheel(self) -> None:
        view, steps = self.window.picture, int(self.rng.integers(-2, 3))
        held = HELD[int(self.rng.integers(3))]
        self.done = f"wheel {steps}, {held.name}"
        place = QPointF(*(self.rng.random(2) * view.room).tolist())
        event = QWheelEvent(
            place, view.mapToGlobal(place), QPoint(), QPoint(0, 120 * steps),
            Qt.MouseButton.NoButton, held, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(view, event)

    def _do_dock(self) -> None:
        found = [
            widget
            for dock in (*self.window.docks, self.window.picture)
            for kind in (QAbstractSlider, QComboBox, QSpinBox, QCheckBox, QListWidget)
            for widget in dock.findChildren(kind)
            if widget.isEnabled() and widget.isVisible()
        ]
        self.done = "no dock"
        if not found:
            return
        widget = found[int(self.rng.integers(len(found)))]
        self.done = f"{type(widget).__name__} {widget.toolTip()[:40]}"
        if isinstance(widget, QListWidget):
            widget.setCurrentRow(int(self.rng.integers(-1, max(1, widget.count()))))
        elif isinstance(widget, QComboBox):
            row = int(self.rng.integers(max(1, widget.count())))
            widget.setCurrentIndex(row)
            widget.activated.emit(row)
            widget.textActivated.emit(widget.currentText())
        elif isinstance(widget, QCheckBox):
            widget.click()
        else:
            widget.setValue(int(self.rng.integers(widget.minimum(), widget.maximum() + 1)))

    def _do_size(self) -> None:
        size = SIZES[int(self.rng.integers(len(SIZES)))]
        self.done = f"size {size}"
        self.window.resize(*size)

    def _do_wait(self) -> None:
        self.done = "wait"
        self.settle()


def try_window(name: str, actions: int, seed: int, folder: Path) -> Tried:
    """Do so many random things in a window of a kind."""
    tried = Tried(name)
    settings = ShellSettings(folder / f"{name}.ini")
    start_application(settings)
    window: Any = MAKERS[name](settings, folder)
    window.resize(900, 600)
    window.show()
    window.activateWindow()
    hand = RandomHand(window, folder, np.random.default_rng(seed))
    if name == "explore":
        hand.draw_boundary()
    check, digest = CHECKS[name]

    def note(kind: Any, error: BaseException, trace: Any) -> None:
        said = "".join(traceback.format_exception(kind, error, trace)[-6:])
        tried.failures.append(f"{tried.actions}: {hand.done}: {said}")
        # At once: a run that is cut off has told of what it met.
        print(f"{name}, action {tried.failures[-1]}", file=sys.stderr, flush=True)

    before, sys.excepthook = sys.excepthook, note
    begun = time.perf_counter()
    try:
        for number in range(actions):
            tried.actions = number + 1
            at = time.perf_counter()
            hand.act()
            took = time.perf_counter() - at
            if took > tried.slowest:
                tried.slowest, tried.slowest_action = took, hand.done
            try:
                if number % LOOKS == 0:
                    check(window.saver.state)
                if digest is not None and number % TURNS == TURNS - 1:
                    hand.done = "back and forth"
                    hand.settle()
                    leave = window.table.bound["leave"].action
                    leave.trigger()
                    hand.settle()
                    was = digest(window.saver.state)
                    whole = hand.turn_back_and_forth()
                    assert whole and digest(window.saver.state) == was, "undone, and done again"
            except Exception as error:
                note(type(error), error, error.__traceback__)
            if number == actions // 5:
                tried.early = read_memory()
            if number % TOLD == TOLD - 1:
                # A run that is cut off has told how far it was.
                told = f"{name}: {number + 1:,} actions, {len(tried.failures)} failures"
                print(f"{told}, {read_memory():.0f} MB", file=sys.stderr, flush=True)
        hand.settle()
        check(window.saver.state)
    except Exception as error:
        note(type(error), error, error.__traceback__)
    finally:
        sys.excepthook = before
        window.quit_now()
        close = getattr(window.saver.state, "close", None)
        if close is not None:
            close()
        window.deleteLater()
        QApplication.processEvents()
    tried.late = read_memory()
    tried.seconds = time.perf_counter() - begun
    return tried
