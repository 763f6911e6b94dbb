"""The picture of a surfaced network: shaded pieces, and bands along curves."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.surfacing.patch import SurfacePatch
from patterndb_sketch.surfacing.patchsurface import PatchSurface
from viewer import style
from viewer.card import format_count
from viewer.facts import FactSheet
from viewer.picture import Drawn, Frame
from viewer.solid import NOTHING, Triangles, dash_line, make_discs, make_ribbons, shade_triangles
from viewer.surfacing.state import SurfacingState

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
SNAP = "#10a37f"
OFF = "#7a8594"

#: Curves that bound no patch, dashed, and open rims, wider: shapes tell them for whom colours do
#: not. Both are of Okabe and Ito's palette, darker than any tint of a piece.
IDLE, RIM = "#cc3d9a", "#d55e00"
RIM_PART, IDLE_DASH = 1.5, 5.0

#: How much nearer than what they lie on things are drawn, in points.
CHORD_LIFT, EDGE_LIFT, CURVE_LIFT, NODE_LIFT, STROKE_LIFT = 3.5, 2.5, 4.5, 6.0, 6.5

#: A dash, in points, and by how much the outline of a patch that is off is drawn in.
DASH, DRAWN_IN = 7.0, 0.93

#: Where the light comes from, seen by the viewer; how bright is what it does not reach, and what
#: turns away from the viewer's side of a patch; and how much it brightens.
LIGHT = np.array([-0.4, 0.55, 0.73]) / np.linalg.norm([-0.4, 0.55, 0.73])
SHADE, BACK, LIT = 0.66, 0.93, 1.12

#: The patch under the pointer is lighter by this part of white.
HIGHLIGHT = 0.35


def compose_surface(state: SurfacingState, width: float, height: float, caption: str = "") -> Drawn:
    """Compose the picture of so many points; caption: a line below the network."""
    frame = Frame.of(state.camera, width, height, CAPTION if caption else 0.0)
    solid = frame.solid(_parts(state))
    if caption:
        frame.scene.text(width / 2.0, CAPTION / 3.0, caption, CAPTION / 2.0)
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
    snaps = state.find_snaps()
    if snaps:
        parts.append(
            make_discs(view.seen(np.stack(snaps)), SNAP, RING[1], STROKE_LIFT + 2.0, RING[0])
        )
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


def _faces(state: SurfacingState, body: PatchSurface, lit: int) -> Triangles:
    """Pieces in their tints, shaded on both sides; those of patch ``lit`` lighter."""
    view = state.camera.view
    seen = view.seen(body.corners)
    normals = body.normals @ view.axes.T
    tints = np.stack([style.parse_colour(tint) for tint in style.TINTS])[body.tints]
    tints = np.where((body.owners == lit)[:, None], tints + HIGHLIGHT * (1.0 - tints), tints)
    front = tints[:, None]
    return seen, shade_triangles(seen, normals, front, front * BACK, SHADE, light=LIGHT, lit=LIT)


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


# What the viewer of surfaces says beside its picture: counts, the patch at the pointer.

#: What to do while strokes are drawn.
LOOKING_HINT = "click a patch: off, or on again    drag: turn    D: draw on the surface"
DRAWING_HINT = "drag a stroke on the surface    Enter: make it a curve    u: undo    Esc: leave"


def describe_surface(sheet: FactSheet, state: SurfacingState) -> None:
    """Write what there is to say of the surface, and of the patch at the pointer."""
    _counts(sheet, state)
    sheet.fact("method", state.surfaces.edits.method)
    _patch(sheet, state)
    if state.surfaces.trouble:
        sheet.paragraph(state.surfaces.trouble, style.MESSAGE)


def _counts(sheet: FactSheet, state: SurfacingState) -> None:
    made, patches = state.surfaces.made, state.surfaces.patches
    sheet.heading(_patches(len(patches)), 18.0)
    pieces = sum(len(patch.faces) for patch in patches)
    faces = sum(len(piece) for patch in patches for piece in patch.faces)
    network = state.surfaces.network
    nodes = len({node for curve in network.curves for node in curve.nodes})
    sheet.fact("curves", f"{len(network.curves):,}, {format_count(nodes, 'node')}")
    if state.surfaces.n_stages:
        sheet.fact("stage", f"{state.surfaces.edits.stage} of {state.surfaces.n_stages}    ← →")
    openings = state.surfaces.openings
    if openings is not None and patches:
        curves = format_count(openings.count_rim_curves(), "curve")
        rims = f"{len(openings.rims):,}, {curves}, orange" if openings.rims else "none"
        sheet.fact("open rims", rims)
        if openings.idle:
            sheet.fact("no patch at", f"{format_count(len(openings.idle), 'curve')}, dashed")
    if state.surfaces.off:
        sheet.fact("switched off", f"{len(state.surfaces.off)}")
    sheet.fact("pieces", f"{pieces:,}, {format_count(faces, 'face')}")
    known = [patch.surface for patch in patches if patch.surface is not None]
    chords = sum(len(one.chords) for one in known)
    candidates = sum(one.candidates for one in known)
    if candidates:
        sheet.fact("chords", f"{chords:,} of {format_count(candidates, 'candidate')}")
        sheet.fact("sub-problems", f"{sum(one.n_subproblems for one in known):,}")
    if made is not None and made.surfacing is not None:
        within = sum(one.self_intersections for one in known)
        between = made.surfacing.intersections
        text = "none" if not within + between else f"{within:,} within, {between:,} between"
        sheet.fact("intersections", text)
    if state.surfaces.making:
        sheet.fact("made in", "working …")
    elif made is not None:
        finding = f" + {1e3 * made.finding:,.0f} ms for cycles" if made.finding > 5e-4 else ""
        sheet.fact("made in", f"{1e3 * made.seconds:,.0f} ms{finding}")


def _patch(sheet: FactSheet, state: SurfacingState) -> None:
    """The patch under the pointer, or what there is to say of the whole."""
    under = state.under()
    made = state.surfaces.made
    if under is None:
        for note in () if made is None else made.notes:
            sheet.paragraph(note, style.FAINT_TEXT)
        failed = [p for p in state.surfaces.patches if p.surface is None]
        others = [p for p in state.surfaces.patches if p.note and p.surface is not None]
        if failed:
            text = f"{_patches(len(failed))} without a surface: {failed[0].note}"
            sheet.paragraph(text, style.MESSAGE)
        if others:
            text = f"{_patches(len(others))} with a note: point at them"
            sheet.paragraph(text, style.FAINT_TEXT)
        return
    if not under.on:
        sheet.heading("Switched off")
        sheet.paragraph("a click on its ring switches it on", style.FAINT_TEXT)
        return
    _facts(sheet, state, state.surfaces.patches[under.number])


def _facts(sheet: FactSheet, state: SurfacingState, patch: SurfacePatch) -> None:
    sheet.heading("Patch at the pointer")
    names = ", ".join(str(name) for name in state.surfaces.network_made.names(patch.cycle))
    sheet.fact("curves", names if len(names) < 46 else names[:44] + " …")
    result = patch.surface
    if result is not None:
        sheet.fact("method", result.method + ("  (as before)" if patch.reused else ""))
        if result.method == "chords" or result.candidates:
            sheet.fact(
                "chords", f"{len(result.chords)} of {format_count(result.candidates, 'candidate')}"
            )
            sheet.fact("sub-problems", f"{result.n_subproblems:,}")
        faces = sum(len(piece) for piece in patch.faces)
        sheet.fact("pieces", f"{len(patch.faces)}, {format_count(faces, 'face')}")
        sheet.fact("area", f"{result.area:.4g}")
        sheet.fact("intersections", f"{result.self_intersections:,}")
        sheet.fact("made in", f"{1e3 * result.seconds:.1f} ms")
    if patch.note:
        sheet.paragraph(patch.note, style.FAINT_TEXT)


def _patches(count: int) -> str:
    return f"{count:,} patch" + ("" if count == 1 else "es")
