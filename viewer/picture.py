"""The frame of a composed picture, and its way into a PNG: off-screen, without a display too."""

from __future__ import annotations

import ctypes
import io
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import PatternDBError
from patterndb.system.extras import require_extra
from patterndb.system.files import replace_file
from viewer import style
from viewer.camera import Camera, StageLook, View
from viewer.paper import DPI, POINTS_PER_INCH, Page, PictureFormatError
from viewer.scene import Scene
from viewer.stage import Drawn, Layer, LayerStage

#: Pixels of a picture of a window.
WINDOW = (1400, 860)

#: Samples of a pixel, each way.
SAMPLES = 2

#: Libraries by which VTK draws without a display: one is enough.
RENDERING = ("libEGL.so.1", "libOSMesa.so.8", "libOSMesa.so.6")


class PictureError(PatternDBError, RuntimeError):
    """Pictures of what lies in space cannot be drawn on this machine."""


def save_drawn(path: Path | str, drawn: Drawn, height: int) -> Path:
    """Write a composed picture, ``height`` pixels high.

    Raises PictureFormatError for another suffix than .png, and OSError as writing does.
    """
    return save_sheet(path, [drawn], height)


def save_sheet(
    path: Path | str, sheet: Sequence[Drawn], height: int, columns: int | None = None
) -> Path:
    """Write composed pictures of one size beside and below each other, each ``height`` pixels
    high; columns: as many as rows, or one more, by default. Raises as :func:`save_drawn` does."""
    path = check_png(path)
    if len(sheet) == 1 and not sheet[0].layers:
        _make_page(sheet[0].scene, height).save(path)
        return path
    from PIL import Image

    tiles = paint_drawn(sheet, height)
    columns = math.ceil(math.sqrt(len(tiles))) if columns is None else columns
    tall, wide = tiles[0].shape[:2]
    whole = np.full((math.ceil(len(tiles) / columns) * tall, columns * wide, 3), 255, np.uint8)
    for k, tile in enumerate(tiles):
        top, left = k // columns * tall, k % columns * wide
        whole[top : top + tall, left : left + wide] = tile
    content = io.BytesIO()
    dpi = POINTS_PER_INCH * height / sheet[0].scene.height
    Image.fromarray(whole).save(content, "PNG", dpi=(dpi, dpi), optimize=True)
    replace_file(path, content.getvalue())
    return path


def _make_page(scene: Scene, height: int) -> Page:
    """Make the page of a flat scene, as PNG of a given height in pixels, without VTK."""
    scale = height / scene.height * POINTS_PER_INCH / DPI
    page = Page(scene.width * scale, scene.height * scale)
    for patch in scene.patches:
        page.polygons(patch.corners * scale, faces=patch.colours)
    for text in scene.texts:
        page.add(text._replace(x=text.x * scale, y=text.y * scale, size=text.size * scale))
    return page


def paint_drawn(sheet: Sequence[Drawn], height: int) -> list[NDArray[np.uint8]]:
    """Paint composed pictures of one size: each (height, w, 3) pixels."""
    scene = sheet[0].scene
    size = round(scene.width * height / scene.height), height
    plotter = make_plotter((SAMPLES * size[0], SAMPLES * size[1]))
    try:
        stage = LayerStage(plotter)
        density = SAMPLES * height / scene.height
        tiles: list[NDArray[np.uint8]] = []
        for drawn in sheet:
            stage.show(drawn, density)
            plotter.render()
            fine = np.asarray(plotter.screenshot(None, return_img=True), np.float32)
            cut = fine.reshape(height, SAMPLES, size[0], SAMPLES, 3).mean(axis=(1, 3))
            tiles.append((cut + 0.5).astype(np.uint8))
        return tiles
    finally:
        plotter.close()


def make_plotter(size: tuple[int, int]) -> Any:
    """Make a plotter of a given size in pixels that shows nothing on a screen.

    Raises MissingExtraError without pyvista, and PictureError where VTK could not draw.
    """
    require_extra("viewer", "a picture of something in space", ("vtkmodules", "pyvista"))
    check_rendering()
    import pyvista as pv

    # Without a display VTK warns before it takes EGL or OSMesa.
    with pv.vtk_verbosity("off"):
        plotter: Any = pv.Plotter(off_screen=True, window_size=list(size), lighting="none")
        plotter.render_window.SetMultiSamples(0)
        plotter.set_background(style.PAPER)
        plotter.show(auto_close=False)
    return plotter


def check_rendering() -> None:
    """Raise PictureError where VTK could not draw off-screen: it would end the process."""
    if has_display():
        return
    for name in RENDERING:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return
    raise PictureError(
        "nothing in space can be drawn: there is no display, and neither EGL nor OSMesa. Debian "
        "and Ubuntu: apt-get install libegl1 libgl1-mesa-dri"
    )


def has_display() -> bool:
    """Is there a display that VTK can draw on? Elsewhere than on Linux there always is."""
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))


def check_png(path: Path | str) -> Path:
    """Return the path; PictureFormatError if its name does not end in .png."""
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise PictureFormatError(f"{path}: an off-screen picture's name ends in .png")
    return path


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """scene: what is flat. view: of what lies in space, its middle in the picture, and how faces
    are shown."""

    scene: Scene
    view: View
    middle: tuple[float, float]
    look: StageLook

    @classmethod
    def of(cls, camera: Camera, width: float, height: float, below: float = 0.0) -> Frame:
        """For a picture of a given size in points, into which the camera's view is fitted.

        below: points that the view leaves free at the bottom.
        """
        camera.fill(width, height - below)
        middle = (width / 2.0, (height + below) / 2.0)
        return cls(Scene(width, height), camera.view, middle, camera.face_look)

    def drawn(self, layers: Sequence[Layer]) -> Drawn:
        """The picture of layers, with what is flat over them."""
        return Drawn(self.scene, layers, self.view, self.middle, self.look)
