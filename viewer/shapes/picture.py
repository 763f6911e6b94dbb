"""The picture of a shape: matte faces, bands along its curves, a ghost, and the panel."""

from __future__ import annotations

import textwrap

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.drawn import Drawn
from viewer.frame import Frame
from viewer.panel import LETTER, PANEL, help_box
from viewer.ribbons import NOTHING, Triangles, dashed, discs, ribbons
from viewer.scene import HEIGHT, HIGHLIGHT_LINE, Scene
from viewer.shapes.keys import KEY_HELP, MOUSE_HELP
from viewer.shapes.panel import panel
from viewer.shapes.sight import Sight
from viewer.shapes.skin import Line
from viewer.shapes.state import ShapesState

#: Faces seen from outside and from inside.
CLAY, INSIDE = "#dedad3", "#b4afa8"

#: Curves by part of the template, in turn; those that are held; the one that is pulled.
PARTS = ("#0072b2", "#d55e00", "#009e73", "#b8860b", "#56a0c8", "#c2568c")
HELD = "#1f2733"
GRABBED = style.SELECTED
GHOST = "#8f62d9"
EDGE = "#a49f97"
OUTLINE = "#6f6a63"

#: Widths of curves: as they are, at the pointer; and of other lines, in points.
WIDTH, HOT_WIDTH = 3.2, 5.0
EDGE_WIDTH, OUTLINE_WIDTH, GHOST_WIDTH, TARGET_WIDTH = 0.8, 1.3, 1.5, 2.2
PIN = (6.4, 3.0)

#: How much nearer than what they lie on things are drawn, in points; ABOVE is above everything.
EDGE_LIFT, OUTLINE_LIFT, LIFT, HOT_LIFT, PIN_LIFT = 1.2, 1.4, 3.0, 4.5, 6.0
DASH = 7.0

#: Where the light comes from, seen by the viewer; how much of it is everywhere, comes from above,
#: and from there; and how dark is what turns away from the viewer.
LIGHT = np.array([-0.1, 0.55, 0.83]) / np.linalg.norm([-0.1, 0.55, 0.83])
EVERYWHERE, SKY, SUN = 0.52, 0.20, 0.36
RIM = 0.78

#: A line below the shape: its height; and the message, its height and size, in points.
CAPTION = 40.0
MESSAGE_Y, MESSAGE_SIZE = 34.0, 13.5


def compose(
    state: ShapesState,
    aspect: float,
    *,
    bare: bool = False,
    caption: str = "",
    height: float = HEIGHT,
) -> Drawn:
    """The picture for a window of this width to height.

    bare: without the panel. caption: a line below the shape. height: of a bare picture, in
    points; one with the panel has always the same.
    """
    frame = Frame.of(state, aspect, bare=bare, height=height, below=CAPTION if caption else 0.0)
    scene, solid = frame.scene, frame.solid(_parts(state))
    if caption:
        scene.text(frame.room / 2.0, CAPTION / 3.0, caption, CAPTION * 0.42)
    if not bare:
        if state.helping:
            help_box(scene, KEY_HELP, MOUSE_HELP)
        else:
            _label(scene, state, frame.middle)
            _message(scene, state.message, frame.room)
        panel(scene, state)
    return frame.drawn(solid)


def colour_of(state: ShapesState, line: Line) -> str:
    """A curve's own colour, which says what part of the shape it belongs to."""
    return HELD if line.name in state.choice.held else PARTS[line.part % len(PARTS)]


def _parts(state: ShapesState) -> list[Triangles]:
    sight = state.sight
    above = float(np.ptp(sight.seen[:, 2])) + 50.0
    parts: list[Triangles] = [NOTHING, _faces(sight)]
    if state.edges_shown:
        parts.append(_bands(sight.seen[state.skin.edges], EDGE, EDGE_WIDTH, EDGE_LIFT))
    parts.append(_bands(sight.outline, OUTLINE, OUTLINE_WIDTH, OUTLINE_LIFT))
    if state.curves_shown:
        parts += _curves(state, sight)
    ghost = state.ghost_sight
    if ghost is not None:
        parts.append(ribbons(ghost.drawing, GHOST, GHOST_WIDTH, above))
    if state.pulled is not None:
        seen = state.view.seen(state.pulled.wanted)
        parts.append(ribbons(dashed(seen, DASH), GRABBED, TARGET_WIDTH, 2.0 * above))
    return parts


def _faces(sight: Sight) -> Triangles:
    """The faces as of matte clay, on both sides."""
    skin, axes = sight.skin, sight.view.axes
    seen = sight.seen[skin.vertices]
    normals = (sight.normals @ axes.T)[skin.corners]
    a, b, c = (seen[:, e, :2] for e in range(3))
    one, other = b - a, c - a
    away = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0] < 0.0
    normals = np.where(away[:, None, None], -normals, normals)
    base = np.where(away[:, None], style.rgb(INSIDE), style.rgb(CLAY))
    sun = np.clip(normals @ LIGHT, 0.0, 1.0)
    bright = EVERYWHERE + SKY * (0.5 + 0.5 * normals[..., 1]) + SUN * sun
    facing = np.clip(normals[..., 2], 0.0, 1.0)
    bright *= RIM + (1.0 - RIM) * np.sqrt(facing)
    return seen, np.clip(base[:, None] * bright[..., None], 0.0, 1.0).astype(np.float32)


def _bands(ends: Points, colour: str, width: float, lift: float) -> Triangles:
    """Straight bands (e, 2, 3)."""
    return ribbons(list(ends), colour, width, lift)


def _curves(state: ShapesState, sight: Sight) -> list[Triangles]:
    """Curves in their parts' colours, those that are held with pins."""
    hot, grabbed = state.line_under(), state.grabbed
    by_colour: dict[str, list[Points]] = {}
    pins: list[Points] = []
    parts: list[Triangles] = []
    for number, line in enumerate(state.skin.lines):
        seen = sight.lines[number]
        colour = colour_of(state, line)
        if number == hot:
            if grabbed == number:
                colour = GRABBED
            parts.append(ribbons([seen], style.PAPER, HOT_WIDTH + 2.6, HOT_LIFT - 0.7))
            parts.append(ribbons([seen], colour, HOT_WIDTH, HOT_LIFT))
        else:
            by_colour.setdefault(colour, []).append(seen)
        if line.name in state.choice.held:
            pins.append(seen[[0, len(seen) // 2, -1]])
    parts += [ribbons(lines, colour, WIDTH, LIFT) for colour, lines in by_colour.items()]
    if pins:
        at = np.concatenate(pins)
        parts.append(discs(at, HELD, PIN[0], PIN_LIFT))
        parts.append(discs(at, style.PAPER, PIN[1], PIN_LIFT + 1.0))
    return parts


def _label(scene: Scene, state: ShapesState, middle: tuple[float, float]) -> None:
    """The name of the curve at the pointer, beside it."""
    line = state.under()
    if line is None or state.pointer is None:
        return
    x, y = state.pointer[0] + middle[0] + 18.0, state.pointer[1] + middle[1] + 18.0
    text = line.title + ("  (held)" if line.name in state.choice.held else "")
    width, height = 1.08 * LETTER * 13.0 * len(text) + 38.0, 27.0
    right = scene.width - PANEL - 6.0
    x = max(min(x, right - width), 6.0)
    y = min(y, HEIGHT - height - 6.0)
    scene.box(x, y, width, height, style.PAPER, HIGHLIGHT_LINE)
    dot = style.circle() * 5.0 + (x + 16.0, y + height / 2.0)
    scene.polygons(dot[None], face=colour_of(state, line))
    scene.text(x + 28.0, y + 8.6, text, 13.0, align="left")


def _message(scene: Scene, message: str, room: float) -> None:
    """What there is to say, below the shape."""
    lines = textwrap.wrap(message, max(20, int((room - 60.0) / (LETTER * MESSAGE_SIZE))))
    for i, text in enumerate(reversed(lines)):
        y = MESSAGE_Y + 1.35 * MESSAGE_SIZE * i
        scene.text(room / 2.0, y, text, MESSAGE_SIZE, colour=style.MESSAGE)
