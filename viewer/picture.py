"""A composed picture, its frame, and its way into a PNG: without OpenGL, the same everywhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from patterndb.system.files import replace_file
from viewer import style
from viewer.camera import Camera
from viewer.paper import POINTS_PER_INCH, PictureFormatError, write_text
from viewer.raster import Raster
from viewer.scene import Scene
from viewer.solid import NOTHING, Solid, Triangles

#: Pixels of a picture of a window.
WINDOW = (1400, 860)

#: Samples of a pixel, each way, of what is shaded.
SAMPLES = 2


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """The whole picture: the solid behind, the scene over it. middle: of the view."""

    scene: Scene
    solid: Solid
    middle: tuple[float, float]


def save_drawn(path: Path | str, drawn: Drawn, height: int) -> Path:
    """Write a composed picture, ``height`` pixels high; the same picture gives the same bytes.

    Raises PictureFormatError for another suffix than .png, and OSError as writing does.
    """
    return save_sheet(path, [drawn], height)


def save_sheet(
    path: Path | str, sheet: Sequence[Drawn], height: int, columns: int | None = None
) -> Path:
    """Write composed pictures of one size beside and below each other, each ``height`` pixels
    high; columns: as many as rows, or one more, by default. Raises as :func:`save_drawn` does."""
    path = check_png(path)
    tiles = [_paint_drawn(drawn, height) for drawn in sheet]
    columns = math.ceil(math.sqrt(len(tiles))) if columns is None else columns
    whole = tiles[0]
    if len(tiles) > 1:
        tall, wide = tiles[0].pixels.shape[:2]
        whole = Raster(columns * wide, math.ceil(len(tiles) / columns) * tall)
        for k, tile in enumerate(tiles):
            top, left = k // columns * tall, k % columns * wide
            whole.pixels[top : top + tall, left : left + wide] = tile.pixels
    replace_file(path, whole.encode_png(POINTS_PER_INCH * height / sheet[0].scene.height))
    return path


def _paint_drawn(drawn: Drawn, height: int) -> Raster:
    """Paint a composed picture, so many pixels high."""
    scene = drawn.scene
    scale = height / scene.height
    raster = Raster(round(scene.width * scale), height)
    if len(drawn.solid.corners):
        fine, _ = drawn.solid.image(scene.width, scene.height, SAMPLES * scale)
        rows, columns = (n // SAMPLES for n in fine.shape[:2])
        cut = fine[: SAMPLES * rows, : SAMPLES * columns]
        raster.pixels[:rows, :columns] = cut.reshape(rows, SAMPLES, columns, SAMPLES, 3).mean(
            axis=(1, 3)
        )[: raster.pixels.shape[0], : raster.pixels.shape[1]]
    for patch in scene.patches:
        corners = (patch.corners - (0.0, scene.height)) * (scale, -scale)
        raster.fill(corners, patch.colours)
    for text in scene.texts:
        write_text(raster, text, scene.height, scale)
    return raster


def check_png(path: Path | str) -> Path:
    """Return the path; PictureFormatError if its name does not end in .png."""
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise PictureFormatError(f"{path}: an off-screen picture's name ends in .png")
    return path


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """scene: what is flat. middle: of the view."""

    scene: Scene
    middle: tuple[float, float]

    @classmethod
    def of(cls, camera: Camera, width: float, height: float, below: float = 0.0) -> Frame:
        """For a picture of so many points, into which the camera's view is fitted.

        below: points that the view leaves free at the bottom.
        """
        camera.fill(width, height - below)
        return cls(Scene(width, height), (width / 2.0, (height + below) / 2.0))

    def solid(self, parts: Sequence[Triangles], placed: Triangles = NOTHING) -> Solid:
        """Triangles as seen from the middle of the view; placed: those in the picture already."""
        corners = np.concatenate([NOTHING[0], *(part[0] for part in parts)])
        corners = np.concatenate([placed[0], corners + np.array([*self.middle, 0.0])])
        colours = np.concatenate([placed[1], *(part[1] for part in parts)])
        return Solid(corners, colours, 0.0, placed)

    def drawn(self, solid: Solid) -> Drawn:
        """The picture, all put into its scene."""
        if not self.scene.patches:
            # A page always has something to lay text and triangles on.
            self.scene.box(0.0, 0.0, 0.0, 0.0, style.PAPER, style.PAPER)
        return Drawn(self.scene, solid, self.middle)
