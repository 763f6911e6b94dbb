"""The panel at the right of a picture: lines of text under each other, and the list of keys."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.facts import LegendEntry
from viewer.scene import HEIGHT, HIGHLIGHT_LINE, RULE, Scene

#: Width of the panel, and of its margins, in points.
PANEL = 336.0
MARGIN = 26.0

#: Height of a line of text, its size, and where values begin after their names, in points.
LINE = 21.0
SIZE = 12.5
NAMES = 108.0

#: Width of DejaVu Sans as a part of its size, on average, and of its kin of even width.
LETTER, MONO = 0.58, 0.61

#: Size of text that nothing is written smaller than.
LEAST = 8.5

#: Lines that a paragraph may take; the command line's --json has all of it.
MOST_LINES = 7


class PanelWriter:
    """Writes line under line in the panel, from (left, y) down."""

    def __init__(self, scene: Scene, left: float, y: float, *, names: float = NAMES) -> None:
        self.scene, self.left, self.y = scene, left, y
        self.names = names
        self.room = PANEL - 2.0 * MARGIN

    def skip(self, lines: float) -> None:
        """Leave so many lines free."""
        self.y -= lines * LINE

    def heading(self, text: str, size: float = 13.5) -> None:
        """A line in bold."""
        self.scene.text(self.left, self.y, text, size, bold=True, align="left")
        self.y -= 1.15 * LINE

    def fact(self, name: str, value: str, *, mono: bool = False) -> None:
        """A name and its value; a long one is written smaller, and cut if that is not enough."""
        room, letter = self.room - self.names, MONO if mono else LETTER
        size = max(min(SIZE, room / (letter * max(len(value), 1))), LEAST)
        most = int(room / (letter * size))
        if len(value) > most:
            value = value[: max(most - 1, 1)] + "…"
        grey = style.FAINT_TEXT
        self.scene.text(self.left, self.y, name, 12.0, colour=grey, align="left")
        self.scene.text(self.left + self.names, self.y, value, size, mono=mono, align="left")
        self.y -= LINE

    def marker(self, x: float, shape: Points, face: str, line: str, text: str) -> None:
        """A marker, an outline (k, 2), and what it means, at x from the left; the line goes on."""
        radius = 5.2
        at = np.array([self.left + x + radius, self.y + 4.4])
        self.scene.polygons((at + shape * radius)[None], face=face, line=line, width=1.4)
        grey = style.FAINT_TEXT
        self.scene.text(self.left + x + 19.0, self.y, text, 12.0, colour=grey, align="left")

    def legend(self, entries: Sequence[LegendEntry]) -> None:
        """What markers mean, two in a line."""
        for i in range(0, len(entries), 2):
            for column, (shape, face, line, text) in enumerate(entries[i : i + 2]):
                self.marker(column * 0.52 * self.room, shape, face, line, text)
            self.skip(1.0)

    def paragraph(self, text: str, colour: str) -> None:
        """A text in lines as long as fit."""
        lines = textwrap.wrap(text, int(self.room / (LETTER * 12.0)))
        if len(lines) > MOST_LINES:
            lines = [*lines[: MOST_LINES - 1], lines[MOST_LINES - 1] + " …"]
        for line in lines:
            self.scene.text(self.left, self.y, line, 12.0, colour=colour, align="left")
            self.y -= 0.82 * LINE


def begin_panel(scene: Scene, *, names: float = NAMES) -> PanelWriter:
    """Paint an empty panel with its last line; what writes in it, at its top."""
    left = scene.width - PANEL
    corners = np.array([[left, 0.0], [scene.width, 0.0], [scene.width, HEIGHT], [left, HEIGHT]])
    scene.polygons(corners[None], face=style.PAPER)
    scene.box(left, 30.0, 0.0, HEIGHT - 60.0, RULE, RULE)
    right = scene.width - MARGIN
    scene.text(right, 30.0, "h  keys      q  quit", 11.5, colour=style.FAINT_TEXT, align="right")
    return PanelWriter(scene, left + MARGIN, HEIGHT - 46.0, names=names)


def draw_hint(scene: Scene, text: str) -> None:
    """Draw a line above the picture beside the panel, of what is to be done now."""
    left = scene.width - PANEL
    scene.text(left / 2.0, HEIGHT - 40.0, text, 13.0, colour=style.MESSAGE)


def draw_help(scene: Scene, keys: Sequence[tuple[str, str]], mouse: str) -> None:
    """Draw the list of keys, over the picture: (keys, what they do), and what the mouse does."""
    step = 25.0
    width, height = 450.0, step * len(keys) + 96.0
    left, top = MARGIN, (HEIGHT + height) / 2.0
    scene.box(left, top - height, width, height, style.PAPER, HIGHLIGHT_LINE)
    scene.text(left + 24.0, top - 34.0, "Keys", 15.0, bold=True, align="left")
    for i, (names, what) in enumerate(keys):
        y = top - 62.0 - step * i
        scene.text(left + 24.0, y, names, SIZE, bold=True, align="left")
        scene.text(left + 130.0, y, what, SIZE, align="left")
    y = top - height + 20.0
    scene.text(left + 24.0, y, mouse, 10.5, colour=style.FAINT_TEXT, align="left")


# The axes of space in a corner of the picture: which way x, y and z point as they are seen.

#: Their length, and from the lower left corner to their origin, in points.
LENGTH, AT = 30.0, 52.0

#: Ink of the one that matters, and of the others.
STRONG, FAINT = "#1f2733", "#9aa3af"

#: Points from the end of an axis to its name, and beside one that is seen end on.
BESIDE, END_ON = 9.0, (7.0, 5.0)


def draw_axes(scene: Scene, axes: Points, chosen: str) -> None:
    """Draw x, y and z; axes: (3, 3) of the view, see :class:`viewer.camera.View`. chosen: the name
    of the one in strong ink, "" for none."""
    begin = np.array([AT, AT])
    for number in np.argsort(axes[2], kind="stable").tolist():
        name, along = "xyz"[number], axes[:2, number]
        strong = name == chosen
        colour = STRONG if strong else FAINT
        size = float(np.linalg.norm(along))
        end = begin + LENGTH * along
        if size > 0.02:
            draw_line(scene, begin, end, 1.5 if strong else 0.9, colour)
        label = end + (BESIDE * along / size if size > 0.25 else np.array(END_ON))
        scene.text(label[0], label[1] - 4.5, name, 11.5, colour=colour, bold=strong)


def draw_line(scene: Scene, begin: Points, end: Points, half: float, colour: str) -> None:
    """Draw a straight line in the picture between two places (2,), half so many points wide."""
    along = end - begin
    size = float(np.linalg.norm(along))
    if size > 0.0:
        side = np.array([-along[1], along[0]]) / size * half
        corners = np.stack([begin - side, end - side, end + side, begin + side])
        scene.polygons(corners[None], face=colour)
