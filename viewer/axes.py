"""The axes of space in a corner of the picture: which way x, y and z point as they are seen."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from viewer.painting import make_bars
from viewer.scene import Scene

#: Their length, and from the lower left corner to their origin, in points.
LENGTH, AT = 30.0, 52.0

#: Ink of the one that matters, and of the others.
STRONG, FAINT = "#1f2733", "#69727e"

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
    scene.polygons(make_bars(begin[None], end[None], 2.0 * half), face=colour)
