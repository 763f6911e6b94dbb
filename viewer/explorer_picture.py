"""The fill explorer's picture: shaded triangles, polygons over them, and text."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.fillfinder import FillFinder
from viewer import style
from viewer.card import format_count, format_valences
from viewer.explorer_state import ExplorerState
from viewer.facts import FactSheet, LegendEntry
from viewer.net import Net
from viewer.painting import make_bars
from viewer.picture import Drawn
from viewer.pointerstroke import PointerMode
from viewer.scene import Scene
from viewer.solid import Hiding, Solid

#: Width of a fill's lines as a part of its edges, least and most, in points; likewise the
#: radius of an irregular vertex's marker.
LINE = (0.035, 0.55, 1.3)
MARKER = (0.16, 3.0, 7.0)

BOUNDARY_WIDTH = 3.0
STROKE_WIDTH = 3.6
STRAND_WIDTH = 2.2
PREVIEW = "#e4487f"

#: Pieces of a stroke between points of it: it follows the surface.
PIECES = 6

#: From a side to its number, in points.
LABEL = 18.0
LABEL_RIM = "#b9c1cb"


#: Edges of a fill of before.
FADED = "#a3abb5"


def compose_explorer(state: ExplorerState, width: float, height: float) -> Drawn:
    """Compose the picture of so many points."""
    scene, middle = Scene(width, height), (width / 2.0, height / 2.0)
    state.camera.fill(width, height)
    placed = None if state.hiding else state.finder.placed
    # What was found before the boundary changed stays in sight until there is something new.
    former = None if state.hiding or placed is not None else state.exploration.former
    net = placed.net if placed is not None else None if former is None else former.net
    solid = Solid.of(state.camera.view, middle, state.surface, net, faded=former is not None)
    painter = _Painter(state, scene, Hiding(solid, width, height), middle)
    if net is not None:
        painter.net(net, style.EDGE if former is None else FADED)
    if former is not None:
        net = None
    painter.boundary(net)
    for stroke in state.finder.strokes:
        if stroke.points is not None:
            painter.line(stroke.points, style.STROKE, STROKE_WIDTH, closed=stroke.is_loop)
    if net is not None:
        for strip, colour in zip(state.strips_under(), style.STRANDS, strict=False):
            painter.line(strip, style.PAPER, STRAND_WIDTH + 1.8)
            painter.line(strip, colour, STRAND_WIDTH)
        painter.markers(net)
    painter.in_progress()
    if not scene.patches:
        # Never without anything: a scene has a layer at least.
        scene.box(0.0, 0.0, 0.0, 0.0, style.PAPER, style.PAPER)
    return Drawn(scene, solid, middle)


class _Painter:
    """Puts lines and markers into a scene, but for what is hidden."""

    def __init__(
        self, state: ExplorerState, scene: Scene, hiding: Hiding, middle: tuple[float, float]
    ) -> None:
        self.state, self.scene, self.hiding = state, scene, hiding
        self._shift = np.array([*middle, 0.0])
        self._radius = MARKER[2]

    def net(self, net: Net, colour: str) -> None:
        """The edges of quads."""
        edge = net.edge * self.state.camera.view.scale
        self._radius = float(np.clip(edge * MARKER[0], *MARKER[1:]))
        self._lines(self._seen(net.edges), colour, float(np.clip(edge * LINE[0], *LINE[1:])))

    def markers(self, net: Net) -> None:
        """Irregular vertices, as everywhere in the viewer, and odd ones on the boundary."""
        radius = self._radius
        odd = self._shown(net.odd)
        if len(odd):
            ring = odd[:, None] + style.make_circle() * (0.95 * radius)
            self.scene.polygons(ring, face=style.PAPER, line=style.SELECTED, width=0.45 * radius)
        for kind in np.unique(net.valences).tolist():
            at = self._shown(net.irregular[net.valences == kind])
            if len(at):
                shape = at[:, None] + style.choose_valence_shape(kind) * radius
                # Paint a larger one in white first: an outline of thin pieces has gaps at
                # the points of a triangle.
                rim = at[:, None] + style.choose_valence_shape(kind) * (radius + 1.4)
                self.scene.polygons(rim, face=style.PAPER)
                self.scene.polygons(shape, face=style.choose_valence_colour(kind))

    def boundary(self, net: Net | None) -> None:
        contour, boundary = self.state.contour, self.state.finder.boundary
        if contour is None:
            return
        meant = self.state.meant_side
        chosen = self.state.side_under() if meant is None else meant
        if boundary is None or boundary.points is None:
            for i, side in enumerate(contour.sides):
                self.line(side, style.SELECTED if i == chosen else style.BOUNDARY, BOUNDARY_WIDTH)
        else:
            starts = boundary.side_starts
            edges = self._ring(boundary.points) if net is None else net.border
            for i, (a, b) in enumerate(pairwise(starts)):
                colour = style.SELECTED if i == chosen else style.BOUNDARY
                self._lines(self._seen(edges[a:b]), colour, BOUNDARY_WIDTH)
            ticks = self._shown(boundary.points)
            if len(ticks):
                dots = ticks[:, None] + style.make_circle() * (0.95 * BOUNDARY_WIDTH)
                self.scene.polygons(dots, face=style.BOUNDARY)
        self._corners()
        self._labels()

    def line(self, points: Points, colour: str, width: float, *, closed: bool = False) -> None:
        """A polyline (k, 3), laid on the base between its points."""
        if closed:
            points = np.concatenate([points, points[:1]])
        self._lines(self._seen(self._along(points)[None]), colour, width)

    def in_progress(self) -> None:
        """What is being drawn."""
        state = self.state
        for path in state.pen.paths:
            self.line(path, style.BOUNDARY, BOUNDARY_WIDTH)
        if state.pen.preview is not None:
            self.line(state.pen.preview, PREVIEW, 0.6 * BOUNDARY_WIDTH)
        if state.pen.clicked:
            at = self._shown(np.stack(state.pen.clicked))
            if len(at):
                dots = at[:, None] + style.make_circle() * 5.0
                self.scene.polygons(dots, face=style.BOUNDARY)
        if len(state.pen.line) > 1:
            closed = state.mode is PointerMode.LOOP
            self.line(np.stack(state.pen.line), style.STROKE, STROKE_WIDTH, closed=closed)

    def _corners(self) -> None:
        """Convex corners are discs, reflex ones diamonds; the one at the pointer has a halo."""
        contour = self.state.contour
        assert contour is not None
        if not contour.corners:
            return
        places = np.stack([side[0] for side in contour.sides])
        chosen = self.state.corner_under()
        for i, kind in enumerate(contour.corners):
            at = self._shown(places[i : i + 1])
            if not len(at):
                continue
            if i == chosen:
                self.scene.polygons(at[:, None] + style.make_circle() * 10.0, face=style.SELECTED)
            if kind == "convex":
                self.scene.polygons(at[:, None] + style.make_circle() * 5.8, face=style.BOUNDARY)
            else:
                self.scene.polygons(at[:, None] + style.make_diamond() * 9.4, face=style.BOUNDARY)
                self.scene.polygons(at[:, None] + style.make_diamond() * 5.6, face=style.PAPER)

    def _labels(self) -> None:
        """The edge count of every side, beside its middle, outside."""
        contour = self.state.contour
        assert contour is not None
        around = self._seen(np.concatenate(contour.sides))[:, :2]
        after = np.roll(around, -1, axis=0)
        area = float((around[:, 0] * after[:, 1] - around[:, 1] * after[:, 0]).sum())
        for side, length in zip(contour.sides, contour.lengths, strict=True):
            line = self._along(side)
            seen = self._seen(line)
            middle = len(seen) // 2
            if not self.hiding.visible(seen[middle]):
                continue
            along = seen[min(middle + 1, len(seen) - 1), :2] - seen[max(middle - 1, 0), :2]
            size = float(np.hypot(*along))
            if size == 0.0:
                continue
            out = np.array([along[1], -along[0]]) / size * (1.0 if area > 0.0 else -1.0)
            x, y = seen[middle, :2] + LABEL * out
            self.scene.number(x, y, length, 13.0, LABEL_RIM, 1.0, bold=True)

    def _ring(self, points: Points) -> Points:
        """(P, PIECES + 1, 3) the edges of a closed polygon (P, 3), laid on the base."""
        t = np.linspace(0.0, 1.0, PIECES + 1)[None, :, None]
        edges = points[:, None] * (1.0 - t) + np.roll(points, -1, axis=0)[:, None] * t
        if self.state.surface is None:
            return edges
        return self.state.base.on(edges.reshape(-1, 3))[0].reshape(edges.shape)

    def _along(self, points: Points) -> Points:
        """(m, 3) a polyline, cut fine and laid on the base."""
        t = np.arange(PIECES) / PIECES
        a, b = points[:-1, None], points[1:, None]
        fine = np.concatenate([(a + (b - a) * t[:, None]).reshape(-1, 3), points[-1:]])
        return fine if self.state.surface is None else self.state.base.on(fine)[0]

    def _seen(self, points: Points) -> Points:
        return self.state.camera.view.seen(points) + self._shift

    def _shown(self, points: Points) -> Points:
        """(m, 2) where those of (n, 3) points are seen that are not hidden."""
        if not len(points):
            return np.zeros((0, 2))
        seen = self._seen(points)
        return seen[self.hiding.visible(seen), :2]

    def _lines(self, seen: Points, colour: str, width: float) -> None:
        """Polylines (n, k, 3) as they are seen, every piece a thin rectangle."""
        shown = self.hiding.visible(seen)
        both = shown[:, :-1] & shown[:, 1:]
        bars = make_bars(seen[:, :-1, :2][both], seen[:, 1:, :2][both], width, 0.6)
        if len(bars):
            self.scene.polygons(bars, face=colour)


# What the fill explorer says beside its picture: the fill, the question, the legend.

#: More of a surface than this within the boundary: it may run the wrong way round.
MOST_OF_SURFACE = 0.5

#: What is to be done now, by what the pointer does.
HINTS = {
    PointerMode.LOOK: "",
    PointerMode.CORNERS: "click corners on the surface    Enter: close    ⌫: take back    "
    "Esc: leave",
    PointerMode.STROKE: "drag from boundary edge to boundary edge    Esc: leave",
    PointerMode.LOOP: "drag a loop; its ends are joined    Esc: leave",
}


def describe_explorer(sheet: FactSheet, state: ExplorerState) -> None:
    """Write what there is to say: the fill, the question, the legend."""
    _headline(sheet, state)
    _fill(sheet, state)
    _question(sheet, state)
    _legend(sheet, state)


def _headline(sheet: FactSheet, state: ExplorerState) -> None:
    count = len(state.finder.fills)
    if state.contour is None:
        sheet.heading("No boundary yet", 18.0)
        sheet.paragraph("press b and click its corners", style.FAINT_TEXT)
    elif count == 0:
        sheet.heading("searching …" if state.finder.searching else "No fill", 18.0)
    else:
        sheet.heading(f"fill {state.finder.rank + 1:,} of {count:,}", 18.0)
        _variants(sheet, state.finder)
    if count:
        text = "the list is complete"
        if state.finder.searching:
            text = "so far; still searching …"
        elif state.finder.truncated:
            text = "there are more: m"
        sheet.paragraph(text, style.MESSAGE if state.finder.searching else style.FAINT_TEXT)


def _variants(sheet: FactSheet, finder: FillFinder) -> None:
    """What is folded under the fill listed, or which of it is looked at."""
    found = f"{len(finder.variants):,}{' or more' if finder.counting else ''}"
    if finder.variant:
        text = f"variant {finder.variant:,} of {found}: ↑ ↓"
    elif finder.variants:
        noun = "variant" if found == "1" else "variants"
        text = f"+{found} {noun} of its pattern: ↓"
    else:
        return
    sheet.paragraph(text, style.TEXT)


def _fill(sheet: FactSheet, state: ExplorerState) -> None:
    fill = state.finder.fill
    if fill is None:
        return
    inner = fill.n_irregular - fill.n_irregular_boundary
    irregular = f"{inner} inside"
    if fill.n_irregular_boundary:
        irregular += f", {fill.n_irregular_boundary} on the boundary"
    sheet.fact("pattern", fill.pattern.name, mono=True)
    sheet.fact("origin", fill.origin)
    seen = format_count(fill.pattern.frequency, "time") if fill.pattern.frequency else "never"
    sheet.fact("seen", seen)
    sheet.fact("quads", f"{fill.n_quads:,}")
    sheet.fact("irregular", irregular)
    disk = fill.disk()
    sheet.fact("valences", format_valences(disk.valence()[disk.irregular()].tolist()))
    if fill.flow_distance is not None:
        sheet.fact("off strokes", f"{fill.flow_distance:.3g}")
    placed = state.finder.placed
    if placed is None:
        sheet.fact("flipped", "placing …")
    else:
        flipped = len(placed.placement.flipped)
        sheet.fact("flipped", format_count(flipped, "quad") if flipped else "none")
        share = placed.placement.region_share
        if share is not None and share > MOST_OF_SURFACE:
            sheet.fact("encloses", f"{share:.0%} of the surface; other side: k")


def _question(sheet: FactSheet, state: ExplorerState) -> None:
    contour = state.contour
    if contour is None:
        return
    sheet.heading("Asked for")
    sheet.fact("sides", " ".join(map(str, contour.lengths)))
    sheet.fact("corners", "strict" if state.finder.strict else "relaxed")
    sheet.fact("order", state.finder.order or f"{state.finder.default_order} (by default)")
    if state.finder.strokes:
        loops = sum(s.is_loop for s in state.finder.strokes)
        counts = ((len(state.finder.strokes) - loops, "stroke"), (loops, "loop"))
        text = ", ".join(format_count(count, noun) for count, noun in counts if count)
        sheet.fact("strokes", text + ("" if state.finder.following else "; not followed"))
        off = format_count(state.finder.tolerance, "edge") if state.finder.tolerance else "exact"
        sheet.fact("tolerance", off)


def _legend(sheet: FactSheet, state: ExplorerState) -> None:
    contour = state.contour
    if contour is None:
        return
    entries: list[LegendEntry] = []
    placed = None if state.hiding else state.finder.placed
    if placed is not None:
        kinds, counts = np.unique(placed.net.valences, return_counts=True)
        for kind, count in zip(kinds.tolist(), counts.tolist(), strict=True):
            colour = style.choose_valence_colour(kind)
            text = f"valence {kind}  ×{count}"
            entries.append((style.choose_valence_shape(kind), colour, "none", text))
        if len(placed.net.odd):
            text = f"on boundary  ×{len(placed.net.odd)}"
            entries.append((style.make_circle() * 0.8, style.PAPER, style.SELECTED, text))
    if "convex" in contour.corners:
        entries.append((style.make_circle() * 0.9, style.BOUNDARY, "none", "convex"))
    if "reflex" in contour.corners:
        entries.append((style.make_diamond() * 1.2, style.PAPER, style.BOUNDARY, "reflex"))
    sheet.legend(entries)
