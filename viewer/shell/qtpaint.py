"""Paints a drawing with Qt: what thumbnails, and flat pictures in windows, are made of."""

from __future__ import annotations

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPixmap, QPolygonF

from viewer import style
from viewer.drawing import DiskDrawing
from viewer.painting import PaintedPolygons, PaintTarget, Text, paint_disk
from viewer.scene import Scene
from viewer.shell.scene import paint_text, paint_texts

#: Room around the drawing of a thumbnail, in logical pixels.
AROUND = 3.0


class QtTarget(PaintTarget):
    """Paints on a painter; height: of it, in points."""

    def __init__(self, painter: QPainter, height: float) -> None:
        self._painter, self._height = painter, height
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def add(self, item: PaintedPolygons | Text) -> None:
        """Paint one thing."""
        painter = self._painter
        if isinstance(item, Text):
            paint_text(painter, item, self._height)
            return
        outlined = item.line != "none"
        pen = QPen(QColor(item.line), item.width) if outlined else QPen(Qt.PenStyle.NoPen)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for number, outline in enumerate(item.corners.tolist()):
            if item.faces is not None:
                painter.setBrush(QColor.fromRgbF(*item.faces[number].tolist()))
            painter.drawPolygon(QPolygonF([QPointF(x, self._height - y) for x, y in outline]))


def paint_scene(painter: QPainter, scene: Scene) -> None:
    """Paint a scene, a point to a logical pixel."""
    target = QtTarget(painter, scene.height)
    for patch in scene.patches:
        target.polygons(patch.corners, faces=patch.colours)
    paint_texts(painter, scene)


def paint_thumbnail(drawing: DiskDrawing, size: int, density: float) -> QPixmap:
    """Paint a drawing in a square of so many logical pixels; density: pixels to one of them."""
    pixmap = QPixmap(round(size * density), round(size * density))
    pixmap.setDevicePixelRatio(density)
    # Ink is dark, in dark windows too.
    pixmap.fill(QColor(style.PAPER))
    painter = QPainter(pixmap)
    paint_disk(QtTarget(painter, size), drawing, size / 2.0, size / 2.0, size - 2.0 * AROUND)
    painter.end()
    return pixmap
