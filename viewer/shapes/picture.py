"""The picture of a shape: matte faces, bands along its curves, a ghost, and the panel."""

from __future__ import annotations

import textwrap

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.features.shapemodel.edit import STIFFNESS
from viewer import style
from viewer.card import format_count
from viewer.facts import FactWriter
from viewer.panel import LETTER, MARGIN, PANEL, begin_panel, draw_help
from viewer.picture import Drawn, Frame
from viewer.scene import HEIGHT, HIGHLIGHT_LINE, Scene
from viewer.shapes.commands import KEY_HELP, MOUSE_HELP
from viewer.shapes.sight import ShapeInView
from viewer.shapes.skin import SkinLine
from viewer.shapes.state import HOLD_Y, MODES, ShapesState, count_pages
from viewer.slider import KNOB, LABEL_UP, Rail
from viewer.solid import NOTHING, Triangles, dash_line, make_discs, make_ribbons

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


def compose_shape(
    state: ShapesState,
    aspect: float,
    *,
    bare: bool = False,
    live: bool = False,
    caption: str = "",
    height: float = HEIGHT,
) -> Drawn:
    """Compose the picture for a window of this width to height.

    bare: without the panel. live: in a window, with the name of the curve at the pointer.
    caption: a line below the shape. height: of a bare picture, in points; one with the panel has
    always the same.
    """
    frame = Frame.of(
        state.camera, aspect, bare=bare, height=height, below=CAPTION if caption else 0.0
    )
    scene, solid = frame.scene, frame.solid(_parts(state))
    if caption:
        scene.text(frame.room / 2.0, CAPTION / 3.0, caption, CAPTION * 0.42)
    if not bare:
        if state.helping:
            draw_help(scene, KEY_HELP, MOUSE_HELP)
        else:
            _label(scene, state, frame.middle)
            _message(scene, state.message, frame.room)
        draw_panel(scene, state)
    elif live:
        _label(scene, state, frame.middle)
    return frame.drawn(solid)


def choose_line_colour(state: ShapesState, line: SkinLine) -> str:
    """Choose a curve's own colour, which says what part of the shape it belongs to."""
    return HELD if line.name in state.shaping.choice.held else PARTS[line.part % len(PARTS)]


def _parts(state: ShapesState) -> list[Triangles]:
    sight = state.sight
    above = float(np.ptp(sight.seen[:, 2])) + 50.0
    parts: list[Triangles] = [NOTHING, _faces(sight)]
    if state.edges_shown:
        parts.append(_bands(sight.seen[state.shaping.skin.edges], EDGE, EDGE_WIDTH, EDGE_LIFT))
    parts.append(_bands(sight.outline, OUTLINE, OUTLINE_WIDTH, OUTLINE_LIFT))
    if state.curves_shown:
        parts += _curves(state, sight)
    ghost = state.ghost_sight
    if ghost is not None:
        parts.append(make_ribbons(ghost.drawing, GHOST, GHOST_WIDTH, above))
    if state.shaping.pulled is not None:
        seen = state.camera.view.seen(state.shaping.pulled.wanted)
        parts.append(make_ribbons(dash_line(seen, DASH), GRABBED, TARGET_WIDTH, 2.0 * above))
    return parts


def _faces(sight: ShapeInView) -> Triangles:
    """The faces as of matte clay, on both sides."""
    skin, axes = sight.skin, sight.view.axes
    seen = sight.seen[skin.vertices]
    normals = (sight.normals @ axes.T)[skin.corners]
    a, b, c = (seen[:, e, :2] for e in range(3))
    one, other = b - a, c - a
    away = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0] < 0.0
    normals = np.where(away[:, None, None], -normals, normals)
    base = np.where(away[:, None], style.parse_colour(INSIDE), style.parse_colour(CLAY))
    sun = np.clip(normals @ LIGHT, 0.0, 1.0)
    bright = EVERYWHERE + SKY * (0.5 + 0.5 * normals[..., 1]) + SUN * sun
    facing = np.clip(normals[..., 2], 0.0, 1.0)
    bright *= RIM + (1.0 - RIM) * np.sqrt(facing)
    return seen, np.clip(base[:, None] * bright[..., None], 0.0, 1.0).astype(np.float32)


def _bands(ends: Points, colour: str, width: float, lift: float) -> Triangles:
    """Straight bands (e, 2, 3)."""
    return make_ribbons(list(ends), colour, width, lift)


def _curves(state: ShapesState, sight: ShapeInView) -> list[Triangles]:
    """Curves in their parts' colours, those that are held with pins."""
    hot, grabbed = state.line_under(), state.grabbed
    by_colour: dict[str, list[Points]] = {}
    pins: list[Points] = []
    parts: list[Triangles] = []
    for number, line in enumerate(state.shaping.skin.lines):
        seen = sight.lines[number]
        colour = choose_line_colour(state, line)
        if number == hot:
            if grabbed == number:
                colour = GRABBED
            parts.append(make_ribbons([seen], style.PAPER, HOT_WIDTH + 2.6, HOT_LIFT - 0.7))
            parts.append(make_ribbons([seen], colour, HOT_WIDTH, HOT_LIFT))
        else:
            by_colour.setdefault(colour, []).append(seen)
        if line.name in state.shaping.choice.held:
            pins.append(seen[[0, len(seen) // 2, -1]])
    parts += [make_ribbons(lines, colour, WIDTH, LIFT) for colour, lines in by_colour.items()]
    if pins:
        at = np.concatenate(pins)
        parts.append(make_discs(at, HELD, PIN[0], PIN_LIFT))
        parts.append(make_discs(at, style.PAPER, PIN[1], PIN_LIFT + 1.0))
    return parts


def _label(scene: Scene, state: ShapesState, middle: tuple[float, float]) -> None:
    """The name of the curve at the pointer, beside it."""
    line = state.under()
    if line is None or state.camera.pointer is None:
        return
    x, y = state.camera.pointer[0] + middle[0] + 18.0, state.camera.pointer[1] + middle[1] + 18.0
    text = line.title + ("  (held)" if line.name in state.shaping.choice.held else "")
    width, height = 1.08 * LETTER * 13.0 * len(text) + 38.0, 27.0
    right = scene.width - PANEL - 6.0
    x = max(min(x, right - width), 6.0)
    y = min(y, HEIGHT - height - 6.0)
    scene.box(x, y, width, height, style.PAPER, HIGHLIGHT_LINE)
    dot = style.make_circle() * 5.0 + (x + 16.0, y + height / 2.0)
    scene.polygons(dot[None], face=choose_line_colour(state, line))
    scene.text(x + 28.0, y + 8.6, text, 13.0, align="left")


def _message(scene: Scene, message: str, room: float) -> None:
    """What there is to say, below the shape."""
    lines = textwrap.wrap(message, max(20, int((room - 60.0) / (LETTER * MESSAGE_SIZE))))
    for i, text in enumerate(reversed(lines)):
        y = MESSAGE_Y + 1.35 * MESSAGE_SIZE * i
        scene.text(room / 2.0, y, text, MESSAGE_SIZE, colour=style.MESSAGE)


# What the viewer of shape models says beside its picture: the shape, its modes, what is held.

#: The marks of the limits of pulls: half their height and width, in points; and of the knob of a
#: mode that is at one, or beyond.
TICK = (6.0, 0.9)
LIMIT = "#d55e00"
BEYOND = style.MESSAGE
TICKS = "#8792a0"

#: The mark of the mode that arrow keys change, left of its slider.
CHOSEN = 4.5


def draw_panel(scene: Scene, state: ShapesState) -> None:
    """Write the panel."""
    writer = begin_panel(scene, names=84.0)
    describe_shape(writer, state)
    left = scene.width - PANEL
    rails, value, hot = state.rails, state.value, state.knob_under()
    limits, (low, high) = state.shaping.limits, state.shaping.box
    for knob, rail in rails.items():
        if isinstance(knob, int):
            _limits(scene, rail, (float(low[knob]), float(high[knob])))
            rail.paint(scene, value[knob], hot=knob == hot, mark=0.0)
            _mode(scene, state, knob, rail)
            _mark(scene, rail, value[knob], int(limits[knob]))
        else:
            default = 1.0 if knob == "hold" else STIFFNESS
            enabled = knob != "hold" or bool(state.shaping.choice.held)
            rail.paint(scene, value[knob], hot=knob == hot, mark=default, enabled=enabled)
    count = state.shaping.shapes.n_modes
    if count_pages(count) > 1:
        first = state.page * MODES
        text = f"modes {first + 1}–{min(first + MODES, count)} of {count}    ,  ."
        y = HOLD_Y + LABEL_UP + 24.0
        grey = style.FAINT_TEXT
        scene.text(left + PANEL - MARGIN, y, text, 11.0, colour=grey, align="right")


def describe_shape(writer: FactWriter, state: ShapesState) -> None:
    """Write what there is to say of the shape that is shown."""
    shapes = state.shaping.shapes
    writer.heading(state.shaping.choice.origin, 18.0)
    writer.fact(
        "model",
        f"{format_count(len(shapes.names), 'shape')}, {format_count(shapes.n_modes, 'mode')}",
    )
    writer.fact("mesh", f"{len(shapes.mean):,} vertices, {len(shapes.quads):,} quads")
    name, apart = state.shaping.nearest
    writer.fact("nearest", name + (f", {apart:.3g} units off" if apart > 1e-9 else ""))
    what = "one vertex" if state.bending else "whole curve"
    way = "on the screen" if state.axis is None else f"along {'xyz'[state.axis]}"
    writer.fact("pulls", f"{what}, {way}")
    held = sorted(name.replace("_", " ") for name in state.shaping.choice.held)
    writer.fact("held", ", ".join(held) if 0 < len(held) < 3 else format_count(len(held), "curve"))
    writer.fact("ghost", state.shaping.ghost_name or "none")


def _mode(scene: Scene, state: ShapesState, mode: int, rail: Rail) -> None:
    """The share of the variance beside the mode's number, and the mark of the chosen one."""
    share = f"{100.0 * state.shaping.shapes.shares[mode]:.3g} %"
    grey = style.FAINT_TEXT
    scene.text(rail.left + 22.0, rail.y + LABEL_UP, share, 10.5, colour=grey, align="left")
    if mode == state.chosen:
        x, y = rail.left - 16.0, rail.y
        arrow = np.array([[0.0, CHOSEN], [1.4 * CHOSEN, 0.0], [0.0, -CHOSEN]])
        scene.polygons(_at(arrow, x - CHOSEN, y), face=style.BOUNDARY)


def _limits(scene: Scene, rail: Rail, box: tuple[float, float]) -> None:
    """Ticks at the least and the greatest coefficient of the training shapes."""
    height, width = TICK
    for at in box:
        x = rail.knob(at)
        tick = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * (width, height)
        scene.polygons(_at(tick, x, rail.y), face=TICKS)


def _mark(scene: Scene, rail: Rail, value: float, limit: int) -> None:
    """Another knob at a limit of pulls, or beyond."""
    if limit:
        x = rail.knob(value)
        face = BEYOND if abs(limit) > 1 else LIMIT
        scene.polygons(_at(style.make_circle() * KNOB, x, rail.y), face=face)
        scene.polygons(_at(style.make_circle() * 0.42 * KNOB, x, rail.y), face=style.PAPER)


def _at(corners: NDArray[np.float64], x: float, y: float) -> NDArray[np.float64]:
    """(1, c, 2) a polygon elsewhere."""
    return corners[None] + np.array([x, y])
