"""The picture of a surfaced network: shaded pieces, bands along curves, and the panel."""

from __future__ import annotations

import numpy as np

from viewer import style
from viewer.drawn import Drawn
from viewer.frame import Frame
from viewer.panel import help_box
from viewer.ribbons import NOTHING, Triangles, dashed, discs, ribbons
from viewer.scene import HEIGHT
from viewer.surfacing.body import Body
from viewer.surfacing.keys import KEY_HELP, MOUSE_HELP
from viewer.surfacing.panel import panel
from viewer.surfacing.state import SurfacingState

#: Width of curves: part of the median curve's length, least and most, in points; and of chords
#: as a part of that.
CURVE_WIDTH = (0.05, 1.8, 4.2)
CHORD_PART = 0.42

#: Radius of a node, in widths of curves, and other widths in points.
NODE_RADIUS = 0.85
EDGE_WIDTH, STROKE_WIDTH, OFF_WIDTH = 1.1, 4.8, 2.4
RING = (4.5, 8.5)

#: Height of the line below the network, in points.
CAPTION = 36.0

CURVE = "#26303d"
CHORD = "#4c5663"
FACE_EDGE = "#5b6674"
STROKE = "#8a3ffc"
OFF = "#7a8594"

#: How much nearer than what they lie on things are drawn, in points.
CHORD_LIFT, EDGE_LIFT, CURVE_LIFT, NODE_LIFT, STROKE_LIFT = 3.5, 2.5, 4.5, 6.0, 6.5

#: A dash, in points, and by how much the outline of a patch that is off is drawn in.
DASH, DRAWN_IN = 7.0, 0.93

#: Where the light comes from, seen by the viewer; how bright is what it does not reach, and
#: what turns away from the viewer's side of a patch.
LIGHT = np.array([-0.4, 0.55, 0.73]) / np.linalg.norm([-0.4, 0.55, 0.73])
SHADE, BACK = 0.66, 0.93

#: The patch under the pointer is lighter by this part of white.
HIGHLIGHT = 0.35


def compose(
    state: SurfacingState,
    aspect: float,
    *,
    bare: bool = False,
    caption: str = "",
    height: float = HEIGHT,
) -> Drawn:
    """The picture for a window of this width to height.

    bare: without the panel. caption: a line below the network. height: of a bare picture, in
    points; one with the panel has always the same.
    """
    frame = Frame.of(state, aspect, bare=bare, height=height, below=CAPTION if caption else 0.0)
    scene, solid = frame.scene, frame.solid(_parts(state))
    if caption:
        scene.text(frame.room / 2.0, CAPTION / 3.0, caption, CAPTION / 2.0)
    if not bare:
        panel(scene, state)
        if state.helping:
            help_box(scene, KEY_HELP, MOUSE_HELP)
    return frame.drawn(solid)


def _parts(state: SurfacingState) -> list[Triangles]:
    view = state.view
    parts: list[Triangles] = [NOTHING]
    body, width = state.body, _curve_width(state)
    under = state.under()
    if body is not None and state.surface_shown:
        lit = under.number if under is not None and under.on and not state.drawing_mode else -1
        parts.append(_faces(state, body, lit))
        if state.edges_shown:
            edges = view.seen(body.edges)
            parts.append(ribbons(list(edges), FACE_EDGE, EDGE_WIDTH, EDGE_LIFT))
    if body is not None and state.chords_shown:
        parts.append(ribbons(list(view.seen(body.chords)), CHORD, CHORD_PART * width, CHORD_LIFT))
    if state.off_shown:
        lit = under.number if under is not None and not under.on else -1
        parts += _off(state, lit)
    if state.curves_shown:
        network = state.network
        lines = [view.seen(curve.points) for curve in network.curves]
        parts.append(ribbons(lines, CURVE, width, CURVE_LIFT))
        # Where a lone closed curve begins and ends is no matter.
        nodes = sorted({n for curve in network.curves if not curve.closed for n in curve.nodes})
        places = view.seen(network.nodes[nodes])
        parts.append(discs(places, CURVE, NODE_RADIUS * width, NODE_LIFT))
    going_on = state.ink
    for ink in (*state.edits.inks, *([] if going_on is None else [going_on])):
        lines = [view.seen(part) for part in ink.parts]
        parts.append(ribbons(lines, STROKE, STROKE_WIDTH, STROKE_LIFT))
        ends = np.concatenate([part[[0, -1]] for part in ink.parts] or [np.zeros((0, 3))])
        parts.append(discs(view.seen(ends), STROKE, STROKE_WIDTH / 2.0, STROKE_LIFT + 1.0))
    return parts


def _curve_width(state: SurfacingState) -> float:
    """In points: thin where curves lie close."""
    lengths = [curve.length for curve in state.edits.drawing.network.curves] or [np.inf]
    part, least, most = CURVE_WIDTH
    return float(np.clip(part * np.median(lengths) * state.view.scale, least, most))


def _faces(state: SurfacingState, body: Body, lit: int) -> Triangles:
    """Pieces in their tints, shaded on both sides; those of patch ``lit`` lighter."""
    view = state.view
    seen = view.seen(body.corners)
    normals = body.normals @ view.axes.T
    a, b, c = (seen[:, e, :2] for e in range(3))
    one, other = b - a, c - a
    away = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0] < 0.0
    normals = np.where(away[:, None, None], -normals, normals)
    tints = np.stack([style.rgb(tint) for tint in style.TINTS])[body.tints]
    tints = np.where((body.owners == lit)[:, None], tints + HIGHLIGHT * (1.0 - tints), tints)
    tints = np.where(away[:, None], tints * BACK, tints)
    bright = SHADE + (1.0 - SHADE) * np.clip(1.12 * (normals @ LIGHT), 0.0, 1.0)
    return seen, (tints[:, None] * bright[..., None]).astype(np.float32)


def _off(state: SurfacingState, lit: int) -> list[Triangles]:
    """Patches that are switched off: a dashed outline, drawn in, and a ring in the middle."""
    parts: list[Triangles] = []
    middles = state.rings()
    for number, middle in enumerate(middles):
        colour = style.SELECTED if number == lit else OFF
        around = state.off_polyline(number)
        inner = middle + DRAWN_IN * (np.concatenate([around, around[:1]]) - middle)
        dashes = dashed(state.view.seen(inner), DASH)
        parts.append(ribbons(dashes, colour, OFF_WIDTH, CHORD_LIFT))
        at = state.view.seen(middle[None])
        parts.append(discs(at, colour, RING[1], NODE_LIFT, RING[0]))
    return parts
