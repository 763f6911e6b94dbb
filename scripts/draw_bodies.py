"""Draw the picture of the procedural bodies, with their named curves.

    python scripts/draw_bodies.py --out docs/images

Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from draw_offscreen import prepare_offscreen
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from viewer import style

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import CARS, Body, body, random_body
from bodies.clutter import wheel

ROOT = Path(__file__).parents[1]

#: Pixels of one panel, and panels per row.
PANEL = (400, 236)
COLUMNS = 5

#: Seeds of the bodies that fill the last row.
RANDOM = (3, 8)

#: Of the half that is modelled, and of its mirror image.
CLAY = "#d9d4cb"
TYRE = "#4a4a4a"
GLASS = "#a9c3cf"

#: Curves by component.
COLOURS = {
    "roof": "#0072b2",
    "body": "#d55e00",
    "front_wheelhouse": "#009e73",
    "rear_wheelhouse": "#009e73",
}

#: Radius of a drawn curve, in metres.
THICK = 0.012

#: Metres that a panel is high; the same for every car, so that sizes compare.
HEIGHT = 3.45

#: Width of the frames around panes, and x of the end of a van's, in metres.
FRAME = 0.055
VAN_PANES = 1.55

FLIP = np.array([1.0, -1.0, 1.0])


def glazed(shown: Body) -> NDArray[np.bool_]:
    """(f,) the faces of patches that have panes."""
    names = np.array([name in ("windscreen", "rear_window", "glass") for name in shown.patch_names])
    return names[shown.patches]


def within(shown: Body, points: Points) -> NDArray[np.float64]:
    """(n,) how far inside a pane points are, in metres; negative on the frame."""
    names = ("windscreen_base", "roof_front", "roof_rear", "rear_window_base", "a_pillar")
    names += ("c_pillar", "roof_rail", "belt_line")
    frame = np.concatenate([shown.feature(name).smooth for name in names])
    left = points * np.where(points[:, 1:2] > 0.0, FLIP, 1.0)
    inside = KDTree(frame).query(left)[0] - FRAME
    # A van's panes end behind its doors.
    if shown.name == "van":
        inside = np.minimum(inside, VAN_PANES - points[:, 0])
    return inside


def draw(plotter: Any, shown: Body) -> None:
    """One car: the whole body in clay, wheels, and the curves of the driver's half."""
    mesh = pv.PolyData.from_regular_faces(shown.points, shown.faces)
    mesh = mesh.compute_normals(split_vertices=True, feature_angle=22.0, consistent_normals=False)
    panes = mesh.extract_cells(np.flatnonzero(glazed(shown))).extract_surface(
        algorithm="dataset_surface"
    )
    panes.point_data["inside"] = within(shown, np.asarray(panes.points))
    rest = mesh.extract_cells(np.flatnonzero(~glazed(shown)))
    for part, colour in (
        (rest, CLAY),
        (panes.clip_scalar(scalars="inside", value=0.0, invert=True), CLAY),
        (panes.clip_scalar(scalars="inside", value=0.0, invert=False), GLASS),
    ):
        plotter.add_mesh(
            part, color=colour, smooth_shading=True, specular=0.15, ambient=0.3, diffuse=0.75,
            show_scalar_bar=False,
        )  # fmt: skip
    for centre in (0.0, shown.car.wheelbase):
        points, faces = wheel(shown.car, centre)
        for side in (1.0, -1.0):
            tyre = pv.PolyData.from_regular_faces(points * [1.0, side, 1.0], faces)
            plotter.add_mesh(tyre, color=TYRE, ambient=0.25)
    for curve in shown.features:
        if curve.kind == "hidden":
            continue
        line = pv.lines_from_points(curve.smooth)
        radius = THICK if curve.kind not in ("seam", "profile") else 0.6 * THICK
        plotter.add_mesh(line.tube(radius=radius), color=COLOURS[curve.component], ambient=0.5)
    if shown.name:
        plotter.add_text(
            shown.name, position=(0.05, 0.86), viewport=True, font_size=12, color=style.TEXT
        )
    middle = (shown.points.min(axis=0) + shown.points.max(axis=0)) / 2.0
    look = np.array([-0.62, -1.0, 0.42])
    look /= np.linalg.norm(look)
    plotter.camera.position = (middle + 12.0 * look).tolist()
    plotter.camera.focal_point = middle.tolist()
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = HEIGHT / 2.0
    plotter.camera.clipping_range = (0.1, 40.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    arguments = parser.parse_args()
    prepare_offscreen()
    rows = -(-(len(CARS) + len(RANDOM)) // COLUMNS)
    plotter: Any = pv.Plotter(
        off_screen=True, shape=(rows, COLUMNS), border=False,
        window_size=[PANEL[0] * COLUMNS, PANEL[1] * rows],
    )  # fmt: skip
    plotter.set_background(style.PAPER)
    shown = [body(name, resolution=1.5, whole=True) for name in CARS]
    shown += [random_body(seed, resolution=1.5, whole=True) for seed in RANDOM]
    for i, one in enumerate(shown):
        plotter.subplot(i // COLUMNS, i % COLUMNS)
        draw(plotter, one)
    plotter.enable_anti_aliasing("ssaa")
    shot = Image.fromarray(np.asarray(plotter.screenshot(return_img=True)))
    plotter.close()
    shot.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(
        arguments.out / "bodies.png", optimize=True
    )


if __name__ == "__main__":
    main()
