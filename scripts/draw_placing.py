"""Draw the pictures of docs/placing.md, and print the figures that it tells.

    python scripts/draw_placing.py --out docs/images

Fills come from the starter database, or the one that --db names; surfaces are the meshes of
examples/, made smooth. Needs no display.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from draw_offscreen import prepare_offscreen
from PIL import Image
from scipy.interpolate import CubicSpline

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import flipped
from query import Boundary, Fill, fills
from query.placing import Placement, Region, Surface, enclose_region, lay_flat, place
from query.placing.flow import follow_strokes
from query.stroke import Stroke
from viewer import style

ROOT = Path(__file__).parents[1]

#: Pixels of one panel.
PANEL = (560, 560)

CLAY = "#d9d4cb"
PATCH = "#f7f1e2"
WRONG = "#e4487f"
STROKE = "#d55e00"
STRAND = "#7fb3dc"


class Sheet:
    """Panels side by side, each a scene in space seen from one direction."""

    def __init__(self, panels: int) -> None:
        size = (PANEL[0] * panels, PANEL[1])
        self.plotter: Any = pv.Plotter(
            off_screen=True, shape=(1, panels), window_size=size, border=False
        )
        self.plotter.set_background(style.PAPER)

    def panel(self, column: int) -> None:
        self.plotter.subplot(0, column)

    def surface(self, surface: Surface, hole: Region | None = None) -> None:
        """The surface in clay, shaded smoothly; without the triangles that a fill covers."""
        shown = surface.triangles
        if hole is not None:
            covered = {tuple(t) for t in hole.surface.triangles.tolist()}
            shown = np.array([t for t in shown.tolist() if tuple(t) not in covered])
        mesh = pv.PolyData.from_regular_faces(surface.vertices, shown)
        mesh.point_data["Normals"] = surface.normals
        mesh.point_data.SetActiveNormals("Normals")
        self.plotter.add_mesh(
            mesh, color=CLAY, smooth_shading=True, specular=0.1, ambient=0.25, diffuse=0.8
        )

    def fill(
        self,
        fill: Fill,
        vertices: Points,
        size: float,
        wrong: Sequence[int] = (),
        strands: Sequence[int] = (),
    ) -> None:
        """A placed fill with its edges, irregular vertices and boundary; lines as thick as a
        part of ``size``. wrong, strands: quads painted in these colours."""
        at = vertices
        mesh = pv.PolyData.from_regular_faces(at, fill.quads)
        colours = np.tile(style.parse_colour(PATCH), (fill.n_quads, 1))
        colours[list(strands)] = style.parse_colour(STRAND)
        colours[list(wrong)] = style.parse_colour(WRONG)
        mesh.cell_data["colour"] = (255 * colours).astype(np.uint8)
        self.plotter.add_mesh(mesh, scalars="colour", rgb=True, ambient=0.45, diffuse=0.7)
        edges = np.unique(
            np.sort(np.stack([fill.quads, np.roll(fill.quads, -1, axis=1)], -1).reshape(-1, 2)),
            axis=0,
        )
        self.lines(at, edges, style.EDGE, 0.006 * size)
        loop = np.arange(fill.perimeter)
        self.lines(at, np.stack([loop, np.roll(loop, -1)], 1), style.BOUNDARY, 0.012 * size)
        valence = np.bincount(fill.quads.ravel())
        for v in fill.disk().irregular().tolist():
            ball = pv.Sphere(radius=0.028 * size, center=at[v])
            colour = style.choose_valence_colour(int(valence[v]))
            self.plotter.add_mesh(ball, color=colour, smooth_shading=True)

    def lines(self, points: Points, ends: Points, colour: str, radius: float) -> None:
        mesh = pv.PolyData(points, lines=np.c_[np.full(len(ends), 2), ends].ravel())
        self.plotter.add_mesh(mesh.tube(radius=radius), color=colour, ambient=0.4)

    def stroke(self, points: Points, size: float) -> None:
        count = np.arange(len(points) - 1)
        self.lines(points, np.stack([count, count + 1], 1), STROKE, 0.02 * size)

    def look(self, towards: Points, up: Points, middle: Points, height: float) -> None:
        """See ``middle`` along -towards; so much of the world is as high as the panel."""
        self.plotter.camera.position = (middle + 10.0 * height * towards).tolist()
        self.plotter.camera.focal_point = middle.tolist()
        self.plotter.camera.up = up.tolist()
        self.plotter.enable_parallel_projection()
        self.plotter.camera.parallel_scale = height / 2.0
        self.plotter.camera.clipping_range = (0.01 * height, 30.0 * height)

    def title(self, text: str) -> None:
        self.plotter.add_text(
            text, position=(0.03, 0.93), viewport=True, font_size=11, color=style.TEXT
        )

    def save(self, path: Path) -> None:
        self.plotter.enable_anti_aliasing("ssaa")
        shot = Image.fromarray(np.asarray(self.plotter.screenshot(return_img=True)))
        _few_colours(shot).save(path, optimize=True)
        self.plotter.close()


def _few_colours(shot: Image.Image) -> Image.Image:
    """With a palette of 256 colours, which makes the file a third as large: most for the shades
    of clay, some for the markers', which cover few pixels."""
    common = shot.quantize(192, Image.Quantize.MEDIANCUT).getpalette() or []
    rare = shot.quantize(64, Image.Quantize.MAXCOVERAGE).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette(common[: 3 * 192] + rare[: 3 * 64])
    return shot.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)


def smooth(name: str) -> Surface:
    """An example mesh, subdivided three times by Loop's scheme."""
    import trimesh

    coarse = Surface.from_polygons(read_mesh(ROOT / "examples" / f"{name}.obj"))
    mesh = trimesh.Trimesh(coarse.vertices, coarse.triangles, process=False)
    return Surface.of(mesh.subdivide_loop(3))


def string(surface: Surface, ends: Sequence[Sequence[float]], count: int = 81) -> Points:
    """A tight string on the surface between the points nearest to two given."""
    feet = surface.nearest(np.array(ends, float))
    a, b = feet.points
    t = np.linspace(0.0, 1.0, count)[:, None]
    # Lifted, so that it does not fall on the inside of a thin wall.
    bulge = t * (1.0 - t) * np.linalg.norm(b - a) * feet.normals.sum(axis=0)
    line = surface.nearest(a + t * (b - a) + bulge).points
    for _ in range(400):
        line[1:-1] = surface.nearest((line[:-2] + line[2:]) / 2.0).points
    line[0], line[-1] = a, b
    return line


def curve(surface: Surface, through: Sequence[Sequence[float]]) -> Points:
    """A smooth curve on the surface near the points given; its ends are exact."""
    points = np.array(through, float)
    points[1:-1] = surface.nearest(points[1:-1]).points
    spline = CubicSpline(np.linspace(0.0, 1.0, len(points)), points)
    line = surface.nearest(spline(np.linspace(0.0, 1.0, 120))).points
    line[0], line[-1] = points[0], points[-1]
    return line


def on_surface(
    surface: Surface, corners: Sequence[Sequence[float]], lengths: Sequence[int]
) -> Boundary:
    """The boundary whose corners are those given, joined by strings."""
    ends = [*corners[1:], corners[0]]
    sides = [string(surface, [a, b]) for a, b in zip(corners, ends, strict=True)]
    placed = Boundary.from_polylines(sides, lengths=lengths).points
    assert placed is not None
    return Boundary(lengths, points=surface.nearest(placed).points)


def first(db: patterndb.Database, boundary: Boundary, rank: int = 1, **options: Any) -> Fill:
    listed = [
        fill
        for fill, _ in zip(fills(db, boundary, limit=rank, **options), range(rank), strict=False)
    ]
    return listed[-1]


def plane(db: patterndb.Database, out: Path) -> None:
    """In the plane: a convex outline, and one whose membrane flips quads."""
    up = np.array([0.0, 0.0, 1.0])
    sheet = Sheet(3)
    corners = np.array(
        [[-1.1, -0.8, 0], [0.9, -1.0, 0], [1.35, 0.2, 0], [0.2, 1.1, 0], [-1.3, 0.7, 0]]
    )
    sides = [np.stack([a, b]) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
    boundary = Boundary.from_polylines(sides, lengths=(7, 5, 6, 7, 5))
    assert boundary.points is not None
    fill = first(db, boundary)
    sheet.panel(0)
    placed = place(fill, boundary.points)
    sheet.fill(fill, placed.vertices, 1.3)
    sheet.title("convex: every vertex at the mean of its neighbours")
    sheet.look(up, np.array([0.0, 1.0, 0.0]), np.array([0.02, 0.05, 0.0]), 3.0)
    print(f"plane: {fill.n_quads} quads, {len(placed.flipped)} flipped")

    notch = np.array([[-1.3, -1, 0], [1.3, -1, 0], [1.3, 1, 0], [0.0, -0.75, 0], [-1.3, 1, 0]])
    lines = [notch[[0, 1]], notch[[1, 2]], notch[[2, 3, 4]], notch[[4, 0]]]
    boundary = Boundary.from_polylines(lines, lengths=(10, 6, 10, 6))
    points = boundary.points
    assert points is not None
    fill = first(db, boundary)
    normals = np.tile(up, (fill.n_vertices, 1))
    for column, vertices, title in (
        (1, lay_flat(fill, points), "a deep notch: quads flip"),
        (2, place(fill, points).vertices, "untangled: none does"),
    ):
        wrong = np.flatnonzero(flipped(fill.quads, vertices, normals))
        sheet.panel(column)
        sheet.fill(fill, vertices, 1.3, wrong.tolist())
        sheet.title(title)
        sheet.look(up, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.05, 0.0]), 3.0)
        print(f"notch: {fill.n_quads} quads, {len(wrong)} flipped")
    sheet.save(out / "placing-plane.png")


def report(name: str, fill: Fill, placement: Placement) -> None:
    print(
        f"{name}: {fill.n_quads} quads, {len(placement.flipped)} flipped, {placement.rounds} "
        f"rounds, at rest: {placement.at_rest}, {placement.region_share:.1%} of the surface"
    )
    for before, after in zip(placement.strokes_before, placement.strokes_after, strict=True):
        print(
            f"  stroke: mean distance {before[0]:.3f} before, {after[0]:.3f} after; greatest "
            f"{before[1]:.3f}, {after[1]:.3f}"
        )


def cap(db: patterndb.Database, head: Surface, out: Path) -> None:
    """Half a head, which a membrane over its boundary would fall through."""
    turn = 2.0 * np.pi * (np.arange(6) + 0.5) / 6
    corners = [[7.5 * np.sin(t), 3.4, 0.5 + 9.5 * np.cos(t)] for t in turn]
    boundary = on_surface(head, corners, (6, 5, 5, 6, 5, 5))
    assert boundary.points is not None
    fill = first(db, boundary)
    region = enclose_region(head, boundary.points)
    placement = place(fill, boundary.points, region)
    report("cap", fill, placement)
    sheet = Sheet(3)
    up = np.array([0.0, 1.0, 0.0])
    views = [
        (lay_flat(fill, boundary.points), [0.5, 0.45, 1.0], "the membrane over the boundary", None),
        (placement.vertices, [0.5, 0.45, 1.0], "at rest on the surface", region),
        (placement.vertices, [-0.6, 0.9, -1.0], "from behind", region),
    ]
    for column, (vertices, towards, title, hole) in enumerate(views):
        sheet.panel(column)
        sheet.surface(head, hole or region)
        sheet.fill(fill, vertices, 14.0)
        sheet.title(title)
        direction = np.array(towards) / np.linalg.norm(towards)
        sheet.look(direction, up, np.array([0.0, 0.5, 0.5]), 24.0)
    sheet.save(out / "placing-cap.png")


def face(db: patterndb.Database, head: Surface, out: Path) -> None:
    """Two strokes on a face, and the strands that come to lie on them."""
    corners = [
        [-2.6, -9, 8],
        [2.6, -9, 8],
        [6.2, -3, 6],
        [4.6, 4.5, 8],
        [-4.6, 4.5, 8],
        [-6.2, -3, 6],
    ]
    boundary = on_surface(head, corners, (6, 7, 8, 8, 8, 7))
    assert boundary.points is not None
    starts = boundary.side_starts

    def middle(side: int, edge: int) -> list[float]:
        assert boundary.points is not None
        at = starts[side] + edge
        pair = boundary.points[[at, (at + 1) % boundary.perimeter]]
        return pair.mean(axis=0).tolist()

    lines = [
        curve(head, [middle(5, 1), [-3.4, -3.2, 9], [0, -1.4, 11], [3.4, -3.2, 9], middle(1, 5)]),
        curve(head, [middle(4, 2), [-3.0, 2.6, 9], [0, 1.6, 10], [3.0, 2.6, 9], middle(2, 5)]),
    ]
    strokes = [Stroke.drawn(boundary, line) for line in lines]
    fill = first(db, boundary, strokes=strokes, tolerance=0)
    region = enclose_region(head, boundary.points)
    plain = place(fill, boundary.points, region)
    pulled = place(fill, boundary.points, region, strokes, tolerance=0)
    report("face", fill, pulled)
    followed = follow_strokes(fill, plain.vertices, strokes, 0)
    carried = [set(map(tuple, np.sort(one.edges, axis=1).tolist())) for one in followed if one]
    ends = np.sort(np.stack([fill.quads, np.roll(fill.quads, -1, axis=1)], -1), axis=2)
    strands = [
        q
        for q, edges in enumerate(ends.tolist())
        if any(sum(tuple(edge) in strand for edge in edges) == 2 for strand in carried)
    ]
    sheet = Sheet(3)
    for column, vertices in enumerate([None, plain.vertices, pulled.vertices]):
        sheet.panel(column)
        sheet.surface(head, None if vertices is None else region)
        loop = np.arange(boundary.perimeter)
        if vertices is None:
            sheet.lines(
                boundary.points, np.stack([loop, np.roll(loop, -1)], 1), style.BOUNDARY, 0.12
            )
        else:
            sheet.fill(fill, vertices, 9.0, strands=strands)
        for line in lines:
            sheet.stroke(line, 9.0)
        sheet.look(
            np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, -2.2, 0]), 17.5
        )
    sheet.save(out / "placing-strokes.png")


def bodies(db: patterndb.Database, out: Path) -> None:
    """Regions of four to six sides on a jug, a dog and a hand."""
    jug, dog, hand = smooth("jug"), smooth("dog"), smooth("hand")
    y, z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    scenes = [
        (
            jug, [[-2.5, -7, 3], [3.5, -7, 3], [5.5, -5, 8], [2.5, -5, 14.5], [-3, -6, 12.5]],
            (6, 5, 6, 5, 6), [0.15, -1.0, 0.15], z, [0.2, 0, 9.0], 18.0,
        ),
        (
            dog, [[9, 36, 18], [9, 37, -24], [8, 50, -30], [7, 55, 22]],
            (9, 4, 10, 5), [1.0, 0.25, 0.2], y, [0, 44, -1], 62.0,
        ),
        (
            hand,
            [[-3.2, -7, 3], [1.8, -7.5, 3], [3.4, -3.5, 3], [2.6, 0.2, 3], [-2.6, 0.2, 3],
             [-3.4, -3.5, 3]],
            (5, 4, 4, 5, 4, 4), [0.0, -0.2, 1.0], y, [1.6, -1.4, 0], 19.5,
        ),
    ]  # fmt: skip
    sheet = Sheet(3)
    for column, (surface, corners, lengths, towards, up, middle, height) in enumerate(scenes):
        boundary = on_surface(surface, corners, lengths)
        assert boundary.points is not None
        fill = first(db, boundary)
        region = enclose_region(surface, boundary.points)
        placement = place(fill, boundary.points, region)
        report(f"body {column}", fill, placement)
        sheet.panel(column)
        sheet.surface(surface, region)
        sheet.fill(fill, placement.vertices, 0.45 * height)
        direction = np.array(towards) / np.linalg.norm(towards)
        sheet.look(direction, up, np.array(middle, float), height)
    sheet.save(out / "placing-bodies.png")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    parser.add_argument("--db", type=Path)
    arguments = parser.parse_args()
    prepare_offscreen()
    with patterndb.open(arguments.db) as db:
        head = smooth("head")
        plane(db, arguments.out)
        cap(db, head, arguments.out)
        face(db, head, arguments.out)
        bodies(db, arguments.out)


if __name__ == "__main__":
    main()
