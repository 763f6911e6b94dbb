"""A flat picture that is remembered, as filled polygons and lines of text: no window in here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.painting import PaintedPolygons, PaintTarget, Text, make_bars

#: Height of a picture for which widths of lines were chosen, in points.
HEIGHT = 860.0

#: Half the width and height of a number's box: as parts of the type for each digit, and beside
#: and above them; and from its middle to its baseline.
DIGIT, BESIDE, ABOVE, BASELINE = 0.354, 0.32, 0.7, 0.37

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
            ahead = np.roll(item.corners, -1, axis=1)
            edges = make_bars(item.corners.reshape(-1, 2), ahead.reshape(-1, 2), item.width, 0.7)
            colours = np.tile(style.parse_colour(item.line), (len(edges), 1))
            self.patches.append(ScenePolygons(edges, colours))

    def box(self, x: float, y: float, width: float, height: float, face: str, line: str) -> None:
        """Paint a rectangle, (x, y) its lower left."""
        right, top = x + width, y + height
        corners = np.array([[x, y], [right, y], [right, top], [x, top]])
        self.polygons(corners[None], face=face, line=line, width=1.2)

    def number(
        self, x: float, y: float, number: int, size: float, rim: str, border: float, *, bold: bool
    ) -> None:
        """Write a number about (x, y), in a box with a border of so many points."""
        half = size * np.array([DIGIT * len(str(number)) + BESIDE, ABOVE])
        box = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        self.polygons((box * (half + border) + (x, y))[None], face=rim)
        self.polygons((box * half + (x, y))[None], face=style.PAPER)
        self.text(x, y - BASELINE * size, str(number), size, bold=bold)
