"""A picture of holes and their fills: the mesh before, and after, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from query.holes import HoleFill, weld_fills
from viewer import style
from viewer.camera import View, fit_view
from viewer.picture import Drawn, Frame, save_sheet
from viewer.retopo.marks import make_valence_marks
from viewer.scene import Scene
from viewer.skin import MATTE, Skin, shade_model
from viewer.solid import Triangles, make_ribbons

#: Width and height of each half, and of the line of text below, in points.
HALF, CAPTION = 440.0, 26.0

#: Colours of the faces that are made anew, of new quads, of their edges, and of the loop.
REMOVED, NEW, NEW_EDGE, LOOP = "#f6c08a", "#9cc3e6", "#1f4e79", "#d55e00"

#: Widths in points of the edges of old faces, of new ones, and of the loop.
OLD_WIDTH, NEW_WIDTH, LOOP_WIDTH = 0.7, 1.3, 3.0

#: Radius of an irregular vertex's marker in edges of the loop, least and most in points.
MARKER = (0.16, 2.4, 6.5)

#: What is looked at of the surroundings: so many times the size of a lone hole.
ROOM = 2.2

#: How much nearer than they are lines, the loop and markers are drawn, in points.
LINE_LIFT, LOOP_LIFT, MARKER_LIFT = 1.6, 3.0, 4.4


@dataclass(frozen=True, slots=True, eq=False)
class HolePanel:
    """One mesh of a picture, with a line of text below.

    marked: (f,) bool, faces in the colours ``tint`` and, of their edges, ``edge``. loops: polylines
    (k, 3) to be drawn over the mesh. fills: whose irregular vertices are marked.
    """

    mesh: PolygonMesh
    marked: NDArray[np.bool_]
    tint: str
    edge: str
    caption: str
    loops: Sequence[Points] = ()
    fills: Sequence[HoleFill] = ()


def draw_holes(path: Path | str, fills: Sequence[HoleFill], height: int = 900) -> Path:
    """Draw a mesh before and after its holes are filled, as a PNG.

    One hole is looked at from where its fill faces, from near by; several with the whole mesh.
    Irregular vertices of a fill and its loop are marked by the colour and shape of their valence.
    Raises PictureFormatError for another suffix than .png, and OSError as writing does.
    """
    before = "the hole" if len(fills) == 1 else f"{len(fills)} holes"
    edges = sum(len(fill.hole) for fill in fills)
    panels = [show_holes(fills, f"{before}, {edges} edges around"), show_fills(fills)]
    return draw_panels(path, panels, choose_view(fills), len(panels), height)


def show_holes(fills: Sequence[HoleFill], caption: str) -> HolePanel:
    """Show a mesh as it was, faces that are replaced in a colour of their own."""
    mesh = fills[0].hole.topology.mesh
    closed = [np.concatenate([f.hole.points, f.hole.points[:1]]) for f in fills]
    return HolePanel(mesh, _find_removed(fills), REMOVED, style.EDGE, caption, closed)


def show_fills(fills: Sequence[HoleFill], caption: str = "") -> HolePanel:
    """Show a mesh with its holes filled."""
    old, new = fills[0].hole.topology.mesh, weld_fills(fills)
    added = np.arange(new.n_faces) >= old.n_faces - int(_find_removed(fills).sum())
    quads = sum(fill.n_quads for fill in fills)
    twin = ", a mirror twin" if len(fills) == 1 and fills[0].twin else ""
    return HolePanel(new, added, NEW, NEW_EDGE, caption or f"{quads} quads{twin}", (), fills)


def draw_panels(
    path: Path | str, panels: Sequence[HolePanel], view: View, columns: int, height: int = 900
) -> Path:
    """Draw panels row by row, all looked at alike, as a PNG of this height."""
    rows = -(-len(panels) // columns)
    sheet = [_draw_panel(panel, view) for panel in panels]
    return save_sheet(path, sheet, round(height / rows), columns)


def _draw_panel(panel: HolePanel, view: View) -> Drawn:
    """Draw one panel; what reaches out of it below is hidden by its text."""
    frame = Frame(Scene(HALF, HALF + CAPTION), (HALF / 2, CAPTION + HALF / 2))
    frame.scene.box(0.0, 0.0, HALF, CAPTION, style.PAPER, style.PAPER)
    frame.scene.text(HALF / 2, CAPTION / 3, panel.caption, 13.0)
    parts = [
        *_draw_mesh(panel.mesh, panel.marked, panel.tint, panel.edge, view),
        make_ribbons([view.seen(line) for line in panel.loops], LOOP, LOOP_WIDTH, LOOP_LIFT),
        *_draw_irregular(panel.fills, view),
    ]
    return frame.drawn(frame.solid(parts))


def _find_removed(fills: Sequence[HoleFill]) -> NDArray[np.bool_]:
    """(f,) bool, old faces that the fills replace."""
    removed = np.zeros(fills[0].hole.topology.mesh.n_faces, np.bool_)
    for fill in fills:
        removed[fill.hole.removed] = True
    return removed


def choose_view(fills: Sequence[HoleFill]) -> View:
    """Look at the fills from where they face."""
    normal = np.zeros(3)
    for fill in fills:
        around = fill.hole.points - fill.hole.points.mean(axis=0)
        normal += np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(normal))
    toward = normal / size if size > 0 else np.array([0.3, 0.4, 1.0])
    # A little from above and from the side, so that what is round looks round.
    toward = toward + np.array([0.18, 0.25, 0.12])
    up = np.array([0.0, 1.0, 0.0])
    if abs(up @ toward) > 0.9 * np.linalg.norm(toward):
        up = np.array([0.0, 0.0, 1.0])
    if len(fills) > 1:
        mesh = fills[0].hole.topology.mesh
        return fit_view(mesh.points[np.unique(mesh.corners)], toward, up, HALF, HALF)
    loop = fills[0].hole.points
    centre = loop.mean(axis=0)
    radius = float(np.linalg.norm(loop - centre, axis=1).max())
    ball = centre + ROOM * radius * np.concatenate([np.eye(3), -np.eye(3)])
    return fit_view(ball, toward, up, HALF, HALF)


def _draw_mesh(
    mesh: PolygonMesh, marked: NDArray[np.bool_], tint: str, edge: str, view: View
) -> list[Triangles]:
    """Faces, the marked ones tinted, and their edges."""
    arity = mesh.arities()
    face = np.repeat(np.arange(mesh.n_faces), np.maximum(arity - 2, 0))
    within = np.arange(len(face)) - np.repeat(
        np.cumsum(np.maximum(arity - 2, 0)) - np.maximum(arity - 2, 0), np.maximum(arity - 2, 0)
    )
    first = mesh.offsets[face]
    triangles = mesh.corners[np.stack([first, first + within + 1, first + within + 2], axis=1)]
    skin = Skin.of(mesh.points[triangles], triangles.astype(np.int32))
    seen, bright = shade_model(skin, view, (0.0, 0.0), through=False)
    colours = np.where(
        marked[face][:, None, None],
        bright / style.parse_colour(MATTE) * style.parse_colour(tint),
        bright,
    )
    parts: list[Triangles] = [(seen, np.minimum(colours, 1.0).astype(np.float32))]
    at = np.arange(len(mesh.corners))
    owner = np.repeat(np.arange(mesh.n_faces), arity)
    following = np.where(at == mesh.offsets[owner + 1] - 1, mesh.offsets[owner], at + 1)
    ends = np.sort(np.stack([mesh.corners, mesh.corners[following]], axis=1), axis=1)
    for chosen, colour, width, lift in (
        (~marked[owner], style.EDGE, OLD_WIDTH, LINE_LIFT),
        (marked[owner], edge, NEW_WIDTH, LINE_LIFT + 0.4),
    ):
        lines = view.seen(mesh.points[np.unique(ends[chosen], axis=0)])
        parts.append(make_ribbons(list(lines), colour, width, lift))
    return parts


def _draw_irregular(fills: Sequence[HoleFill], view: View) -> list[Triangles]:
    """Markers of the irregular vertices in fills and on their loops."""
    parts: list[Triangles] = []
    for fill in fills:
        n = len(fill.hole)
        edge = fill.hole.length / n * view.scale
        radius = float(np.clip(MARKER[0] * edge, *MARKER[1:]))
        points = np.concatenate([fill.hole.points, fill.points])
        valences = fill.valences
        for valence in sorted({int(v) for v in valences.tolist()} - {4, 0}):
            places = view.seen(points[valences == valence])
            parts += make_valence_marks(places, valence, radius, MARKER_LIFT)
    return parts
