"""What the fill explorer says beside its picture: the fill, the question, the legend."""

from __future__ import annotations

import numpy as np

from viewer import style
from viewer.card import plural, valence_text
from viewer.explorer_state import ExplorerState
from viewer.panel import Writer, begin_panel, hint
from viewer.pen import Mode
from viewer.scene import Scene

#: Where values begin after their names, in points.
NAMES = 88.0

#: More of a surface than this within the boundary: it may run the wrong way round.
MOST_OF_SURFACE = 0.5

HINTS = {
    Mode.LOOK: "",
    Mode.CORNERS: "click corners on the surface    Enter: close    ⌫: take back    Esc: leave",
    Mode.STROKE: "drag from boundary edge to boundary edge    Esc: leave",
    Mode.LOOP: "drag a loop; its ends are joined    Esc: leave",
}


def panel(scene: Scene, state: ExplorerState) -> None:
    """Write the panel, and a hint above the picture while something is drawn."""
    writer = begin_panel(scene, names=NAMES)
    _headline(writer, state)
    _fill(writer, state)
    _question(writer, state)
    _legend(writer, state)
    trouble = state.message or state.trouble
    if trouble:
        writer.skip(0.5)
        writer.paragraph(trouble, style.MESSAGE)
    if HINTS[state.mode] and not state.helping:
        hint(scene, HINTS[state.mode])


def _headline(writer: Writer, state: ExplorerState) -> None:
    count = len(state.fills)
    if state.contour is None:
        writer.heading("No boundary yet", 18.0)
        writer.paragraph("press b and click its corners", style.FAINT_TEXT)
    elif count == 0:
        writer.heading("searching …" if state.searching else "No fill", 18.0)
    else:
        writer.heading(f"fill {state.rank + 1:,} of {count:,}", 18.0)
    if count:
        text = "the list is complete"
        if state.searching:
            text = "so far; still searching …"
        elif state.truncated:
            text = "there are more: m"
        writer.paragraph(text, style.MESSAGE if state.searching else style.FAINT_TEXT)
    writer.skip(0.6)


def _fill(writer: Writer, state: ExplorerState) -> None:
    fill = state.fill
    if fill is None:
        return
    inner = fill.n_irregular - fill.n_irregular_boundary
    irregular = f"{inner} inside"
    if fill.n_irregular_boundary:
        irregular += f", {fill.n_irregular_boundary} on the boundary"
    writer.fact("pattern", fill.pattern.name, mono=True)
    writer.fact("origin", fill.origin)
    seen = plural(fill.pattern.frequency, "time") if fill.pattern.frequency else "never"
    writer.fact("seen", seen)
    writer.fact("quads", f"{fill.n_quads:,}")
    writer.fact("irregular", irregular)
    disk = fill.disk()
    writer.fact("valences", valence_text(disk.valence()[disk.irregular()].tolist()))
    if fill.flow_distance is not None:
        writer.fact("off strokes", f"{fill.flow_distance:.3g}")
    placed = state.placed
    if placed is None:
        writer.fact("flipped", "placing …")
    else:
        flipped = len(placed.placement.flipped)
        writer.fact("flipped", plural(flipped, "quad") if flipped else "none")
        share = placed.placement.region_share
        if share is not None and share > MOST_OF_SURFACE:
            writer.fact("encloses", f"{share:.0%} of the surface; other side: k")
    writer.skip(0.6)


def _question(writer: Writer, state: ExplorerState) -> None:
    contour = state.contour
    if contour is None:
        return
    writer.heading("Asked for")
    writer.fact("sides", " ".join(map(str, contour.lengths)))
    writer.fact("corners", "strict" if state.strict else "relaxed")
    writer.fact("order", state.order or f"{state.default_order} (by default)")
    if state.strokes:
        loops = sum(s.is_loop for s in state.strokes)
        counts = ((len(state.strokes) - loops, "stroke"), (loops, "loop"))
        text = ", ".join(plural(count, noun) for count, noun in counts if count)
        writer.fact("strokes", text + ("" if state.following else "; not followed"))
        off = plural(state.tolerance, "edge") if state.tolerance else "exact"
        writer.fact("tolerance", off)
    writer.skip(0.6)


def _legend(writer: Writer, state: ExplorerState) -> None:
    contour = state.contour
    if contour is None:
        return
    entries: list[tuple[np.ndarray, str, str, str]] = []
    placed = None if state.hiding else state.placed
    if placed is not None:
        kinds, counts = np.unique(np.clip(placed.net.valences, 2, 7), return_counts=True)
        for kind, count in zip(kinds.tolist(), counts.tolist(), strict=True):
            colour = style.VALENCE_COLOURS[kind]
            text = f"valence {style.valence_label(kind)}  ×{count}"
            entries.append((style.valence_shape(kind), colour, "none", text))
        if len(placed.net.odd):
            text = f"on boundary  ×{len(placed.net.odd)}"
            entries.append((style.circle() * 0.8, style.PAPER, style.SELECTED, text))
    if "convex" in contour.corners:
        entries.append((style.circle() * 0.9, style.BOUNDARY, "none", "convex"))
    if "reflex" in contour.corners:
        entries.append((style.diamond() * 1.2, style.PAPER, style.BOUNDARY, "reflex"))
    for i in range(0, len(entries), 2):
        for column, (shape, face, line, text) in enumerate(entries[i : i + 2]):
            writer.marker(column * 0.52 * writer.room, shape, face, line, text)
        writer.skip(1.0)
