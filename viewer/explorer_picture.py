"""The fill explorer's picture: shaded triangles, polygons over them, and text."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.fillfinder import FillFinder
from viewer import style
from viewer.card import format_count, format_valences
from viewer.explorer_state import ExplorerState
from viewer.facts import FactSheet, LegendEntry
from viewer.net import Net
from viewer.picture import Frame
from viewer.pointerstroke import PointerMode
from viewer.retopo.pointing import find_visible
from viewer.scene import Scene
from viewer.stage import (
    Curves,
    Drawn,
    Faces,
    Layer,
    LayerCache,
    Lift,
    LineLook,
    Marks,
    make_discs,
    make_valence_marks,
)

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


#: Faces of a surface and of a fill, from both sides; of quads of strands that carry strokes, and
#: of a fill of before.
SURFACE, SURFACE_BACK = "#c3ccd6", "#97a2ae"
QUADS, CARRIED, FORMER = "#fff8ea", "#ffcb80", "#cfd3d8"

#: A fill's pieces cut through the surface's triangles: it is drawn nearer by this many points and
#: this part of an edge. Lines and marks are nearer by this many points more.
LIFT = (2.0, 0.12)
LINES, TICKS, CORNERS, STROKES, MARKS = 0.8, 1.4, 2.0, 2.6, 3.2


def compose_explorer(
    state: ExplorerState, width: float, height: float, cache: LayerCache | None = None
) -> Drawn:
    """Compose the picture of a given size in points; cache: of the last picture of this state."""
    frame = Frame.of(state.camera, width, height)
    placed = None if state.hiding else state.finder.placed
    # What was found before the boundary changed stays in sight until there is something new.
    former = None if state.hiding or placed is not None else state.exploration.former
    net = placed.net if placed is not None else None if former is None else former.net
    composer = _Composer(state, net, LayerCache() if cache is None else cache)
    composer.add_surface()
    if net is not None:
        composer.add_net(net, faded=former is not None)
    if former is not None:
        net = None
    composer.add_boundary(net)
    for number, stroke in enumerate(state.finder.strokes):
        if stroke.points is not None:
            look = composer.look(style.STROKE, STROKE_WIDTH, STROKES)
            composer.add_line(f"stroke {number}", stroke.points, look, closed=stroke.is_loop)
    if net is not None:
        for strip, colour in zip(state.strips_under(), style.STRANDS, strict=False):
            rim = composer.look(style.PAPER, STRAND_WIDTH + 1.8, STROKES)
            composer.add_line(f"strip rim {colour}", strip, rim)
            look = composer.look(colour, STRAND_WIDTH, STROKES + STRAND_WIDTH)
            composer.add_line(f"strip {colour}", strip, look)
        composer.add_markers(net)
    composer.add_in_progress()
    composer.write_labels(frame.scene, frame.middle)
    return frame.drawn(composer.layers)


class _Composer:
    """Makes layers of what the explorer shows."""

    def __init__(self, state: ExplorerState, net: Net | None, cache: LayerCache) -> None:
        self.state, self.cache = state, cache
        self.layers: list[Layer] = []
        self.lift = Lift(LIFT[0], 0.0 if net is None else LIFT[1] * net.edge)

    def look(self, colour: str, width: float, above: float) -> LineLook:
        """Return a look of lines, this many points above the fill."""
        return LineLook(colour, width, self.lift.above(above))

    def add_surface(self) -> None:
        """Add the surface, if there is one."""
        surface = self.state.surface
        if surface is not None:
            self.layers.append(
                self.cache.get(
                    "surface",
                    (surface,),
                    lambda: Faces(
                        "surface",
                        surface.vertices,
                        surface.triangles,
                        SURFACE,
                        normals=surface.normals,
                        back=SURFACE_BACK,
                    ),
                )
            )

    def add_net(self, net: Net, *, faded: bool) -> None:
        """Add the quads of a fill and their edges."""
        edge = net.edge * self.state.camera.view.scale
        width = float(np.clip(edge * LINE[0], *LINE[1:]))
        look = self.look(FADED if faded else style.EDGE, width, LINES)

        def make() -> list[Layer]:
            base = np.tile(style.parse_colour(FORMER if faded else QUADS), (len(net.patches), 1))
            if not faded:
                base[net.carried] = style.parse_colour(CARRIED)
            faces = _cut_patches(net.patches)
            each = np.repeat(base, len(faces) // max(len(base), 1), axis=0)
            points, normals = net.patches.reshape(-1, 3), net.normals.reshape(-1, 3)
            return [
                Faces("quads", points, faces, face_colours=each, normals=normals, lift=self.lift),
                Curves.of("edges", list(net.edges), look),
            ]

        self.layers += self.cache.get("net", (net, faded, width, self.lift), make)

    def add_markers(self, net: Net) -> None:
        """Add irregular vertices, as everywhere in the viewer, and odd ones on the boundary."""
        edge = net.edge * self.state.camera.view.scale
        radius, lift = float(np.clip(edge * MARKER[0], *MARKER[1:])), self.lift.above(MARKS)
        self.layers.append(make_discs("odd", net.odd, style.SELECTED, 1.2 * radius, lift))
        inner = lift.above(0.4)
        self.layers.append(make_discs("odd inner", net.odd, style.PAPER, 0.72 * radius, inner))
        self.layers += make_valence_marks("valences", net.irregular, net.valences, radius, lift)

    def add_boundary(self, net: Net | None) -> None:
        """Add the boundary's sides, its vertices and its corners."""
        contour, boundary = self.state.contour, self.state.finder.boundary
        if contour is None:
            return
        meant = self.state.meant_side
        chosen = self.state.side_under() if meant is None else meant
        ticks = None if boundary is None else boundary.points
        if boundary is not None and ticks is not None:
            edges = self._lay_ring(ticks) if net is None else net.border
            sides = [edges[a:b].reshape(-1, 3) for a, b in pairwise(boundary.side_starts)]
        else:
            sides = [self._along(side) for side in contour.sides]
        for i, side in enumerate(sides):
            colour = style.SELECTED if i == chosen else style.BOUNDARY
            look = self.look(colour, BOUNDARY_WIDTH, LINES)
            self.layers.append(Curves.of(f"side {i}", [side], look))
        if ticks is not None:
            lift, radius = self.lift.above(TICKS), 0.95 * BOUNDARY_WIDTH
            self.layers.append(make_discs("ticks", ticks, style.BOUNDARY, radius, lift))
        self._add_corners()

    def add_line(self, name: str, points: Points, look: LineLook, *, closed: bool = False) -> None:
        """Add a polyline (k, 3), laid on the base between its points."""
        if closed:
            points = np.concatenate([points, points[:1]])
        self.layers.append(Curves.of(name, [self._along(points)], look))

    def add_in_progress(self) -> None:
        """Add what is being drawn."""
        state = self.state
        look = self.look(style.BOUNDARY, BOUNDARY_WIDTH, STROKES)
        for number, path in enumerate(state.pen.paths):
            self.add_line(f"path {number}", path, look)
        if state.pen.preview is not None:
            look = self.look(PREVIEW, 0.6 * BOUNDARY_WIDTH, STROKES)
            self.add_line("preview", state.pen.preview, look)
        if state.pen.clicked:
            at, lift = np.stack(state.pen.clicked), self.lift.above(MARKS)
            self.layers.append(make_discs("clicked", at, style.BOUNDARY, 5.0, lift))
        if len(state.pen.line) > 1:
            look = self.look(style.STROKE, STROKE_WIDTH, STROKES)
            closed = state.mode is PointerMode.LOOP
            self.add_line("drawn", np.stack(state.pen.line), look, closed=closed)

    def _add_corners(self) -> None:
        """Convex corners are discs, reflex ones diamonds; the one at the pointer has a halo."""
        contour = self.state.contour
        if contour is None or not contour.corners:
            return
        places = np.stack([side[0] for side in contour.sides])
        chosen, lift = self.state.corner_under(), self.lift.above(CORNERS)
        if chosen is not None:
            at = places[chosen : chosen + 1]
            self.layers.append(make_discs("corner halo", at, style.SELECTED, 10.0, lift))
        kinds = np.array(contour.corners)
        for name, kind, outline, colour, above in (
            ("convex", "convex", style.make_circle() * 5.8, style.BOUNDARY, 0.3),
            ("reflex rim", "reflex", style.make_diamond() * 9.4, style.BOUNDARY, 0.3),
            ("reflex", "reflex", style.make_diamond() * 5.6, style.PAPER, 0.6),
        ):
            at = places[kinds == kind]
            self.layers.append(Marks(name, at, outline, colour, lift.above(above)))

    def write_labels(self, scene: Scene, middle: tuple[float, float]) -> None:
        """Write the edge count of every side, beside its middle, outside; where it is seen."""
        contour, view = self.state.contour, self.state.camera.view
        if contour is None:
            return
        around = view.seen(np.concatenate(contour.sides))[:, :2]
        after = np.roll(around, -1, axis=0)
        area = float((around[:, 0] * after[:, 1] - around[:, 1] * after[:, 0]).sum())
        for side, length in zip(contour.sides, contour.lengths, strict=True):
            line = self._along(side)
            at = len(line) // 2
            if not self._is_seen(line[at]):
                continue
            seen = view.seen(line)[:, :2] + middle
            along = seen[min(at + 1, len(seen) - 1)] - seen[max(at - 1, 0)]
            size = float(np.hypot(*along))
            if size == 0.0:
                continue
            out = np.array([along[1], -along[0]]) / size * (1.0 if area > 0.0 else -1.0)
            x, y = seen[at] + LABEL * out
            scene.number(x, y, length, 13.0, LABEL_RIM, 1.0, bold=True)

    def _is_seen(self, point: Points) -> bool:
        """Is a point (3,) in the picture, and not behind the surface?"""
        camera, surface = self.state.camera, self.state.surface
        x, y, _ = np.abs(camera.view.seen(point)).tolist()
        if x > camera.room[0] / 2.0 or y > camera.room[1] / 2.0:
            return False
        return surface is None or bool(find_visible(camera.view, surface, point[None])[0])

    def _lay_ring(self, points: Points) -> Points:
        """(P, PIECES + 1, 3) the edges of a closed polygon (P, 3), laid on the base."""
        t = np.linspace(0.0, 1.0, PIECES + 1)[None, :, None]
        edges = points[:, None] * (1.0 - t) + np.roll(points, -1, axis=0)[:, None] * t
        if self.state.surface is None:
            return edges
        return self.state.base.on(edges.reshape(-1, 3))[0].reshape(edges.shape)

    def _along(self, points: Points) -> Points:
        """A polyline (k, 3) cut fine and laid on the base."""
        t = (np.arange(PIECES) / PIECES)[None, :, None]
        a, b = points[:-1, None], points[1:, None]
        fine = np.concatenate([(a + (b - a) * t).reshape(-1, 3), points[-1:]])
        return fine if self.state.surface is None else self.state.base.on(fine)[0]


def _cut_patches(patches: Points) -> NDArray[np.int64]:
    """(q * 2 (n - 1)**2, 3) triangles of patches (q, n, n, 3), those of a patch together."""
    number = np.arange(patches[..., 0].size).reshape(patches.shape[:3])
    a, b = number[:, :-1, :-1], number[:, 1:, :-1]
    c, d = number[:, 1:, 1:], number[:, :-1, 1:]
    both = np.stack([np.stack([a, b, c], axis=3), np.stack([a, c, d], axis=3)], axis=3)
    return both.reshape(-1, 3)


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
