"""What the fill explorer says beside its picture: the fill, the question, the legend."""

from __future__ import annotations

import textwrap

import numpy as np

from viewer import style
from viewer.card import plural, valence_text
from viewer.explorer_keys import KEY_HELP, MOUSE_HELP
from viewer.explorer_state import ExplorerState
from viewer.pen import Mode
from viewer.scene import HEIGHT, HIGHLIGHT_LINE, RULE, Scene

#: Width of the part at the right, in points.
PANEL = 336.0

MARGIN = 26.0
LINE = 21.0
SIZE = 12.5
NAMES = 88.0

#: Width of DejaVu Sans as a part of its size, on average.
LETTER = 0.58

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
    left = scene.width - PANEL
    corners = np.array([[left, 0.0], [scene.width, 0.0], [scene.width, HEIGHT], [left, HEIGHT]])
    scene.polygons(corners[None], face=style.PAPER)
    scene.box(left, 30.0, 0.0, HEIGHT - 60.0, RULE, RULE)
    writer = _Writer(scene, left + MARGIN, HEIGHT - 46.0)
    _headline(writer, state)
    _fill(writer, state)
    _question(writer, state)
    _legend(writer, state)
    trouble = state.message or state.trouble
    if trouble:
        writer.skip(0.5)
        writer.paragraph(trouble, style.MESSAGE)
    right = scene.width - MARGIN
    scene.text(right, 30.0, "h  keys      q  quit", 11.5, colour=style.FAINT_TEXT, align="right")
    if HINTS[state.mode] and not state.helping:
        scene.text(left / 2.0, HEIGHT - 40.0, HINTS[state.mode], 13.0, colour=style.MESSAGE)


def help_box(scene: Scene) -> None:
    """The list of keys, over the picture."""
    step = 25.0
    width, height = 430.0, step * len(KEY_HELP) + 96.0
    # At the left, so that the fill in the middle is not covered whole.
    left, top = MARGIN, (HEIGHT + height) / 2.0
    scene.box(left, top - height, width, height, style.PAPER, HIGHLIGHT_LINE)
    scene.text(left + 24.0, top - 34.0, "Keys", 15.0, bold=True, align="left")
    for i, (keys, what) in enumerate(KEY_HELP):
        y = top - 62.0 - step * i
        scene.text(left + 24.0, y, keys, SIZE, bold=True, align="left")
        scene.text(left + 130.0, y, what, SIZE, align="left")
    y = top - height + 20.0
    scene.text(left + 24.0, y, MOUSE_HELP, 10.5, colour=style.FAINT_TEXT, align="left")


class _Writer:
    """Writes line under line."""

    def __init__(self, scene: Scene, left: float, y: float) -> None:
        self.scene, self.left, self.y = scene, left, y
        self.room = PANEL - 2.0 * MARGIN

    def skip(self, lines: float) -> None:
        self.y -= lines * LINE

    def heading(self, text: str, size: float = 13.5) -> None:
        self.scene.text(self.left, self.y, text, size, bold=True, align="left")
        self.y -= 1.15 * LINE

    def fact(self, name: str, value: str, *, mono: bool = False) -> None:
        """A name and its value; a long one is written smaller, but not too small."""
        fits = (self.room - NAMES) / ((0.61 if mono else LETTER) * max(len(value), 1))
        size = max(min(SIZE, fits), 8.5)
        most = int((self.room - NAMES) / ((0.61 if mono else LETTER) * size))
        if len(value) > most:
            value = value[: max(most - 1, 1)] + "…"
        grey = style.FAINT_TEXT
        self.scene.text(self.left, self.y, name, 12.0, colour=grey, align="left")
        self.scene.text(self.left + NAMES, self.y, value, size, mono=mono, align="left")
        self.y -= LINE

    def paragraph(self, text: str, colour: str) -> None:
        for line in textwrap.wrap(text, int(self.room / (LETTER * 12.0))):
            self.scene.text(self.left, self.y, line, 12.0, colour=colour, align="left")
            self.y -= 0.82 * LINE

    def marker(self, x: float, shape: np.ndarray, face: str, line: str, text: str) -> None:
        """A marker and what it means, at x from the left, without going to the next line."""
        radius = 5.2
        at = np.array([self.left + x + radius, self.y + 4.4])
        self.scene.polygons((at + shape * radius)[None], face=face, line=line, width=1.4)
        self.scene.text(
            self.left + x + 19.0, self.y, text, 12.0, colour=style.FAINT_TEXT, align="left"
        )


def _headline(writer: _Writer, state: ExplorerState) -> None:
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


def _fill(writer: _Writer, state: ExplorerState) -> None:
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


def _question(writer: _Writer, state: ExplorerState) -> None:
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


def _legend(writer: _Writer, state: ExplorerState) -> None:
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
        writer.y -= LINE
