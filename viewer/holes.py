"""A picture of holes and their fills: the mesh before, and after, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.surface import Surface
from patterndb.geometry.triangulation import cut_faces
from query.holes import HoleFill, weld_fills
from viewer import style
from viewer.camera import View, fit_view
from viewer.picture import save_sheet
from viewer.scene import Scene
from viewer.stage import MATTE, Curves, Drawn, Faces, Layer, Lift, LineLook, make_valence_marks

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

#: From how far beside where a fill faces it is looked at, and how many other directions are tried.
ASIDE, DIRECTIONS = np.array([0.18, 0.25, 0.12]), 200

#: From where it faces it is looked at if so much of the most is seen; faces are left out where less
#: than HIDDEN of it is; at the same place is what lies within OFF of its size.
CLEARLY, HIDDEN, OFF = 0.75, 0.6, 1e-3

#: How much nearer than they are lines, the loop and markers are drawn.
LINE_LIFT, LOOP_LIFT, MARKER_LIFT = Lift(1.0), Lift(3.0), Lift(4.4)


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
    view = choose_view(fills)
    front = find_front(fills, view)
    cut = f"; {int(front.sum())} faces before it left out" if front.any() else ""
    panels = [
        show_holes(fills, f"{before}, {edges} edges around{cut}", front),
        show_fills(fills, front=front),
    ]
    return draw_panels(path, panels, view, len(panels), height)


def show_holes(
    fills: Sequence[HoleFill], caption: str, front: NDArray[np.bool_] | None = None
) -> HolePanel:
    """Show a mesh as it was, faces that are replaced in a colour of their own.

    front: (f,) bool, faces that are left out.
    """
    mesh, removed = fills[0].hole.topology.mesh, _find_removed(fills)
    stays = np.ones(mesh.n_faces, np.bool_) if front is None else ~front
    closed = [np.concatenate([f.hole.points, f.hole.points[:1]]) for f in fills]
    part = _keep_faces(mesh, stays)
    return HolePanel(part, removed[stays], REMOVED, style.EDGE, caption, closed)


def show_fills(
    fills: Sequence[HoleFill], caption: str = "", front: NDArray[np.bool_] | None = None
) -> HolePanel:
    """Show a mesh with its holes filled; front: as of :func:`show_holes`."""
    new, faces = weld_fills(fills), sum(fill.n_faces for fill in fills)
    stays = np.ones(new.n_faces, np.bool_)
    if front is not None:
        stays[: new.n_faces - faces] = ~front[~_find_removed(fills)]
    added = np.arange(new.n_faces) >= new.n_faces - faces
    twin = ", a mirror twin" if len(fills) == 1 and fills[0].twin else ""
    kind = "quads" if all(fill.ngon is None for fill in fills) else "faces"
    caption = caption or f"{faces} {kind}{twin}"
    part = _keep_faces(new, stays)
    return HolePanel(part, added[stays], NEW, NEW_EDGE, caption, (), fills)


def _keep_faces(mesh: PolygonMesh, stays: NDArray[np.bool_]) -> PolygonMesh:
    arity = mesh.arities()
    offsets = np.concatenate([[0], np.cumsum(arity[stays])]).astype(np.int64)
    return PolygonMesh(mesh.points, mesh.corners[np.repeat(stays, arity)], offsets)


def draw_panels(
    path: Path | str, panels: Sequence[HolePanel], view: View, columns: int, height: int = 900
) -> Path:
    """Draw panels row by row, all looked at alike, as a PNG of this height."""
    rows = -(-len(panels) // columns)
    sheet = [_draw_panel(panel, view) for panel in panels]
    return save_sheet(path, sheet, round(height / rows), columns)


def _draw_panel(panel: HolePanel, view: View) -> Drawn:
    """Draw one panel; what reaches out of it below is hidden by its text."""
    scene = Scene(HALF, HALF + CAPTION)
    scene.box(0.0, 0.0, HALF, CAPTION, style.PAPER, style.PAPER)
    scene.text(HALF / 2, CAPTION / 3, panel.caption, 13.0)
    layers = [
        *make_mesh_layers(panel.mesh, panel.marked, panel.tint, panel.edge),
        Curves.of("loops", panel.loops, LineLook(LOOP, LOOP_WIDTH, LOOP_LIFT)),
        *make_irregular_marks(panel.fills, view),
    ]
    return Drawn(scene, layers, view, (HALF / 2, CAPTION + HALF / 2))


def _find_removed(fills: Sequence[HoleFill]) -> NDArray[np.bool_]:
    """(f,) bool, old faces that the fills replace."""
    removed = np.zeros(fills[0].hole.topology.mesh.n_faces, np.bool_)
    for fill in fills:
        removed[fill.hole.removed] = True
    return removed


def choose_view(fills: Sequence[HoleFill]) -> View:
    """Look at the fills from where most of them is seen, and nothing of the mesh lies before them:
    from where they face, unless they are clearly better seen from elsewhere."""
    normal = np.zeros(3)
    for fill in fills:
        around = fill.hole.points - fill.hole.points.mean(axis=0)
        normal += np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(normal))
    toward = normal / size if size > 0 else np.array([0.3, 0.4, 1.0])
    # A little from above and from the side, so that what is round looks round.
    directions = np.concatenate([units((toward + ASIDE)[None]), spread_directions(DIRECTIONS)])
    seen = _Seen.of(fills).measure(directions)
    toward = directions[0 if seen[0] >= CLEARLY * seen.max() else int(seen.argmax())]
    up = np.array([0.0, 1.0, 0.0])
    if abs(up @ toward) > 0.9:
        up = np.array([0.0, 0.0, 1.0])
    if len(fills) > 1:
        mesh = fills[0].hole.topology.mesh
        return fit_view(mesh.points[np.unique(mesh.corners)], toward, up, HALF, HALF)
    loop = fills[0].hole.points
    centre = loop.mean(axis=0)
    radius = float(np.linalg.norm(loop - centre, axis=1).max())
    ball = centre + ROOM * radius * np.concatenate([np.eye(3), -np.eye(3)])
    return fit_view(ball, toward, up, HALF, HALF)


def find_front(fills: Sequence[HoleFill], view: View) -> NDArray[np.bool_]:
    """(f,) bool, old faces that lie before the fills; none where most of them is seen anyway."""
    return _Seen.of(fills).find_front(view.axes[2])


def spread_directions(count: int) -> Points:
    """Spread (count, 3) directions evenly over a sphere, along a spiral of golden angles."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """What can be seen of fills in their mesh.

    mesh: after they were filled, as triangles. face: (t,) of each; faces from ``first`` on are the
    fills'. middles, areas: (k, 3) and (k, 3), of the fills' triangles.
    """

    mesh: Surface
    face: NDArray[np.int64]
    first: int
    removed: NDArray[np.bool_]
    middles: Points
    areas: Points

    @classmethod
    def of(cls, fills: Sequence[HoleFill]) -> _Seen:
        welded = weld_fills(fills)
        triangles, face = cut_faces(welded)
        mesh = Surface(welded.points, triangles)
        first = welded.n_faces - sum(fill.n_faces for fill in fills)
        own = mesh.corners[face >= first]
        areas = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0]) / 2.0
        return cls(mesh, face, first, _find_removed(fills), own.mean(axis=1), areas)

    def measure(self, directions: Points) -> Floats:
        """(d,) the area of the fills that is seen from each direction (d, 3), as it looks there."""
        shown = np.abs(directions @ self.areas.T)
        return (shown * ~self._is_hidden(directions)).sum(axis=1)

    def _is_hidden(self, directions: Points) -> NDArray[np.bool_]:
        """(d, k) bool, does something lie before the fills' triangles?"""
        d, k = len(directions), len(self.middles)
        rays = np.repeat(directions, k, axis=0)
        # Off the triangle that the ray begins on.
        origins = np.tile(self.middles, (d, 1)) + self._off * rays
        return self.mesh.cast_rays(origins, rays).found.reshape(d, k)

    @property
    def _off(self) -> float:
        """What is no nearer than this is at the same place."""
        return OFF * float(np.sqrt(np.linalg.norm(self.areas, axis=1).sum()))

    def find_front(self, toward: Points) -> NDArray[np.bool_]:
        """(f,) bool, the faces of the mesh before it was filled that hide the fills from a
        direction (3,), if they hide much."""
        front = np.zeros(self.first, np.bool_)
        shown = np.abs(self.areas @ toward)
        if self.measure(toward[None])[0] < HIDDEN * shown.sum():
            # What rays from the fills meet, and whose corners have the fills behind them: the
            # faces of the one may be far larger, and far smaller, than those of the other.
            own = self.face >= self.first
            starts = self.middles + self._off * toward
            lines = np.broadcast_to(toward, starts.shape)
            _, hits = self.mesh.cast_lines(starts, lines)
            hit = hits.triangles
            front[self.face[hit[(hits.distances > 0.0) & ~own[hit]]]] = True
            behind = Surface.from_corners(self.mesh.corners[own])
            corners = self.mesh.corners[~own].reshape(-1, 3)
            rays = np.broadcast_to(-toward, corners.shape)
            away = behind.cast_rays(corners, rays).distances.reshape(-1, 3)
            hides = ((away > self._off) & (away < np.inf)).any(axis=1)
            front[self.face[~own][hides]] = True
        result = np.zeros(len(self.removed), np.bool_)
        result[~self.removed] = front
        return result


def make_mesh_layers(
    mesh: PolygonMesh, marked: NDArray[np.bool_], tint: str, edge: str
) -> list[Layer]:
    """Make the layers of a mesh: its faces, marked ones (f,) tinted, and their edges."""
    triangles, face = cut_faces(mesh)
    at = np.arange(len(mesh.corners))
    owner = np.repeat(np.arange(mesh.n_faces), mesh.arities())
    following = np.where(at == mesh.offsets[owner + 1] - 1, mesh.offsets[owner], at + 1)
    ends = np.sort(np.stack([mesh.corners, mesh.corners[following]], axis=1), axis=1)
    colours = np.where(marked[face][:, None], style.parse_colour(tint), style.parse_colour(MATTE))
    layers: list[Layer] = [Faces("mesh", mesh.points, triangles, face_colours=colours)]
    for name, chosen, colour, width, lift in (
        ("edges", ~marked[owner], style.EDGE, OLD_WIDTH, LINE_LIFT),
        ("marked edges", marked[owner], edge, NEW_WIDTH, LINE_LIFT.above(0.4)),
    ):
        pairs = mesh.points[np.unique(ends[chosen], axis=0)]
        look = LineLook(colour, width, lift)
        layers.append(Curves(name, pairs.reshape(-1, 3), (2,) * len(pairs), look))
    return layers


def make_irregular_marks(fills: Sequence[HoleFill], view: View) -> list[Layer]:
    """Make markers of the irregular vertices in fills and on their loops."""
    layers: list[Layer] = []
    for number, fill in enumerate(fills):
        edge = fill.hole.length / len(fill.hole) * view.scale
        radius = float(np.clip(MARKER[0] * edge, *MARKER[1:]))
        points = np.concatenate([fill.hole.points, fill.points])
        odd = ~np.isin(fill.valences, (0, 4))
        name = f"valences {number}"
        layers += make_valence_marks(name, points[odd], fill.valences[odd], radius, MARKER_LIFT)
    return layers
