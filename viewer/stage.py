"""Puts a scene into a pyvista window: polygons in layers, text, and shaded triangles behind."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from viewer.scene import Scene, Text
from viewer.solid import Solid

#: Distance between layers and from the camera to the first; any will do.
LAYER = 1e-3
CAMERA = 10.0

#: VTK's number (VTK_FONT_FILE) for a typeface that is read from a file.
FONT_FROM_FILE = 4


class Stage:
    """What stands in a window; texts that stay are not made anew."""

    def __init__(self, plotter: Any) -> None:
        self._plotter = plotter
        self._written = 0
        self._texts: dict[tuple[Text, float], Any] = {}
        self._actors: list[Any] = []

    def show(self, scene: Scene, solid: Solid) -> None:
        """Replace what was there, and render."""
        plotter = self._plotter
        width, height = plotter.window_size
        for actor in self._actors:
            plotter.remove_actor(actor, reset_camera=False, render=False)
        self._actors = []
        depth = 0.0
        if len(solid.corners):
            near = solid.corners[..., 2]
            # All of it lies behind the layers.
            mesh = _triangles(solid, -float(near.max()) - 1.0)
            depth = float(np.ptp(near)) + 1.0
            self._add(mesh)
        self._add(layered(scene))
        self._write(scene, (width, height))
        x, y = scene.width / 2.0, scene.height / 2.0
        plotter.camera.position = (x, y, CAMERA)
        plotter.camera.focal_point = (x, y, 0.0)
        plotter.camera.up = (0.0, 1.0, 0.0)
        plotter.camera.parallel_scale = y
        plotter.camera.clipping_range = (0.5, CAMERA + depth + 1.0)
        plotter.render()

    def _add(self, mesh: Any) -> None:
        self._actors.append(
            self._plotter.add_mesh(
                mesh, scalars="colour", rgb=True, lighting=False, reset_camera=False, render=False
            )
        )

    def _write(self, scene: Scene, size: tuple[int, int]) -> None:
        unit = size[1] / scene.height
        kept: dict[tuple[Text, float], Any] = {}
        for t in scene.texts:
            # A text's place depends on the window's shape, too.
            key = (t, scene.width)
            kept[key] = self._texts.pop(key, None) or self._text(t, scene, unit)
        for actor in self._texts.values():
            self._plotter.remove_actor(actor, reset_camera=False, render=False)
        self._texts = kept

    def _text(self, t: Text, scene: Scene, unit: float) -> Any:
        text = text_of(t, scene, unit)
        # An actor takes the place of the one of its name, so no two may have one.
        self._written += 1
        name = f"text-{self._written}"
        self._plotter.add_actor(text, reset_camera=False, name=name, render=False)
        return text


def layered(scene: Scene) -> Any:
    """All polygons of a scene as one surface, later ones nearer to the camera."""
    import pyvista as pv

    points, faces, colours = [], [], []
    count = 0
    for layer, patch in enumerate(scene.patches):
        n, c = patch.corners.shape[:2]
        z = np.full((n * c, 1), layer * LAYER)
        points.append(np.hstack([patch.corners.reshape(-1, 2), z]))
        corner = count + np.arange(n * c).reshape(n, c)
        faces.append(np.hstack([np.full((n, 1), c), corner]).ravel())
        colours.append(patch.colours)
        count += n * c
    mesh = pv.PolyData(np.vstack(points), np.concatenate(faces))
    mesh.cell_data["colour"] = np.round(np.vstack(colours) * 255.0).astype(np.uint8)
    # OpenGL fills a concave polygon wrongly; the triangulation fills it as it is.
    return mesh.triangulate()


def text_of(t: Text, scene: Scene, unit: float) -> Any:
    """A line of text; unit: pixels per point."""
    import pyvista as pv
    from matplotlib import get_data_path

    # VTK's own typefaces have no arrows; matplotlib brings one that has.
    fonts = Path(get_data_path()) / "fonts" / "ttf"
    text = pv.Text(t.text)
    text.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    text.SetPosition(t.x / scene.width, t.y / scene.height)
    family = "DejaVuSansMono" if t.mono else "DejaVuSans"
    prop: Any = text.prop
    prop.SetFontFamily(FONT_FROM_FILE)
    prop.SetFontFile(str(fonts / f"{family}{'-Bold' if t.bold else ''}.ttf"))
    prop.font_size = max(1, round(t.size * unit))
    prop.color = t.colour
    prop.justification_horizontal = t.align
    return text


def _triangles(solid: Solid, shift: float) -> Any:
    """A solid as a surface with colours at its points."""
    import pyvista as pv

    n = len(solid.corners)
    points = solid.corners.reshape(-1, 3) + np.array([0.0, 0.0, shift])
    corner = np.arange(3 * n).reshape(n, 3)
    mesh = pv.PolyData(points, np.hstack([np.full((n, 1), 3), corner]).ravel())
    colours = np.round(solid.colours.reshape(-1, 3) * 255.0)
    mesh.point_data["colour"] = colours.astype(np.uint8)
    return mesh
