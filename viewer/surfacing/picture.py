"""The picture of a surfaced network: shaded pieces, bands along curves, and the panel."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.surfacing.methods import METHODS
from patterndb_sketch.surfacing.patch import SurfacePatch
from viewer import style
from viewer.card import format_count
from viewer.facts import FactWriter
from viewer.panel import MARGIN, PANEL, SIZE, PanelWriter, begin_panel, draw_help, draw_hint
from viewer.picture import Drawn, Frame
from viewer.scene import HEIGHT, Scene
from viewer.solid import NOTHING, Triangles, dash_line, make_discs, make_ribbons
from viewer.surfacing.body import SurfaceBody
from viewer.surfacing.commands import KEY_HELP, MOUSE_HELP
from viewer.surfacing.state import (
    SLIDER,
    SLIDER_Y,
    SurfacingState,
    to_slider_share,
)

# Which tint each piece of a surface gets: neighbours differ.


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

#: Curves that bound no patch, dashed, and open rims, wider: shapes tell them for whom colours do
#: not. Both are of Okabe and Ito's palette, darker than any tint of a piece.
IDLE, RIM = "#cc3d9a", "#d55e00"
RIM_PART, IDLE_DASH = 1.5, 5.0

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


#: Where the names of methods begin in their line, how wide a letter of one is at most, and what is
#: left between two: together they fit beside the heading.
METHODS_AT, LETTER, GAP = 68.0, 8.4, 10.0


def compose_surface(
    state: SurfacingState,
    aspect: float,
    *,
    bare: bool = False,
    caption: str = "",
    height: float = HEIGHT,
) -> Drawn:
    """Compose the picture for a window of this width to height.

    bare: without the panel. caption: a line below the network. height: of a bare picture, in
    points; one with the panel has always the same.
    """
    frame = Frame.of(
        state.camera, aspect, bare=bare, height=height, below=CAPTION if caption else 0.0
    )
    scene, solid = frame.scene, frame.solid(_parts(state))
    if caption:
        scene.text(frame.room / 2.0, CAPTION / 3.0, caption, CAPTION / 2.0)
    if not bare:
        draw_panel(scene, state)
        if state.helping:
            draw_help(scene, KEY_HELP, MOUSE_HELP)
    return frame.drawn(solid)


def _parts(state: SurfacingState) -> list[Triangles]:
    view = state.camera.view
    parts: list[Triangles] = [NOTHING]
    body, width = state.surfaces.body, _curve_width(state)
    under = state.under()
    if body is not None and state.surface_shown:
        lit = under.number if under is not None and under.on and not state.drawing_mode else -1
        parts.append(_faces(state, body, lit))
        if state.edges_shown:
            edges = view.seen(body.edges)
            parts.append(make_ribbons(list(edges), FACE_EDGE, EDGE_WIDTH, EDGE_LIFT))
    if body is not None and state.chords_shown:
        parts.append(
            make_ribbons(list(view.seen(body.chords)), CHORD, CHORD_PART * width, CHORD_LIFT)
        )
    if state.off_shown:
        lit = under.number if under is not None and not under.on else -1
        parts += _off(state, lit)
    if state.curves_shown:
        network = state.surfaces.network
        parts += _curves(state, width)
        # Where a lone closed curve begins and ends is no matter.
        nodes = sorted({n for curve in network.curves if not curve.closed for n in curve.nodes})
        places = view.seen(network.nodes[nodes])
        parts.append(make_discs(places, CURVE, NODE_RADIUS * width, NODE_LIFT))
    going_on = state.ink
    for ink in (*state.surfaces.edits.inks, *([] if going_on is None else [going_on])):
        lines = [view.seen(part) for part in ink.parts]
        parts.append(make_ribbons(lines, STROKE, STROKE_WIDTH, STROKE_LIFT))
        ends = np.concatenate([part[[0, -1]] for part in ink.parts] or [np.zeros((0, 3))])
        parts.append(make_discs(view.seen(ends), STROKE, STROKE_WIDTH / 2.0, STROKE_LIFT + 1.0))
    return parts


def _curves(state: SurfacingState, width: float) -> list[Triangles]:
    """The curves; those that bound nothing, and open rims, told apart if that is asked for."""
    lines = [state.camera.view.seen(curve.points) for curve in state.surfaces.network.curves]
    openings = state.surfaces.openings
    # Where no patch is there yet, all is open: nothing is worth a mark.
    if openings is None or not state.openings_shown or not state.surfaces.patches:
        return [make_ribbons(lines, CURVE, width, CURVE_LIFT)]
    idle = set(openings.idle)
    rims = {curve for rim in openings.rims for curve, _ in rim.steps}
    plain = [line for i, line in enumerate(lines) if i not in idle | rims]
    dashes = [dash for i in openings.idle for dash in dash_line(lines[i], IDLE_DASH)]
    return [
        make_ribbons(plain, CURVE, width, CURVE_LIFT),
        make_ribbons([lines[i] for i in sorted(rims)], RIM, RIM_PART * width, CURVE_LIFT),
        make_ribbons(dashes, IDLE, width, CURVE_LIFT),
    ]


def _curve_width(state: SurfacingState) -> float:
    """In points: thin where curves lie close."""
    lengths = [curve.length for curve in state.surfaces.edits.drawing.network.curves] or [np.inf]
    part, least, most = CURVE_WIDTH
    return float(np.clip(part * np.median(lengths) * state.camera.view.scale, least, most))


def _faces(state: SurfacingState, body: SurfaceBody, lit: int) -> Triangles:
    """Pieces in their tints, shaded on both sides; those of patch ``lit`` lighter."""
    view = state.camera.view
    seen = view.seen(body.corners)
    normals = body.normals @ view.axes.T
    a, b, c = (seen[:, e, :2] for e in range(3))
    one, other = b - a, c - a
    away = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0] < 0.0
    normals = np.where(away[:, None, None], -normals, normals)
    tints = np.stack([style.parse_colour(tint) for tint in style.TINTS])[body.tints]
    tints = np.where((body.owners == lit)[:, None], tints + HIGHLIGHT * (1.0 - tints), tints)
    tints = np.where(away[:, None], tints * BACK, tints)
    bright = SHADE + (1.0 - SHADE) * np.clip(1.12 * (normals @ LIGHT), 0.0, 1.0)
    return seen, (tints[:, None] * bright[..., None]).astype(np.float32)


def _off(state: SurfacingState, lit: int) -> list[Triangles]:
    """Patches that are switched off: a dashed outline, drawn in, and a ring in the middle."""
    parts: list[Triangles] = []
    middles = state.surfaces.rings()
    for number, middle in enumerate(middles):
        colour = style.SELECTED if number == lit else OFF
        around = state.surfaces.off_polyline(number)
        inner = middle + DRAWN_IN * (np.concatenate([around, around[:1]]) - middle)
        dashes = dash_line(state.camera.view.seen(inner), DASH)
        parts.append(make_ribbons(dashes, colour, OFF_WIDTH, CHORD_LIFT))
        at = state.camera.view.seen(middle[None])
        parts.append(make_discs(at, colour, RING[1], NODE_LIFT, RING[0]))
    return parts


# What the viewer of surfaces says beside its picture: counts, the slider, the patch in hand.

KNOB = 8.0
TRACK = "#c9d0d9"


#: What to do while strokes are drawn.
DRAWING_HINT = "drag a stroke on the surface    Enter: make it a curve    u: undo    Esc: leave"


def draw_panel(scene: Scene, state: SurfacingState) -> None:
    """Write the panel, and a hint above the picture while strokes are drawn."""
    left = scene.width - PANEL
    writer = begin_panel(scene)
    _counts(writer, state)
    _slider(scene, state, left)
    writer.y = SLIDER_Y - 52.0
    _methods(writer, state)
    _patch(writer, state)
    for text in (state.message, state.surfaces.trouble):
        if text:
            writer.skip(0.5)
            writer.paragraph(text, style.MESSAGE)
    if state.drawing_mode and not state.helping:
        draw_hint(scene, DRAWING_HINT)


def describe_surface(writer: FactWriter, state: SurfacingState) -> None:
    """Write what there is to say of the surface, and of the patch at the pointer."""
    _counts(writer, state)
    writer.fact("method", state.surfaces.edits.method)
    _patch(writer, state)
    if state.surfaces.trouble:
        writer.paragraph(state.surfaces.trouble, style.MESSAGE)


def _counts(writer: FactWriter, state: SurfacingState) -> None:
    made, patches = state.surfaces.made, state.surfaces.patches
    writer.heading(_patches(len(patches)), 18.0)
    pieces = sum(len(patch.faces) for patch in patches)
    faces = sum(len(piece) for patch in patches for piece in patch.faces)
    network = state.surfaces.network
    nodes = len({node for curve in network.curves for node in curve.nodes})
    writer.fact("curves", f"{len(network.curves):,}, {format_count(nodes, 'node')}")
    if state.surfaces.n_stages:
        writer.fact("stage", f"{state.surfaces.edits.stage} of {state.surfaces.n_stages}    ← →")
    openings = state.surfaces.openings
    if openings is not None and patches:
        curves = format_count(openings.count_rim_curves(), "curve")
        rims = f"{len(openings.rims):,}, {curves}, orange" if openings.rims else "none"
        writer.fact("open rims", rims)
        if openings.idle:
            writer.fact("no patch at", f"{format_count(len(openings.idle), 'curve')}, dashed")
    if state.surfaces.off:
        writer.fact("switched off", f"{len(state.surfaces.off)}")
    writer.fact("pieces", f"{pieces:,}, {format_count(faces, 'face')}")
    known = [patch.surface for patch in patches if patch.surface is not None]
    chords = sum(len(one.chords) for one in known)
    candidates = sum(one.candidates for one in known)
    if candidates:
        writer.fact("chords", f"{chords:,} of {format_count(candidates, 'candidate')}")
        writer.fact("sub-problems", f"{sum(one.n_subproblems for one in known):,}")
    if made is not None and made.surfacing is not None:
        within = sum(one.self_intersections for one in known)
        between = made.surfacing.intersections
        text = "none" if not within + between else f"{within:,} within, {between:,} between"
        writer.fact("intersections", text)
    if state.surfaces.making:
        writer.fact("made in", "working …")
    elif made is not None:
        finding = f" + {1e3 * made.finding:,.0f} ms for cycles" if made.finding > 5e-4 else ""
        writer.fact("made in", f"{1e3 * made.seconds:,.0f} ms{finding}")


def _slider(scene: Scene, state: SurfacingState, left: float) -> None:
    """The line, its knob, and alpha above it."""
    alpha = state.surfaces.settings.alpha
    start, end = left + SLIDER[0], left + SLIDER[1]
    scene.text(left + MARGIN, SLIDER_Y + 22.0, "alpha", 13.5, bold=True, align="left")
    scene.text(end + 6.0, SLIDER_Y + 22.0, f"{alpha:.3g}", 13.5, align="right")
    low, high = SLIDER_Y - 2.0, SLIDER_Y + 2.0
    line = np.array([[start, low], [end, low], [end, high], [start, high]])
    scene.polygons(line[None], face=TRACK)
    at = start + (end - start) * to_slider_share(alpha)
    knob = style.make_circle() * KNOB + (at, SLIDER_Y)
    scene.polygons(knob[None], face=style.BOUNDARY)
    scene.polygons((style.make_circle() * 0.45 * KNOB + (at, SLIDER_Y))[None], face=style.PAPER)
    grey = style.FAINT_TEXT
    scene.text(start - 6.0, SLIDER_Y - 24.0, "0  more chords", 11.0, colour=grey, align="left")
    scene.text(end + 6.0, SLIDER_Y - 24.0, "fewer  1", 11.0, colour=grey, align="right")


def _methods(writer: PanelWriter, state: SurfacingState) -> None:
    """The methods in a row, the one asked for in bold."""
    grey = style.FAINT_TEXT
    writer.scene.text(writer.left, writer.y, "method", 13.5, bold=True, align="left")
    x = writer.left + METHODS_AT
    for method in METHODS.values():
        if method.needs_database and not state.surfaces.has_database:
            continue
        chosen = method.name == state.surfaces.edits.method
        colour = style.TEXT if chosen else grey
        writer.scene.text(x, writer.y, method.name, SIZE, colour=colour, bold=chosen, align="left")
        x += LETTER * len(method.name) + GAP
    writer.skip(1.6)


def _patch(writer: FactWriter, state: SurfacingState) -> None:
    """The patch under the pointer, or what there is to say of the whole."""
    under = state.under()
    made = state.surfaces.made
    if under is None:
        for note in () if made is None else made.notes:
            writer.paragraph(note, style.FAINT_TEXT)
        failed = [p for p in state.surfaces.patches if p.surface is None]
        others = [p for p in state.surfaces.patches if p.note and p.surface is not None]
        if failed:
            text = f"{_patches(len(failed))} without a surface: {failed[0].note}"
            writer.paragraph(text, style.MESSAGE)
        if others:
            text = f"{_patches(len(others))} with a note: point at them"
            writer.paragraph(text, style.FAINT_TEXT)
        return
    if not under.on:
        writer.heading("Switched off")
        writer.paragraph("a click on its ring switches it on", style.FAINT_TEXT)
        return
    _facts(writer, state, state.surfaces.patches[under.number])


def _facts(writer: FactWriter, state: SurfacingState, patch: SurfacePatch) -> None:
    writer.heading("Patch at the pointer")
    names = ", ".join(str(name) for name in state.surfaces.network_made.names(patch.cycle))
    writer.fact("curves", names if len(names) < 46 else names[:44] + " …")
    result = patch.surface
    if result is not None:
        writer.fact("method", result.method + ("  (as before)" if patch.reused else ""))
        if result.method == "chords" or result.candidates:
            writer.fact(
                "chords", f"{len(result.chords)} of {format_count(result.candidates, 'candidate')}"
            )
            writer.fact("sub-problems", f"{result.n_subproblems:,}")
        faces = sum(len(piece) for piece in patch.faces)
        writer.fact("pieces", f"{len(patch.faces)}, {format_count(faces, 'face')}")
        writer.fact("area", f"{result.area:.4g}")
        writer.fact("intersections", f"{result.self_intersections:,}")
        writer.fact("made in", f"{1e3 * result.seconds:.1f} ms")
    if patch.note:
        writer.paragraph(patch.note, style.FAINT_TEXT)


def _patches(count: int) -> str:
    return f"{count:,} patch" + ("" if count == 1 else "es")
