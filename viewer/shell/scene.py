"""The picture of a window: a pyvista scene in a Qt widget, and text over it.

A composed picture (:class:`viewer.picture.Drawn`) has a point for every logical pixel: layers in
space, flat polygons before them, and text. VTK shows layers and polygons (:mod:`viewer.stage`);
text is painted by Qt over them, sharp at any density.
"""

from __future__ import annotations

from typing import Protocol

from PySide6.QtCore import QElapsedTimer, QEvent, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QColor,
    QEnterEvent,
    QFont,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget
from pyvistaqt import QtInteractor

from viewer import style
from viewer.painting import Text
from viewer.scene import Scene
from viewer.stage import Drawn, LayerStage

#: Milliseconds between two pictures: what an event changes is drawn with all that came by then.
BETWEEN_PICTURES = 33

#: Where OpenGL takes longer than so many milliseconds for a picture (it is software there), edges
#: are smoothed only when nothing has changed for so many: that takes a third of a picture's time.
SLOW, STILL = 16, 200

#: What a wheel tells for one click of it.
WHEEL_CLICK = 120.0

#: The ground of the picture in light and in dark windows: ink is dark in both.
GROUNDS = {False: style.PAPER, True: "#b4bac3"}


class PointerTaker(Protocol):
    """The state of a viewer, at places in points from the middle of the picture; what returns a
    bool tells whether it has to be drawn again."""

    def press(self, x: float, y: float, *, turn: bool = False) -> bool: ...
    def release(self, x: float, y: float) -> bool: ...
    def move(self, x: float, y: float) -> bool: ...
    def wheel(self, steps: float) -> bool: ...
    def drag_view(self, dx: float, dy: float) -> bool: ...


class SceneView(QtInteractor):
    """Shows composed pictures, and hands every event of the pointer to a state.

    changed: an event changed the state. asked: a picture is due; whoever hears it calls
    :meth:`show_picture`.
    """

    changed = Signal()
    asked = Signal()

    def __init__(self, parent: QWidget | None, state: PointerTaker) -> None:
        # No timer of its own; nothing is sampled many times: a picture costs a third of that.
        super().__init__(parent, auto_update=False, multi_samples=0)
        self.state = state
        self._shifting: QPointF | None = None
        self._stage = LayerStage(self, texts=False)
        self._drawn: Drawn | None = None
        self._texts = TextOverlay(self)
        # Not by pyvista's own way, which makes a window of its own to see what VTK can do.
        self.renderer.SetUseFXAA(True)
        self.set_ground(dark=False)
        for event in ("KeyPressEvent", "CharEvent"):
            self.iren.interactor.RemoveObservers(event)
        # Keys go to the window's actions, and focus follows a click: never the mere pointer.
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        # Files are dropped on the window.
        self.setAcceptDrops(False)
        self._pending = QTimer(self)
        self._pending.setSingleShot(True)
        self._pending.timeout.connect(self._draw)
        self._since = QElapsedTimer()
        self._since.start()
        self._slow = False
        self._still = QTimer(self)
        self._still.setSingleShot(True)
        self._still.setInterval(STILL)
        self._still.timeout.connect(self._smooth)

    def paintGL(self) -> None:
        """Have VTK draw, and see how long it takes."""
        clock = QElapsedTimer()
        clock.start()
        super().paintGL()
        if self.renderer.GetUseFXAA():
            self._slow = clock.elapsed() > SLOW

    def _smooth(self) -> None:
        """Draw once more, all of it and with smooth edges."""
        if self._drawn is not None:
            self._stage.show(self._drawn, self.devicePixelRatioF())
        self.renderer.SetUseFXAA(True)
        self.update()

    def set_ground(self, *, dark: bool) -> None:
        """Choose the ground's colour for light or dark windows."""
        self.set_background(GROUNDS[dark])

    @property
    def room(self) -> tuple[float, float]:
        """Width and height in points."""
        return float(max(self.width(), 1)), float(max(self.height(), 1))

    def ask_picture(self) -> None:
        """Have a picture drawn soon, with whatever else changes until then."""
        if not self._pending.isActive():
            self._pending.start(max(0, BETWEEN_PICTURES - self._since.elapsed()))

    def _draw(self) -> None:
        self._since.restart()
        self.asked.emit()

    def show_picture(self, drawn: Drawn) -> None:
        """Replace what was there; it is seen with the next frame."""
        turning = self._drawn is not None and drawn.view is not self._drawn.view
        self._drawn = drawn
        whole = self._stage.show(drawn, self.devicePixelRatioF(), turning=turning)
        self._texts.show_texts(drawn.scene)
        self.renderer.SetUseFXAA(not self._slow)
        if self._slow or not whole:
            self._still.start()
        self.update()

    def place_of(self, at: QPointF) -> tuple[float, float]:
        """The place of a pixel, in points from the middle, y upward."""
        width, height = self.room
        return at.x() - width / 2.0, height / 2.0 - at.y()

    def _after(self, changed: bool) -> None:
        if changed:
            self.changed.emit()

    # What Qt tells. Nothing of it reaches VTK, which would draw for every event.

    def mousePressEvent(self, ev: QMouseEvent) -> None:
        """Begin what the button does: the middle one turns, or shifts with Shift held down."""
        at, button = self.place_of(ev.position()), ev.button()
        shift = bool(ev.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        if button == Qt.MouseButton.LeftButton:
            self.press_left(at, ev.modifiers())
        elif button == Qt.MouseButton.MiddleButton and shift:
            self._shifting = ev.position()
        elif button in (Qt.MouseButton.RightButton, Qt.MouseButton.MiddleButton):
            self._after(self.state.press(*at, turn=True))
        ev.accept()

    def press_left(self, at: tuple[float, float], modifiers: Qt.KeyboardModifier) -> None:
        """Begin what the left button does."""
        self._after(self.state.press(*at))

    def mouseDoubleClickEvent(self, ev: QMouseEvent) -> None:
        """The second press of a double click is a press."""
        self.mousePressEvent(ev)

    def mouseMoveEvent(self, ev: QMouseEvent) -> None:
        """Go on with what a button does, or point at something."""
        if self._shifting is not None:
            way = ev.position() - self._shifting
            self._shifting = ev.position()
            self._after(self.state.drag_view(way.x(), -way.y()))
        else:
            self._after(self.state.move(*self.place_of(ev.position())))
        ev.accept()

    def mouseReleaseEvent(self, ev: QMouseEvent) -> None:
        """End what the button did, exactly where it came up."""
        if ev.button() == Qt.MouseButton.MiddleButton and self._shifting is not None:
            self._shifting = None
        else:
            self._after(self.state.release(*self.place_of(ev.position())))
        ev.accept()

    def wheelEvent(self, ev: QWheelEvent) -> None:
        """Nearer, or farther off."""
        # With Alt held down Qt gives the other axis.
        delta = ev.angleDelta().y() or ev.angleDelta().x()
        if delta:
            self._after(self.turn_wheel(delta / WHEEL_CLICK, ev.modifiers()))
        ev.accept()

    def turn_wheel(self, steps: float, modifiers: Qt.KeyboardModifier) -> bool:
        """Do what the wheel does; True if that changes the picture."""
        return self.state.wheel(steps)

    def keyPressEvent(self, ev: QKeyEvent) -> None:
        """Leave keys to the window."""
        ev.ignore()

    def keyReleaseEvent(self, ev: QKeyEvent) -> None:
        """Leave keys to the window."""
        ev.ignore()

    def enterEvent(self, ev: QEnterEvent) -> None:
        """Focus is not taken by the mere pointer."""
        ev.accept()

    def leaveEvent(self, ev: QEvent) -> None:
        """What was under the pointer stays until it comes back."""
        ev.accept()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Lay the text out over the new size, and draw anew."""
        super().resizeEvent(event)
        self._texts.resize(event.size())
        self.ask_picture()


class TextOverlay(QWidget):
    """Text over a picture; the pointer goes through it."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self._scene: Scene | None = None

    def show_texts(self, scene: Scene) -> None:
        """Write the texts of a scene instead of those that were there."""
        before = self._scene
        self._scene = scene
        if before is None or before.texts != scene.texts or before.height != scene.height:
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Write them."""
        if self._scene is None or not self._scene.texts:
            return
        painter = QPainter(self)
        paint_texts(painter, self._scene)
        painter.end()


def paint_texts(painter: QPainter, scene: Scene) -> None:
    """Write the texts of a scene with Qt, a point to a logical pixel, y upward."""
    painter.setRenderHint(QPainter.RenderHint.TextAntialiasing)
    for text in scene.texts:
        paint_text(painter, text, scene.height)


def paint_text(painter: QPainter, text: Text, height: float) -> None:
    """Write one text; height: of the picture, from whose lower edge places go."""
    font = make_font(text.size, bold=text.bold, mono=text.mono)
    width = QFontMetricsF(font).horizontalAdvance(text.text)
    left = text.x - {"left": 0.0, "center": width / 2.0, "right": width}[text.align]
    painter.setFont(font)
    painter.setPen(QColor(text.colour))
    painter.drawText(QPointF(left, height - text.y), text.text)


def make_font(size: float, *, bold: bool, mono: bool) -> QFont:
    """Make a font, its size in points of a picture."""
    font = QFont("DejaVu Sans Mono" if mono else "DejaVu Sans")
    font.setStyleHint(QFont.StyleHint.Monospace if mono else QFont.StyleHint.SansSerif)
    font.setPixelSize(max(1, round(size)))
    font.setBold(bold)
    return font
