"""The picture of a shape: matte faces, bands along its curves, and a ghost."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.features.shapemodel.shaping import ShapeLine
from viewer import style
from viewer.card import format_count
from viewer.facts import FactSheet
from viewer.picture import Frame
from viewer.scene import HIGHLIGHT_LINE, Scene
from viewer.shapes.sight import ShapeInView
from viewer.shapes.state import ShapesState
from viewer.stage import Curves, Drawn, Faces, Layer, LayerCache, Lift, LineLook, make_discs

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

#: How much nearer than what they lie on things are drawn.
EDGE_LIFT, OUTLINE_LIFT, LIFT, HOT_LIFT, PIN_LIFT = (Lift(n) for n in (1.2, 1.4, 3.0, 4.5, 6.0))
DASH = 7.0

#: Height of a line below the shape, in points.
CAPTION = 40.0

#: Width of a letter of a curve's name, at most, in points.
LETTER = 8.2


def compose_shape(
    state: ShapesState,
    width: float,
    height: float,
    caption: str = "",
    cache: LayerCache | None = None,
) -> Drawn:
    """Compose the picture of so many points, with the name of the curve at the pointer.

    caption: a line below the shape. cache: of the last picture of this state.
    """
    frame = Frame.of(state.camera, width, height, CAPTION if caption else 0.0)
    if caption:
        frame.scene.text(width / 2.0, CAPTION / 3.0, caption, CAPTION * 0.42)
    _label(frame.scene, state, frame.middle)
    return frame.drawn(_make_layers(state, LayerCache() if cache is None else cache))


def choose_line_colour(state: ShapesState, line: ShapeLine) -> str:
    """Choose a curve's own colour, which says what part of the shape it belongs to."""
    return HELD if line.name in state.shaping.choice.held else PARTS[line.part % len(PARTS)]


def _make_layers(state: ShapesState, cache: LayerCache) -> list[Layer]:
    sight, view = state.sight, state.camera.view
    layers: list[Layer] = [cache.get("faces", (sight.points,), lambda: _make_faces(sight))]
    if state.edges_shown:
        look = LineLook(EDGE, EDGE_WIDTH, EDGE_LIFT)
        edges = list(sight.points[state.skin.edges])
        layers.append(cache.get("edges", (sight.points,), lambda: Curves.of("edges", edges, look)))
    outline = list(sight.view.unseen(sight.outline))
    layers.append(Curves.of("outline", outline, LineLook(OUTLINE, OUTLINE_WIDTH, OUTLINE_LIFT)))
    if state.curves_shown:
        layers += _make_curves(state, sight)
    # Above everything.
    above = 2.0 * float(np.linalg.norm(np.ptp(sight.points, axis=0)))
    ghost = state.ghost_sight
    if ghost is not None:
        lines = [view.unseen(line) for line in ghost.drawing]
        layers.append(Curves.of("ghost", lines, LineLook(GHOST, GHOST_WIDTH, Lift(0.0, above))))
    if state.shaping.pulled is not None:
        look = LineLook(GRABBED, TARGET_WIDTH, Lift(50.0, above), DASH / view.scale)
        layers.append(Curves.of("target", [state.shaping.pulled.wanted], look))
    return layers


def _make_faces(sight: ShapeInView) -> Faces:
    """Make the faces, as of matte clay, on both sides."""
    skin = sight.skin
    points = sight.points[skin.quads.ravel()]
    return Faces("shape", points, skin.corners, CLAY, normals=sight.normals, back=INSIDE)


def _make_curves(state: ShapesState, sight: ShapeInView) -> list[Layer]:
    """Make curves in their parts' colours, those that are held with pins."""
    hot, grabbed = state.line_under(), state.grabbed
    by_colour: dict[str, list[Points]] = {}
    pins: list[Points] = []
    layers: list[Layer] = []
    for number, line in enumerate(state.skin.lines):
        at = sight.points[line.vertices]
        colour = choose_line_colour(state, line)
        if number == hot:
            if grabbed == number:
                colour = GRABBED
            rim = LineLook(style.PAPER, HOT_WIDTH + 2.6, HOT_LIFT.above(-0.7))
            layers.append(Curves.of("rim", [at], rim))
            layers.append(
                Curves.of("hot", [at], LineLook(colour, HOT_WIDTH, HOT_LIFT.above(HOT_WIDTH)))
            )
        else:
            by_colour.setdefault(colour, []).append(at)
        if line.name in state.shaping.choice.held:
            pins.append(at[[0, len(at) // 2, -1]])
    layers += [
        Curves.of(f"curves {colour}", lines, LineLook(colour, WIDTH, LIFT))
        for colour, lines in by_colour.items()
    ]
    if pins:
        at = np.concatenate(pins)
        layers.append(make_discs("pins", at, HELD, PIN[0], PIN_LIFT))
        layers.append(make_discs("heads", at, style.PAPER, PIN[1], PIN_LIFT.above(1.0)))
    return layers


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
