"""A composed picture, and how it is written as a PNG: without OpenGL, the same everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from viewer import style
from viewer.paper import POINTS_PER_INCH, Page, PictureFormatError
from viewer.scene import Scene
from viewer.solid import Solid

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
    path = check_png(path)
    scene = drawn.scene
    scale = height / scene.height
    page = Page(scene.width, scene.height)
    if len(drawn.solid.corners):
        fine, _ = drawn.solid.image(scene.width, scene.height, SAMPLES * scale)
        rows, columns = (n // SAMPLES * SAMPLES for n in fine.shape[:2])
        cut = fine[:rows, :columns].reshape(
            rows // SAMPLES, SAMPLES, columns // SAMPLES, SAMPLES, 3
        )
        page.axes.imshow(
            cut.mean(axis=(1, 3)),
            extent=(0.0, scene.width, 0.0, scene.height),
            interpolation="nearest",
            aspect="auto",
            zorder=0,
        )
        page.axes.set_xlim(0.0, scene.width)
        page.axes.set_ylim(0.0, scene.height)
    for patch in scene.patches:
        page.polygons(patch.corners, faces=patch.colours)
    for collection in page.axes.collections:
        # Snapped to pixels, thin rims would vanish on one side.
        collection.set_snap(False)
    for t in scene.texts:
        page.text(
            t.x, t.y, t.text, t.size, colour=t.colour, bold=t.bold, mono=t.mono, align=t.align
        )
    dpi = POINTS_PER_INCH * scale
    page.figure.savefig(
        path, format="png", dpi=dpi, facecolor=style.PAPER, metadata={"Software": None}
    )
    return path


def check_png(path: Path | str) -> Path:
    """The path; PictureFormatError if its name does not end in .png."""
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise PictureFormatError(f"{path}: an off-screen picture's name ends in .png")
    return path
