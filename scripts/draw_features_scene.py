"""What the pictures of feature curves are drawn with: solids, curves on them, sheets of panels."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from viewer import style

Size = tuple[int, int]

#: Pixels that are painted for one of the picture, to either side.
FINER = 2

CLAY = "#d9d4cb"
CLAY_TURNED = "#c3cbd3"
#: Of such patches in a legend, as blue as they look beside the others.
TURNED_KEY = "#7f9fc4"
CREASE = "#a59f95"
WIRE = "#8d97a3"
FOUND = "#d55e00"
SKETCHED = "#22416b"
CLEAN = "#0072b2"
MENDED = "#e69f00"

#: Radii of a recovered curve and of a sketched stroke, the length of its dashes and of the gaps
#: between them, and how far lines are lifted towards the eye: shares of the height shown.
BOLD, THIN = 0.0052, 0.0024
DASH, SPACE = 0.022, 0.014
LIFT = 0.012

#: The same for edges.
LIFT_EDGES = 0.002

#: Edges where faces turn by more than this, in degrees, are drawn; others are shaded smoothly.
SHARP = 25.0

#: Pixels whose red, green and blue differ by more than this are of lines, not of solids; so many
#: of a picture's 256 colours are theirs.
VIVID = 60
VIVID_COLOURS = 64

#: Bytes that a picture may have.
LARGEST_PICTURE = 300_000


class Scene:
    """A panel: what stands in it is seen without perspective.

    look: (3,) from what is seen towards the eye. middle: (3,) what is in the middle. height: of
    what is seen, in units of the things. size: in pixels.
    """

    def __init__(self, size: Size, look: Sequence[float], middle: Points, height: float) -> None:
        self.size = size
        self.height = height
        self.look = np.array(look, float) / np.linalg.norm(look)
        self.plotter: Any = pv.Plotter(
            off_screen=True, window_size=[FINER * size[0], FINER * size[1]]
        )
        self.plotter.set_background(style.PAPER)
        camera = self.plotter.camera
        camera.focal_point = middle.tolist()
        camera.position = (middle + 10.0 * height * self.look).tolist()
        camera.up = (0.0, 0.0, 1.0)
        self.plotter.enable_parallel_projection()
        camera.parallel_scale = height / 2.0
        camera.clipping_range = (0.5 * height, 30.0 * height)

    @classmethod
    def around(
        cls,
        size: Size,
        look: Sequence[float],
        points: Points,
        margin: float = 0.05,
        head: float = 0.0,
    ) -> Scene:
        """Of points (n, 3), as large as the panel lets them be below a head of so many pixels."""
        toward = np.array(look, float) / np.linalg.norm(look)
        axes = _axes(toward)
        flat = points @ axes.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        room = (1.0 - 2.0 * margin) * np.array([size[0], size[1] - head])
        scale = float((room / (high - low)[:2]).min())
        middle = (low + high) / 2.0
        middle[1] += head / 2.0 / scale
        return cls(size, look, middle @ axes, size[1] / scale)

    def solid(
        self,
        points: Points,
        faces: NDArray[np.integer],
        colour: str = CLAY,
        *,
        sharp: bool = False,
        wire: bool = False,
    ) -> None:
        """Faces (f, 3) or (f, 4), shaded; sharp: with sharp edges and rims; wire: with all edges.

        Faces may be turned either way.
        """
        mesh = pv.PolyData.from_regular_faces(points, np.asarray(faces, np.int64))
        shaded = mesh.compute_normals(split_vertices=True, feature_angle=SHARP)
        self.plotter.add_mesh(
            shaded, color=colour, smooth_shading=True, ambient=0.32, diffuse=0.72, specular=0.08
        )
        if sharp:
            self._lines(_segments(points, sharp_edges(points, faces)), CREASE, 0.7 * FINER)
        if wire:
            self._lines(mesh.extract_all_edges(), WIRE, 0.45 * FINER)

    def _lines(self, lines: Any, colour: str, width: float) -> None:
        lines.points = np.asarray(lines.points) + LIFT_EDGES * self.height * self.look
        self.plotter.add_mesh(lines, color=colour, line_width=width, lighting=False)

    def curve(self, points: Points, colour: str = FOUND, radius: float = BOLD) -> None:
        """A polyline (n, 3) as a tube."""
        lifted = points + LIFT * self.height * self.look
        tube = pv.lines_from_points(lifted).tube(radius=radius * self.height, n_sides=14)
        self.plotter.add_mesh(tube, color=colour, ambient=0.55, diffuse=0.5, smooth_shading=True)

    def dashed(self, points: Points, colour: str = SKETCHED, radius: float = THIN) -> None:
        """A polyline (n, 3) in dashes."""
        total = float(arc_length(points)[-1])
        count = max(1, round(total / ((DASH + SPACE) * self.height)))
        step = total / (count - SPACE / (DASH + SPACE))
        for k in range(count):
            low = k * step
            ends = low, min(low + step * DASH / (DASH + SPACE), total)
            self.curve(at_lengths(points, np.linspace(*ends, 5)), colour, radius)

    def dots(self, points: Points, colour: str = SKETCHED, radius: float = 1.7 * THIN) -> None:
        """Points (n, 3) as balls."""
        lifted = pv.PolyData(points + LIFT * self.height * self.look)
        balls = lifted.glyph(
            geom=pv.Sphere(radius=radius * self.height), scale=False, orient=False
        )  # fmt: skip
        self.plotter.add_mesh(balls, color=colour, ambient=0.6, diffuse=0.4, smooth_shading=True)

    def image(self) -> Image.Image:
        """The panel; nothing can be added to it afterwards."""
        shot = Image.fromarray(np.asarray(self.plotter.screenshot(return_img=True)))
        self.plotter.close()
        return shot.convert("RGB").resize(self.size, Image.Resampling.LANCZOS)


def _axes(toward: Points) -> Points:
    """(3, 3) to the right, up and towards the eye."""
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right), toward])


def _segments(points: Points, edges: NDArray[np.int64]) -> Any:
    lines = np.c_[np.full(len(edges), 2), edges].ravel()
    return pv.PolyData(points, lines=lines)


def sharp_edges(points: Points, triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """(e, 2) edges where two triangles meet at more than SHARP degrees, or not just two meet.

    The triangles may be turned either way.
    """
    t = np.asarray(triangles, np.int64)
    pairs = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [0, 2]]]), axis=1)
    wings = points[np.concatenate([t[:, 2], t[:, 0], t[:, 1]])]
    edges, name, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    name = name.ravel()
    start = points[edges[:, 0]]
    along = points[edges[:, 1]] - start
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    out = wings - start[name]
    out -= np.einsum("ij,ij->i", out, along[name])[:, None] * along[name]
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)
    total = np.zeros((len(edges), 3))
    np.add.at(total, name, out)
    # Unit vectors away from the edge along two triangles: their sum is 2 sin(bend / 2) long.
    bent = np.linalg.norm(total, axis=1) > 2.0 * np.sin(np.deg2rad(SHARP) / 2.0)
    return edges[bent | (count != 2)]


def write(
    image: Image.Image,
    at: tuple[float, float],
    text: str,
    size: float = 15.0,
    colour: str = style.TEXT,
    anchor: str = "la",
    bold: bool = False,
) -> None:
    """A line of text; anchor: as of PIL, by default at is its upper left."""
    from matplotlib import get_data_path

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    font = ImageFont.truetype(str(Path(get_data_path()) / "fonts" / "ttf" / name), size)
    ImageDraw.Draw(image).text(at, text, fill=colour, font=font, anchor=anchor)


def key(image: Image.Image, at: tuple[float, float], entries: Sequence[tuple[str, str]]) -> None:
    """A legend, downwards: colours and what they mean; sketched strokes are dashed."""
    pen = ImageDraw.Draw(image)
    x, y = at
    for colour, meaning in entries:
        if colour == SKETCHED:
            for k in range(3):
                pen.line((x + 13 * k, y + 9, x + 13 * k + 8, y + 9), fill=colour, width=2)
        else:
            pen.line((x, y + 9, x + 34, y + 9), fill=colour, width=5)
        write(image, (x + 46, y), meaning, 14.0)
        y += 25


def sheet(rows: Sequence[Sequence[Image.Image]]) -> Image.Image:
    """Rows of panels as one picture; panels of a row have one height."""
    width = max(sum(one.width for one in row) for row in rows)
    height = sum(row[0].height for row in rows)
    whole = Image.new("RGB", (width, height), style.PAPER)
    y = 0
    for row in rows:
        x = 0
        for one in row:
            whole.paste(one, (x, y))
            x += one.width
        y += row[0].height
    return whole


def save(image: Image.Image, path: Path) -> None:
    """As PNG in 256 colours. Raises ValueError for more than LARGEST_PICTURE bytes."""
    # Thin lines have few pixels: they would lose their colours to the shades of solids.
    pixels = np.asarray(image).reshape(-1, 3).astype(int)
    vivid = np.ptp(pixels, axis=1) > VIVID
    colours: list[int] = []
    covering, dense = Image.Quantize.MAXCOVERAGE, Image.Quantize.MEDIANCUT
    for chosen, count, way in (
        (vivid, VIVID_COLOURS, covering),
        (~vivid, 255 - VIVID_COLOURS, dense),
    ):
        some = Image.fromarray(pixels[chosen][None].astype(np.uint8)).quantize(count, way)
        colours += (some.getpalette() or [])[: 3 * count]
    palette = Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *colours])
    few = np.array(image.quantize(palette=palette, dither=Image.Dither.NONE))
    # Quantizing takes any near colour for the paper's.
    few[(np.asarray(image) == 255).all(axis=2)] = 0
    palette = Image.fromarray(few, "P")
    palette.putpalette([255, 255, 255, *colours])
    palette.save(path, optimize=True)
    size = path.stat().st_size
    print(f"{path}: {size:,} bytes")
    if size > LARGEST_PICTURE:
        raise ValueError(f"{path} has over {LARGEST_PICTURE:,} bytes; draw it smaller")
