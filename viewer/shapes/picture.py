"""The picture of a shape: matte faces, bands along its curves, and a ghost."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.features.shapemodel.shaping import ShapeLine
from viewer import style
from viewer.card import format_count
from viewer.facts import FactSheet
from viewer.picture import Drawn, Frame
from viewer.scene import HIGHLIGHT_LINE, Scene
from viewer.shapes.sight import ShapeInView
from viewer.shapes.state import ShapesState
from viewer.solid import NOTHING, Triangles, dash_line, make_discs, make_ribbons, turn_to_viewer

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

#: Height of a line below the shape, in points.
CAPTION = 40.0

#: Width of a letter of a curve's name, at most, in points.
LETTER = 8.2


def compose_shape(state: ShapesState, width: float, height: float, caption: str = "") -> Drawn:
    """Compose the picture of so many points, with the name of the curve at the pointer.

    caption: a line below the shape.
    """
    frame = Frame.of(state.camera, width, height, CAPTION if caption else 0.0)
    scene, solid = frame.scene, frame.solid(_parts(state))
    if caption:
        scene.text(width / 2.0, CAPTION / 3.0, caption, CAPTION * 0.42)
    _label(scene, state, frame.middle)
    return frame.drawn(solid)


def choose_line_colour(state: ShapesState, line: ShapeLine) -> str:
    """Choose a curve's own colour, which says what part of the shape it belongs to."""
    return HELD if line.name in state.shaping.choice.held else PARTS[line.part % len(PARTS)]


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
    normals, away = turn_to_viewer(seen, normals)
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
    for number, line in enumerate(state.skin.lines):
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
    width, height = LETTER * len(text) + 38.0, 27.0
    x = max(min(x, scene.width - width - 6.0), 6.0)
    y = min(y, scene.height - height - 6.0)
    scene.box(x, y, width, height, style.PAPER, HIGHLIGHT_LINE)
    dot = style.make_circle() * 5.0 + (x + 16.0, y + height / 2.0)
    scene.polygons(dot[None], face=choose_line_colour(state, line))
    scene.text(x + 28.0, y + 8.6, text, 13.0, align="left")


def describe_shape(sheet: FactSheet, state: ShapesState) -> None:
    """Write what there is to say of the shape that is shown."""
    shapes = state.shaping.shapes
    sheet.heading(state.shaping.choice.origin, 18.0)
    sheet.fact(
        "model",
        f"{format_count(len(shapes.names), 'shape')}, {format_count(shapes.n_modes, 'mode')}",
    )
    sheet.fact("mesh", f"{len(shapes.mean):,} vertices, {len(shapes.quads):,} quads")
    name, apart = state.shaping.nearest
    sheet.fact("nearest", name + (f", {apart:.3g} units off" if apart > 1e-9 else ""))
    what = "one vertex" if state.bending else "whole curve"
    way = "on the screen" if state.axis is None else f"along {'xyz'[state.axis]}"
    sheet.fact("pulls", f"{what}, {way}")
    held = sorted(name.replace("_", " ") for name in state.shaping.choice.held)
    sheet.fact("held", ", ".join(held) if 0 < len(held) < 3 else format_count(len(held), "curve"))
    sheet.fact("ghost", state.shaping.ghost_name or "none")
