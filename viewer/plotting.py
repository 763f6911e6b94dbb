"""Meshes, holes, patterns, fills, networks, retopologies and shape models as pyvista objects.

:func:`to_pyvista` gives a mesh with its numbers as arrays, for pyvista's own filters;
:func:`plot` a plotter with the thing on it, drawn as windows and pictures draw it
(:mod:`viewer.stage`). The classes have both as methods.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.embedding import embed_disk
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface
from patterndb.system.extras import require_extra
from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.surfacing.patch import Surfacing
from query.fill import Fill
from query.holes import Hole, HoleFill, weld_fills
from viewer import style
from viewer.camera import StageLook, View, fit_view
from viewer.holes import LOOP, REMOVED, make_irregular_marks, make_mesh_layers, show_fills
from viewer.picture import check_rendering, has_display
from viewer.scene import Scene
from viewer.stage import (
    Curves,
    Drawn,
    Faces,
    Layer,
    LayerStage,
    Lift,
    LineLook,
    Marks,
    make_discs,
    make_valence_marks,
)

if TYPE_CHECKING:
    from pyvista import Plotter as Plotter
    from pyvista import PolyData as PolyData

#: What both functions need of the extra ``viewer``.
PACKAGES = ("vtkmodules", "pyvista")

#: From where things are looked at, and what is upright.
TOWARD, UP = (0.5, 0.45, 1.0), (0.0, 1.0, 0.0)

#: Widths of curves and edges, radii of marks, in points.
CURVE, EDGE, RADIUS, NODE = 3.0, 1.0, 5.0, 4.0

#: Pixels of a plotter that is made here, and samples of each.
SIZE, SAMPLES = (1000, 750), 8


@singledispatch
def to_pyvista(thing: object) -> PolyData:
    """Return a thing as a mesh of pyvista.

    A mesh of polygons keeps its faces; quads have the array "valence" at their vertices. The other
    arrays: fills and patterns "side" (of boundary vertices, else -1), filled holes "new" (faces of
    the fill), networks "curve", surfaced networks and retopologies "patch", shape models "mode 1"
    and so on: by how much a standard deviation of that mode moves each vertex.

    Raises MissingExtraError without pyvista, and TypeError for anything else.
    """
    raise TypeError(f"{type(thing).__name__} cannot be shown by pyvista")


@singledispatch
def list_layers(thing: object, view: View) -> list[Layer]:
    """List the layers that show a thing, seen from a view at first."""
    raise TypeError(f"{type(thing).__name__} cannot be shown by pyvista")


@dataclass(frozen=True, slots=True)
class PlotOptions:
    """How a thing is plotted.

    shading: "studio" (lights from both sides), "matcap" (clay) or "flat" (each face by itself).
    wire: only the edges of triangles. x_ray: the faces can be seen through. sharp: with the edges
    at which faces meet at an angle. perspective: else far things are as large as near ones. clip:
    (3,) the direction of a half that is cut away, through the middle of the thing. toward, up: (3,)
    from where it is looked at.
    """

    shading: str = "studio"
    wire: bool = False
    x_ray: bool = False
    sharp: bool = False
    perspective: bool = False
    clip: ArrayLike | None = None
    toward: ArrayLike = TOWARD
    up: ArrayLike = UP


def plot(
    thing: object,
    options: PlotOptions | None = None,
    *,
    plotter: Plotter | None = None,
    **choices: Any,
) -> Plotter:
    """Return a pyvista plotter with a thing on it: ``.show()`` opens a window, or shows it in a
    notebook; ``.screenshot(path)`` writes a picture, without a display, too.

    options, choices: see :class:`PlotOptions`; choices are its entries. plotter: one that has
    something on it already, to which this is added.

    Raises MissingExtraError without pyvista, PictureError where VTK could not draw, TypeError for
    anything that cannot be shown, and ValueError for a shading there is not.
    """
    require_extra("viewer", "plotting", PACKAGES)
    chosen = PlotOptions(**choices) if options is None else options
    points = _find_points(thing)
    width, height = (float(n) for n in (SIZE if plotter is None else plotter.window_size))
    view = fit_view(points, chosen.toward, chosen.up, width, height)
    layers = list_layers(thing, view)
    if chosen.sharp:
        layers += [_find_sharp(layer) for layer in layers if isinstance(layer, Faces)]
    clip = None
    if chosen.clip is not None:
        middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
        clip = (middle, units(np.asarray(chosen.clip, np.float64)[None])[0])
    look = StageLook(chosen.shading, chosen.wire, chosen.x_ray, chosen.perspective, clip)
    fresh = plotter is None
    check_rendering()
    plotter = _make_plotter() if plotter is None else plotter
    drawn = Drawn(Scene(width, height), layers, view, (width / 2.0, height / 2.0), look)
    LayerStage(plotter).follow(drawn, aim=fresh)
    return plotter


def _make_plotter() -> Plotter:
    """Make an empty plotter, off-screen where there is no display."""
    import pyvista as pv

    with pv.vtk_verbosity("off"):
        plotter: Any = pv.Plotter(
            off_screen=pv.OFF_SCREEN or not has_display(),
            window_size=list(SIZE),
            lighting="none",
        )
    plotter.set_background(style.PAPER)
    plotter.enable_anti_aliasing("msaa", multi_samples=SAMPLES)
    plotter.add_axes()
    return plotter


def _find_points(thing: object) -> Points:
    """(n, 3) what is fitted into the picture."""
    return np.asarray(to_pyvista(thing).points, np.float64)


def _find_sharp(layer: Faces) -> Curves:
    """Find the edges at which faces meet at an angle, and open ones."""
    import pyvista as pv

    mesh = pv.PolyData.from_regular_faces(layer.points, layer.faces).clean()
    found = mesh.extract_feature_edges(feature_angle=30.0)
    ends = found.points[found.lines.reshape(-1, 3)[:, 1:]].reshape(-1, 3)
    look = LineLook(style.BOUNDARY, 2.0, Lift(2.0))
    return Curves(f"{layer.name} sharp", np.asarray(ends), (2,) * (len(ends) // 2), look)


def _make_polydata(points: Points, faces: Sequence[NDArray[Any]]) -> PolyData:
    """Make a mesh; faces: (f, k) for every size k that faces have."""
    require_extra("viewer", "plotting", PACKAGES)
    import pyvista as pv

    rows = [np.insert(np.asarray(one, np.int64), 0, one.shape[1], axis=1).ravel() for one in faces]
    return pv.PolyData(np.asarray(points, np.float64), np.concatenate(rows))


def _make_quads(points: Points, quads: NDArray[Any]) -> PolyData:
    mesh = _make_polydata(points, [np.asarray(quads).reshape(-1, 4)])
    mesh.point_data["valence"] = _count_faces(quads, len(points))
    return mesh


def _count_faces(faces: NDArray[Any], n: int) -> NDArray[np.int64]:
    return np.bincount(np.asarray(faces, np.int64).ravel(), minlength=n)


def _find_pairs(faces: NDArray[Any]) -> NDArray[np.int64]:
    """(e, 2) the edges of faces (f, k), each once."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.unique(np.sort(ends, axis=1), axis=0).astype(np.int64)


def _make_edges(name: str, points: Points, pairs: NDArray[Any], look: LineLook) -> Curves:
    return Curves(name, points[pairs].reshape(-1, 3), (2,) * len(pairs), look)


# Meshes and surfaces


@to_pyvista.register(PolygonMesh)
def _(thing: PolygonMesh) -> PolyData:
    require_extra("viewer", "plotting", PACKAGES)
    import pyvista as pv

    arities = thing.arities()
    cells = np.insert(np.asarray(thing.corners, np.int64), thing.offsets[:-1], arities)
    mesh = pv.PolyData(np.asarray(thing.points, np.float64), cells)
    mesh.point_data["valence"] = _count_faces(thing.corners, len(thing.points))
    return mesh


@list_layers.register(PolygonMesh)
def _(thing: PolygonMesh, view: View) -> list[Layer]:
    none = np.zeros(thing.n_faces, np.bool_)
    return make_mesh_layers(thing, none, style.PAPER, style.EDGE)


@to_pyvista.register(Surface)
def _(thing: Surface) -> PolyData:
    return _make_polydata(thing.vertices, [thing.triangles])


@list_layers.register(Surface)
def _(thing: Surface, view: View) -> list[Layer]:
    return [Faces("surface", thing.vertices, thing.triangles)]


# Holes, and fills in them


@to_pyvista.register(Hole)
def _(thing: Hole) -> PolyData:
    require_extra("viewer", "plotting", PACKAGES)
    import pyvista as pv

    line = np.arange(len(thing) + 1) % len(thing)
    mesh = pv.PolyData(np.asarray(thing.points), lines=np.r_[len(line), line])
    mesh.point_data["vertex"] = np.asarray(thing.loop)
    return mesh


@list_layers.register(Hole)
def _(thing: Hole, view: View) -> list[Layer]:
    mesh = thing.topology.mesh
    removed = np.zeros(mesh.n_faces, np.bool_)
    removed[thing.removed] = True
    closed = np.concatenate([thing.points, thing.points[:1]])
    look = LineLook(LOOP, CURVE, Lift(3.0))
    layers = make_mesh_layers(mesh, removed, REMOVED, style.EDGE)
    return [*layers, Curves.of("loop", [closed], look)]


@to_pyvista.register(HoleFill)
def _(thing: HoleFill) -> PolyData:
    welded = weld_fills([thing])
    mesh = to_pyvista(welded)
    mesh.cell_data["new"] = np.arange(welded.n_faces) >= welded.n_faces - thing.n_faces
    return mesh


@list_layers.register(HoleFill)
def _(thing: HoleFill, view: View) -> list[Layer]:
    panel = show_fills([thing])
    return [
        *make_mesh_layers(panel.mesh, panel.marked, panel.tint, panel.edge),
        *make_irregular_marks([thing], view),
    ]


# Patterns and fills, flat


def _lay_flat(disk: Disk) -> Points:
    return np.pad(embed_disk(disk), ((0, 0), (0, 1)))


def _to_flat(disk: Disk, sides: Sequence[NDArray[Any]]) -> PolyData:
    mesh = _make_quads(_lay_flat(disk), disk.quads)
    side = np.full(disk.n_vertices, -1)
    for number, vertices in enumerate(sides):
        side[np.asarray(vertices)[:-1]] = number
    mesh.point_data["side"] = side
    return mesh


def _list_flat(disk: Disk) -> list[Layer]:
    points, quads = _lay_flat(disk), np.asarray(disk.quads)
    rim = np.arange(disk.perimeter)
    border = points[np.r_[rim, 0]]
    irregular = disk.irregular()
    counts = disk.corner_counts()
    convex, reflex = points[disk.corners[counts == 1]], points[disk.corners[counts > 2]]
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    valences = disk.valence()[irregular]
    return [
        Faces("quads", points, quads, style.QUAD, normals=up),
        _make_edges("edges", points, _find_pairs(quads), LineLook(style.EDGE, EDGE, Lift(1.5))),
        Curves.of("boundary", [border], LineLook(style.BOUNDARY, CURVE, Lift(3.0))),
        make_discs("convex", convex, style.BOUNDARY, NODE, Lift(4.0)),
        Marks("reflex", reflex, style.make_diamond() * 1.5 * NODE, style.BOUNDARY, Lift(4.0)),
        *make_valence_marks("valences", points[irregular], valences, RADIUS, Lift(5.0)),
    ]


def _list_sides(disk: Disk) -> list[NDArray[np.int64]]:
    """The vertices of each side of a disk, both ends included."""
    p = disk.perimeter
    corners = np.sort(np.asarray(disk.corners, np.int64))
    if not len(corners):
        return [np.arange(p + 1) % p]
    ends = np.r_[corners, corners[0] + p]
    return [np.arange(a, b + 1) % p for a, b in pairwise(ends)]


@to_pyvista.register(Pattern)
def _(thing: Pattern) -> PolyData:
    disk = thing.disk()
    return _to_flat(disk, _list_sides(disk))


@list_layers.register(Pattern)
def _(thing: Pattern, view: View) -> list[Layer]:
    return _list_flat(thing.disk())


@to_pyvista.register(Fill)
def _(thing: Fill) -> PolyData:
    return _to_flat(thing.disk(), thing.sides())


@list_layers.register(Fill)
def _(thing: Fill, view: View) -> list[Layer]:
    return _list_flat(thing.disk())


# Networks, and their surfaces


@to_pyvista.register(CurveNetwork)
def _(thing: CurveNetwork) -> PolyData:
    require_extra("viewer", "plotting", PACKAGES)
    import pyvista as pv

    lines = [curve.points for curve in thing.curves]
    sizes = [len(line) for line in lines]
    starts = np.cumsum([0, *sizes])
    cells = [np.r_[n, np.arange(n) + a] for n, a in zip(sizes, starts, strict=False)]
    if not cells:
        return pv.PolyData(np.asarray(thing.nodes))
    mesh = pv.PolyData(np.concatenate(lines), lines=np.concatenate(cells))
    mesh.cell_data["curve"] = np.arange(len(lines))
    return mesh


@list_layers.register(CurveNetwork)
def _(thing: CurveNetwork, view: View) -> list[Layer]:
    lines = [curve.points for curve in thing.curves]
    return [
        Curves.of("curves", lines, LineLook(style.BOUNDARY, CURVE, Lift(4.5))),
        make_discs("nodes", np.asarray(thing.nodes), style.BOUNDARY, NODE, Lift(6.0)),
    ]


@to_pyvista.register(Surfacing)
def _(thing: Surfacing) -> PolyData:
    pieces = [piece for patch in thing.patches for piece in patch.faces]
    owner = [n for n, patch in enumerate(thing.patches) for piece in patch.faces for _ in piece]
    mesh = _make_polydata(thing.points, pieces)
    mesh.cell_data["patch"] = np.array(owner)
    return mesh


@list_layers.register(Surfacing)
def _(thing: Surfacing, view: View) -> list[Layer]:
    from patterndb_sketch.surfacing.patchsurface import PatchSurface
    from viewer.surfacing.picture import make_pieces

    body = PatchSurface.of(thing, {})
    return [make_pieces(body, -1), *list_layers(thing.network, view)]


# Retopologies


@to_pyvista.register(Retopology)
def _(thing: Retopology) -> PolyData:
    made = thing.mesh(thing.fill())
    mesh = _make_quads(made.vertices, made.quads)
    mesh.cell_data["patch"] = np.asarray(made.patch)
    return mesh


@list_layers.register(Retopology)
def _(thing: Retopology, view: View) -> list[Layer]:
    from viewer.retopo import RetopoState
    from viewer.retopo.picture import RetopoPainter

    state = RetopoState(thing)
    try:
        state.camera.aim(view)
        state.settle()
        return list(RetopoPainter().compose(state, *map(float, SIZE)).layers)
    finally:
        state.close()


# Shape models


@to_pyvista.register(ShapeModel)
def _(thing: ShapeModel) -> PolyData:
    mesh = _make_quads(thing.mean, thing.quads)
    for number, (mode, deviation) in enumerate(zip(thing.modes, thing.deviations, strict=True), 1):
        mesh.point_data[f"mode {number}"] = mode * deviation
    return mesh


@list_layers.register(ShapeModel)
def _(thing: ShapeModel, view: View) -> list[Layer]:
    quads = np.asarray(thing.quads)
    lines = [thing.mean[np.asarray(one.vertices)] for one in thing.features]
    edges = LineLook(style.EDGE, EDGE, Lift(1.5))
    return [
        Faces("shape", thing.mean, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])),
        _make_edges("edges", thing.mean, _find_pairs(quads), edges),
        Curves.of("features", lines, LineLook(style.SELECTED, CURVE, Lift(3.0))),
    ]
