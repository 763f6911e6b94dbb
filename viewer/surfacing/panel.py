"""What the viewer of surfaces says beside its picture: counts, the slider, the patch in hand."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.surfacing.methods import METHODS
from patterndb_sketch.surfacing.patch import SurfacePatch
from viewer import style
from viewer.card import plural
from viewer.panel import MARGIN, NAMES, PANEL, SIZE, Writer, begin_panel, hint
from viewer.scene import Scene
from viewer.surfacing.layout import SLIDER, SLIDER_Y, share_of
from viewer.surfacing.state import SurfacingState

KNOB = 8.0
TRACK = "#c9d0d9"


def panel(scene: Scene, state: SurfacingState) -> None:
    """Write the panel, and a hint above the picture while strokes are drawn."""
    left = scene.width - PANEL
    writer = begin_panel(scene)
    _counts(writer, state)
    _slider(scene, state, left)
    writer.y = SLIDER_Y - 52.0
    _methods(writer, state)
    _patch(writer, state)
    for text in (state.message, state.trouble):
        if text:
            writer.skip(0.5)
            writer.paragraph(text, style.MESSAGE)
    if state.drawing_mode and not state.helping:
        hint(
            scene,
            "drag a stroke on the surface    Enter: make it a curve    u: undo    Esc: leave",
        )


def _counts(writer: Writer, state: SurfacingState) -> None:
    made, patches = state.made, state.patches
    writer.heading(_patches(len(patches)), 18.0)
    pieces = sum(len(patch.faces) for patch in patches)
    faces = sum(len(piece) for patch in patches for piece in patch.faces)
    network = state.network
    nodes = len({node for curve in network.curves for node in curve.nodes})
    writer.fact("curves", f"{len(network.curves):,}, {plural(nodes, 'node')}")
    if state.n_stages:
        writer.fact("stage", f"{state.edits.stage} of {state.n_stages}    ← →")
    if state.off:
        writer.fact("switched off", f"{len(state.off)}")
    writer.fact("pieces", f"{pieces:,}, {plural(faces, 'face')}")
    known = [patch.surface for patch in patches if patch.surface is not None]
    chords = sum(len(one.chords) for one in known)
    candidates = sum(one.candidates for one in known)
    if candidates:
        writer.fact("chords", f"{chords:,} of {plural(candidates, 'candidate')}")
        writer.fact("sub-problems", f"{sum(one.n_subproblems for one in known):,}")
    if made is not None and made.surfacing is not None:
        within = sum(one.self_intersections for one in known)
        between = made.surfacing.intersections
        text = "none" if not within + between else f"{within:,} within, {between:,} between"
        writer.fact("intersections", text)
    if state.making:
        writer.fact("made in", "working …")
    elif made is not None:
        finding = f" + {1e3 * made.finding:,.0f} ms for cycles" if made.finding > 5e-4 else ""
        writer.fact("made in", f"{1e3 * made.seconds:,.0f} ms{finding}")


def _slider(scene: Scene, state: SurfacingState, left: float) -> None:
    """The line, its knob, and alpha above it."""
    alpha = state.settings.alpha
    start, end = left + SLIDER[0], left + SLIDER[1]
    scene.text(left + MARGIN, SLIDER_Y + 22.0, "alpha", 13.5, bold=True, align="left")
    scene.text(end + 6.0, SLIDER_Y + 22.0, f"{alpha:.3g}", 13.5, align="right")
    low, high = SLIDER_Y - 2.0, SLIDER_Y + 2.0
    line = np.array([[start, low], [end, low], [end, high], [start, high]])
    scene.polygons(line[None], face=TRACK)
    at = start + (end - start) * share_of(alpha)
    knob = style.circle() * KNOB + (at, SLIDER_Y)
    scene.polygons(knob[None], face=style.BOUNDARY)
    scene.polygons((style.circle() * 0.45 * KNOB + (at, SLIDER_Y))[None], face=style.PAPER)
    grey = style.FAINT_TEXT
    scene.text(start - 6.0, SLIDER_Y - 24.0, "0  more chords", 11.0, colour=grey, align="left")
    scene.text(end + 6.0, SLIDER_Y - 24.0, "fewer  1", 11.0, colour=grey, align="right")


def _methods(writer: Writer, state: SurfacingState) -> None:
    """The methods in a row, the one asked for in bold."""
    grey = style.FAINT_TEXT
    writer.scene.text(writer.left, writer.y, "method", 13.5, bold=True, align="left")
    x = writer.left + NAMES
    for method in METHODS.values():
        if method.needs_database and not state.has_database:
            continue
        chosen = method.name == state.edits.method
        colour = style.TEXT if chosen else grey
        writer.scene.text(x, writer.y, method.name, SIZE, colour=colour, bold=chosen, align="left")
        x += 62.0
    writer.skip(1.6)


def _patch(writer: Writer, state: SurfacingState) -> None:
    """The patch under the pointer, or what there is to say of the whole."""
    under = state.under()
    made = state.made
    if under is None:
        for note in () if made is None else made.notes:
            writer.paragraph(note, style.FAINT_TEXT)
        failed = [p for p in state.patches if p.surface is None]
        others = [p for p in state.patches if p.note and p.surface is not None]
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
    _facts(writer, state, state.patches[under.number])


def _facts(writer: Writer, state: SurfacingState, patch: SurfacePatch) -> None:
    writer.heading("Patch at the pointer")
    names = ", ".join(str(name) for name in state.network_made.names(patch.cycle))
    writer.fact("curves", names if len(names) < 46 else names[:44] + " …")
    result = patch.surface
    if result is not None:
        writer.fact("method", result.method + ("  (as before)" if patch.reused else ""))
        if result.method == "chords" or result.candidates:
            writer.fact(
                "chords", f"{len(result.chords)} of {plural(result.candidates, 'candidate')}"
            )
            writer.fact("sub-problems", f"{result.n_subproblems:,}")
        faces = sum(len(piece) for piece in patch.faces)
        writer.fact("pieces", f"{len(patch.faces)}, {plural(faces, 'face')}")
        writer.fact("area", f"{result.area:.4g}")
        writer.fact("intersections", f"{result.self_intersections:,}")
        writer.fact("made in", f"{1e3 * result.seconds:.1f} ms")
    if patch.note:
        writer.paragraph(patch.note, style.FAINT_TEXT)


def _patches(count: int) -> str:
    return f"{count:,} patch" + ("" if count == 1 else "es")
