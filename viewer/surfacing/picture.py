"""The picture of a surfaced network: shaded pieces, and bands along curves."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.surfacing.patch import SurfacePatch
from patterndb_sketch.surfacing.patchsurface import PatchSurface
from viewer import style
from viewer.card import format_count
from viewer.facts import FactSheet
from viewer.picture import Frame
from viewer.stage import (
    Curves,
    Drawn,
    Faces,
    Layer,
    LayerCache,
    Lift,
    LineLook,
    make_discs,
    make_rings,
)
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

#: How much nearer than what they lie on things are drawn.
CHORD_LIFT, EDGE_LIFT, CURVE_LIFT = Lift(3.5), Lift(2.5), Lift(4.5)
NODE_LIFT, STROKE_LIFT = Lift(6.0), Lift(6.5)

#: A dash, in points, and by how much the outline of a patch that is off is drawn in.
DASH, DRAWN_IN = 7.0, 0.93

#: The patch under the pointer is lighter by this part of white.
HIGHLIGHT = 0.35


def compose_surface(
    state: SurfacingState,
    width: float,
    height: float,
    caption: str = "",
    cache: LayerCache | None = None,
) -> Drawn:
    """Compose the picture of a given size in points.

    caption: a line below the network. cache: of the last picture of this state.
    """
    frame = Frame.of(state.camera, width, height, CAPTION if caption else 0.0)
    if caption:
        frame.scene.text(width / 2.0, CAPTION / 3.0, caption, CAPTION / 2.0)
    return frame.drawn(_make_layers(state, LayerCache() if cache is None else cache))


def _make_layers(state: SurfacingState, cache: LayerCache) -> list[Layer]:
    layers: list[Layer] = []
    body, width = state.surfaces.body, _curve_width(state)
    under = state.under()
    if body is not None and state.surface_shown:
        lit = under.number if under is not None and under.on and not state.drawing_mode else -1
        layers.append(cache.get("faces", (body, lit), lambda: make_pieces(body, lit)))
        if state.edges_shown:
            look = LineLook(FACE_EDGE, EDGE_WIDTH, EDGE_LIFT)
            edges = list(body.edges)
            layers.append(cache.get("edges", (body,), lambda: Curves.of("edges", edges, look)))
    if body is not None and state.chords_shown:
        look = LineLook(CHORD, CHORD_PART * width, CHORD_LIFT)
        chords = list(body.chords)
        layers.append(cache.get("chords", (body, width), lambda: Curves.of("chords", chords, look)))
    if state.off_shown:
        lit = under.number if under is not None and not under.on else -1
        layers += _make_off(state, lit)
    if state.curves_shown:
        network, openings = state.surfaces.network, state.surfaces.openings
        shown = state.openings_shown and bool(state.surfaces.patches)
        dash = IDLE_DASH / state.camera.view.scale
        layers += cache.get(
            "curves",
            (network, openings, shown, width, dash),
            lambda: _make_curves(state, width, dash),
        )
    going_on = state.ink
    inks = [*state.surfaces.edits.inks, *([] if going_on is None else [going_on])]
    parts = [part for ink in inks for part in ink.parts]
    layers.append(Curves.of("strokes", parts, LineLook(STROKE, STROKE_WIDTH, STROKE_LIFT)))
    ends = np.concatenate([np.zeros((0, 3)), *(part[[0, -1]] for part in parts)])
    layers.append(make_discs("ends", ends, STROKE, STROKE_WIDTH / 2.0, STROKE_LIFT.above(1.0)))
    snaps = state.find_snaps()
    if snaps:
        layers.append(make_rings("snaps", np.stack(snaps), SNAP, RING, STROKE_LIFT.above(2.0)))
    return layers


def _make_curves(state: SurfacingState, width: float, dash: float) -> list[Layer]:
    """Make curves; those that bound nothing, and open rims, told apart if that is asked for."""
    network, openings = state.surfaces.network, state.surfaces.openings
    lines = [curve.points for curve in network.curves]
    idle: set[int] = set()
    rims: set[int] = set()
    # Where no patch is there yet, all is open: nothing is worth a mark.
    if openings is not None and state.openings_shown and state.surfaces.patches:
        idle = set(openings.idle)
        rims = {curve for rim in openings.rims for curve, _ in rim.steps}
    # Where a lone closed curve begins and ends is no matter.
    nodes = sorted({n for curve in network.curves if not curve.closed for n in curve.nodes})
    plain = [line for i, line in enumerate(lines) if i not in idle | rims]
    return [
        Curves.of("curves", plain, LineLook(CURVE, width, CURVE_LIFT)),
        Curves.of("rims", [lines[i] for i in rims], LineLook(RIM, RIM_PART * width, CURVE_LIFT)),
        Curves.of("idle", [lines[i] for i in idle], LineLook(IDLE, width, CURVE_LIFT, dash)),
        make_discs("nodes", network.nodes[nodes], CURVE, NODE_RADIUS * width, NODE_LIFT),
    ]


def _curve_width(state: SurfacingState) -> float:
    """In points: thin where curves lie close."""
    lengths = [curve.length for curve in state.surfaces.edits.drawing.network.curves] or [np.inf]
    part, least, most = CURVE_WIDTH
    return float(np.clip(part * np.median(lengths) * state.camera.view.scale, least, most))


def make_pieces(body: PatchSurface, lit: int) -> Faces:
    """Make the pieces in their tints; those of patch ``lit`` lighter."""
    tints = np.stack([style.parse_colour(tint) for tint in style.TINTS])[body.tints]
    tints = np.where((body.owners == lit)[:, None], tints + HIGHLIGHT * (1.0 - tints), tints)
    points, normals = body.corners.reshape(-1, 3), body.normals.reshape(-1, 3)
    faces = np.arange(len(points)).reshape(-1, 3)
    return Faces("pieces", points, faces, face_colours=tints, normals=normals)


def _make_off(state: SurfacingState, lit: int) -> list[Layer]:
    """Patches that are switched off: a dashed outline, drawn in, and a ring in the middle."""
    layers: list[Layer] = []
    dash = DASH / state.camera.view.scale
    for number, middle in enumerate(state.surfaces.rings()):
        colour = style.SELECTED if number == lit else OFF
        around = state.surfaces.off_polyline(number)
        inner = middle + DRAWN_IN * (np.concatenate([around, around[:1]]) - middle)
        look = LineLook(colour, OFF_WIDTH, CHORD_LIFT, dash)
        layers.append(Curves.of(f"off {number}", [inner], look))
        layers.append(make_rings(f"off ring {number}", middle[None], colour, RING, NODE_LIFT))
    return layers


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
