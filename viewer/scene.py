"""A flat picture that is remembered, as filled polygons and lines of text: no window in here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.painting import PaintedPolygons, PaintTarget, Text

#: Height of a picture for which widths of lines were chosen, in points.
HEIGHT = 860.0

#: Rims of boxes.
HIGHLIGHT_LINE = "#7fa8d6"


@dataclass(slots=True)
class ScenePolygons:
    """Polygons of one layer: (n, c, 2) corners and (n, 3) colours, 0 to 1."""

    corners: Points
    colours: Points


class Scene(PaintTarget):
    """Remembers what is painted on it, back to front; outlines become polygons, too."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self.patches: list[ScenePolygons] = []
        self.texts: list[Text] = []

    def add(self, item: PaintedPolygons | Text) -> None:
        """Keep one more thing."""
        if isinstance(item, Text):
            self.texts.append(item)
            return
        if item.faces is not None:
            self.patches.append(ScenePolygons(item.corners, item.faces))
        if item.line != "none":
            edges = _strokes(item.corners, item.width)
            colours = np.tile(style.parse_colour(item.line), (len(edges), 1))
            self.patches.append(ScenePolygons(edges, colours))

    def box(self, x: float, y: float, width: float, height: float, face: str, line: str) -> None:
        """Paint a rectangle, (x, y) its lower left."""
        right, top = x + width, y + height
        corners = np.array([[x, y], [right, y], [right, top], [x, top]])
        self.polygons(corners[None], face=face, line=line, width=1.2)


def _strokes(corners: Points, width: float) -> Points:
    """(n * c, 4, 2) a thin rectangle for every edge of (n, c, 2) polygons, ends lapping."""
    a = corners.reshape(-1, 2)
    b = np.roll(corners, -1, axis=1).reshape(-1, 2)
    length = np.linalg.norm(b - a, axis=1, keepdims=True)
    along = (b - a) / np.where(length > 0.0, length, 1.0) * width / 2.0
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    a, b = a - 0.7 * along, b + 0.7 * along
    return np.stack([a + across, b + across, b - across, a - across], axis=1)
