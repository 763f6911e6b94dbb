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
from viewer.picture import Drawn, check_png, save_drawn
from viewer.retopo.marks import choose_valence_colour, make_shapes
from viewer.scene import Scene
from viewer.skin import MATTE, Skin, shade_model
from viewer.solid import Solid, Triangles, make_ribbons

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
    path = check_png(path)
    rows = -(-len(panels) // columns)
    scene = Scene(columns * HALF, rows * (HALF + CAPTION))
    scene.box(0.0, 0.0, 0.0, 0.0, style.PAPER, style.PAPER)
    parts: list[Triangles] = []
    for number, panel in enumerate(panels):
        left = number % columns * HALF
        low = (rows - 1 - number // columns) * (HALF + CAPTION)
        middle = np.array([left + HALF / 2, low + CAPTION + HALF / 2, 0.0])
        drawn = [
            *_draw_mesh(panel.mesh, panel.marked, panel.tint, panel.edge, view),
            make_ribbons([view.seen(line) for line in panel.loops], LOOP, LOOP_WIDTH, LOOP_LIFT),
            *_draw_irregular(panel.fills, view),
        ]
        parts += _cut_panel([(part[0] + middle, part[1]) for part in drawn], left, low)
        scene.text(left + HALF / 2, low + CAPTION / 3, panel.caption, 13.0)
    solid = Solid(
        np.concatenate([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts]),
        0.0,
    )
    return save_drawn(path, Drawn(scene, solid, (scene.width / 2, scene.height / 2)), height)


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
            shape = style.choose_valence_shape(int(np.clip(valence, 2, 7)))
            parts.append(make_shapes(places, shape * (radius + 1.0), style.PAPER, MARKER_LIFT))
            colour = choose_valence_colour(valence)
            parts.append(make_shapes(places, shape * radius, colour, MARKER_LIFT + 0.4))
    return parts


def _cut_panel(parts: Sequence[Triangles], left: float, low: float) -> list[Triangles]:
    """What lies within a panel; triangles that reach out of it are cut off."""
    kept: list[Triangles] = []
    for part in parts:
        for axis, least in ((0, left), (1, low + CAPTION)):
            part = _cut_triangles(part, axis, least, 1.0)
            part = _cut_triangles(part, axis, least + HALF, -1.0)
        kept.append(part)
    return kept


def _cut_triangles(part: Triangles, axis: int, limit: float, sign: float) -> Triangles:
    """Cut triangles off where a coordinate is beyond a limit; sign: 1 keeps the greater."""
    corners, colours = part
    depth = sign * (corners[..., axis] - limit)
    inside = depth >= 0.0
    count = inside.sum(axis=1)
    pieces: list[Triangles] = [(corners[count == 3], colours[count == 3])]
    for wanted in (1, 2):
        chosen = count == wanted
        odd = np.argmax(inside[chosen] == (wanted == 1), axis=1)  # the corner on a side of its own
        order = (odd[:, None] + np.arange(3)) % 3
        d = np.take_along_axis(depth[chosen], order, axis=1)
        p = np.take_along_axis(corners[chosen], order[..., None], axis=1)
        c = np.take_along_axis(colours[chosen], order[..., None], axis=1)
        share = d[:, :1] / (d[:, :1] - d[:, 1:])  # of the way from the odd corner to the others
        cut_p = p[:, :1] + share[..., None] * (p[:, 1:] - p[:, :1])
        cut_c = c[:, :1] + share[..., None] * (c[:, 1:] - c[:, :1])
        cut_c = cut_c.astype(np.float32)
        if wanted == 1:
            pieces.append((np.concatenate([p[:, :1], cut_p], axis=1), np.hstack([c[:, :1], cut_c])))
        else:
            for places in ([0, 2, 3], [0, 3, 1]):  # of cut, cut, corner, corner
                both_p, both_c = np.hstack([cut_p, p[:, 1:]]), np.hstack([cut_c, c[:, 1:]])
                pieces.append((both_p[:, places], both_c[:, places]))
    return np.concatenate([one[0] for one in pieces]), np.concatenate([one[1] for one in pieces])
