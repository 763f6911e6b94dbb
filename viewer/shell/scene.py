"""The picture of a window: a pyvista scene in a Qt widget, and text over it.

A composed picture (:class:`viewer.picture.Drawn`) has a point for every logical pixel: shaded
triangles, flat polygons in layers before them, and text. Triangles and polygons go to VTK, each
in one actor whose arrays are replaced; text is painted by Qt over them, sharp at any density.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
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
from viewer.picture import Drawn
from viewer.scene import Scene, ScenePolygons

#: Milliseconds between two pictures: what an event changes is drawn with all that came by then.
BETWEEN_PICTURES = 33

#: Where OpenGL takes longer than so many milliseconds for a picture (it is software there), edges
#: are smoothed only when nothing has changed for so many: that takes a third of a picture's time.
SLOW, STILL = 16, 200

#: Distance between layers of polygons, and from the nearest thing to the camera; any will do.
LAYER, CAMERA = 1e-3, 10.0

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
        self._ground, self._solid, self._flat = (TriangleActor(self) for _ in range(3))
        self._texts = TextOverlay(self)
        # Not by pyvista's own way, which makes a window of its own to see what VTK can do.
        self.renderer.SetUseFXAA(True)
        self.enable_parallel_projection()
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
        """Draw once more, with smooth edges."""
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
        scene, solid = drawn.scene, drawn.solid
        self._ground.show_triangles(*solid.ground)
        count = len(solid.ground[0])
        self._solid.show_triangles(solid.corners[count:], solid.colours[count:])
        low, high = merge_ranges(self._ground.depths, self._solid.depths)
        # All of it lies behind the layers.
        self._ground.sink(high + 1.0)
        self._solid.sink(high + 1.0)
        depth = high - low + 1.0
        self._flat.show_triangles(*fan_polygons(scene.patches))
        x, y = scene.width / 2.0, scene.height / 2.0
        # Not by pyvista's properties, each of which looks how large all of the scene is.
        camera: Any = self.renderer.GetActiveCamera()
        front = CAMERA + LAYER * len(scene.patches)
        camera.SetPosition(x, y, front)
        camera.SetFocalPoint(x, y, 0.0)
        camera.SetViewUp(0.0, 1.0, 0.0)
        camera.SetParallelScale(y)
        camera.SetClippingRange(0.5, front + depth + 1.0)
        self._texts.show_texts(scene)
        self.renderer.SetUseFXAA(not self._slow)
        if self._slow:
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


class TriangleActor:
    """Triangles of one colour at each corner, in one actor of a plotter, replaced as a whole.

    depths: the least and the greatest third coordinate; None without triangles.
    """

    def __init__(self, plotter: Any) -> None:
        import pyvista as pv

        self._plotter = plotter
        self._mesh: Any = pv.PolyData()
        self._actor: Any = None
        self._shown: tuple[NDArray[Any], NDArray[Any]] | None = None
        self.depths: tuple[float, float] | None = None

    def show_triangles(self, corners: NDArray[Any], colours: NDArray[Any]) -> None:
        """Show these instead: corners (t, 3, 3), colours (t, 3, 3) from 0 to 1. Nothing is done
        if they are the very arrays that are shown."""
        import pyvista as pv

        before = self._shown
        if before is not None and before[0] is corners and before[1] is colours:
            return
        self._shown = corners, colours
        count = len(corners)
        self.depths = None
        if self._actor is None:
            if not count:
                return
            self._mesh = pv.PolyData()
        if count:
            near = corners[..., 2]
            self.depths = float(near.min()), float(near.max())
            points = np.ascontiguousarray(corners.reshape(-1, 3), np.float32)
            shades = np.clip(colours.reshape(-1, 3) * 255.0 + 0.5, 0.0, 255.0).astype(np.uint8)
            if before is not None and count == len(before[0]):
                self._mesh.points = points
            else:
                faces = np.arange(3 * count).reshape(count, 3)
                self._mesh.copy_from(pv.PolyData.from_regular_faces(points, faces))
            self._mesh.point_data.set_array(shades, "colour")
        if self._actor is None:
            self._actor = self._plotter.add_mesh(
                self._mesh,
                scalars="colour",
                rgb=True,
                lighting=False,
                reset_camera=False,
                render=False,
                copy_mesh=False,
            )
        self._actor.SetVisibility(bool(count))

    def sink(self, depth: float) -> None:
        """Show all of it so much deeper than it is."""
        if self._actor is not None:
            self._actor.SetPosition(0.0, 0.0, -depth)


def merge_ranges(*ranges: tuple[float, float] | None) -> tuple[float, float]:
    """Find the least and the greatest of some ranges; 0 and 0 if there are none."""
    kept = [one for one in ranges if one is not None]
    return (min(low for low, _ in kept), max(high for _, high in kept)) if kept else (0.0, 0.0)


def fan_polygons(patches: list[ScenePolygons]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Cut polygons into triangles about their middles: (t, 3, 3) corners and (t, 3, 3) colours.

    Later layers are nearer. What is painted over a scene (lines, discs, stars, boxes) is seen
    whole from its middle; a polygon that is not would be filled beyond its outline.
    """
    corners: list[NDArray[Any]] = [np.zeros((0, 3, 3))]
    colours: list[NDArray[Any]] = [np.zeros((0, 3, 3))]
    for layer, patch in enumerate(patches):
        outline = patch.corners
        n, c = outline.shape[:2]
        if c == 3:
            flat = outline[:, None]
        elif c == 4:
            flat = outline[:, [[0, 1, 2], [0, 2, 3]]]
        else:
            middle = np.broadcast_to(outline.mean(axis=1, keepdims=True), outline.shape)
            flat = np.stack([middle, outline, np.roll(outline, -1, axis=1)], axis=2)
        flat = flat.reshape(-1, 3, 2)
        z = np.full((*flat.shape[:2], 1), layer * LAYER)
        corners.append(np.concatenate([flat, z], axis=2))
        each = np.repeat(patch.colours, len(flat) // max(n, 1), axis=0)
        colours.append(np.broadcast_to(each[:, None], (len(flat), 3, 3)))
    return np.concatenate(corners), np.concatenate(colours)


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
