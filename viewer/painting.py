"""Paints a drawing on anything that can fill polygons and write text: a page or a window."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from patterndb.geometry.points import Points
from viewer import style
from viewer.drawing import DiskDrawing, StrokeMark

#: Radius of an irregular vertex's marker: part of an edge, and least and most in points.
#: In a dense mesh it covers the quads around it; it is what one looks for.
MARKER = (0.17, 2.0, 4.6)

#: Width of a quad's outline, likewise; the boundary's is so many times as wide.
LINE = (0.045, 0.3, 0.9)
BOUNDARY_LINES = 2.4

#: Likewise that of a stroke asked for, and by how much wider its bars on the boundary are.
STROKE_LINES = 2.6
END_WIDTH = 2.0

#: What markers and the boundary's width need beside the drawing itself, in points.
BLEED = 3.0


class Text(NamedTuple):
    """A line of text, its baseline at y; size in points, align "left", "center" or "right"."""

    x: float
    y: float
    text: str
    size: float
    colour: str
    bold: bool
    mono: bool
    align: str


@dataclass(frozen=True, slots=True, eq=False)
class PaintedPolygons:
    """Polygons: (n, c, 2) corners; (n, 3) colours that fill them, if any do; the colour and width
    of their outlines, "none" for none; the name of their group."""

    corners: Points
    faces: Points | None
    line: str
    width: float
    gid: str | None


class PaintTarget(ABC):
    """A surface measured in points, y upward, that things are painted on back to front."""

    @abstractmethod
    def add(self, item: PaintedPolygons | Text) -> None:
        """Paint one thing over what is there."""

    def polygons(
        self,
        corners: Points,
        *,
        face: str = "none",
        faces: Points | None = None,
        line: str = "none",
        width: float = 0.0,
        gid: str | None = None,
    ) -> None:
        """Paint (n, c, 2) polygons over what is there, in one colour or (n, 3) colours.

        line, width: colour and width of the outline; gid: the group's name, where the
        surface has such a thing.
        """
        corners = np.asarray(corners, np.float64)
        if faces is None and face != "none":
            faces = np.tile(style.parse_colour(face), (len(corners), 1))
        self.add(PaintedPolygons(corners, faces, line if width > 0.0 else "none", width, gid))

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float,
        *,
        colour: str = style.TEXT,
        bold: bool = False,
        mono: bool = False,
        align: str = "center",
    ) -> None:
        """Write a line whose baseline is at y; align: "left", "center" or "right"."""
        self.add(Text(x, y, text, size, colour, bold, mono, align))


def make_bars(begin: Points, end: Points, width: float | Points, lap: float = 0.0) -> Points:
    """Make (n, 4, 2) thin rectangles from places (n, 2) to others, so wide; lap: by how much they
    reach beyond both, in half widths. What has no length is only reaching."""
    along = end - begin
    length = np.linalg.norm(along, axis=1, keepdims=True)
    half = np.broadcast_to(np.asarray(width, np.float64) / 2.0, (len(along),))[:, None]
    along = along / np.where(length > 0.0, length, 1.0) * half
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    a, b = begin - lap * along, end + lap * along
    return np.stack([a + across, b + across, b - across, a - across], axis=1)


def paint_disk(
    canvas: PaintTarget,
    drawing: DiskDrawing,
    x: float,
    y: float,
    size: float,
    gid: str | None = None,
) -> None:
    """Paint a drawing, centred at (x, y), in a square of this size.

    gid names its group of quads: in an SVG, one path per quad.
    """
    scale = measure_scale(size)
    points = drawing.points * scale + (x, y)
    edge = drawing.edge * scale
    canvas.polygons(points[drawing.quads], face=style.QUAD)
    if len(drawing.bands):
        canvas.polygons(drawing.bands * scale + (x, y), faces=drawing.tints)
    if len(drawing.chosen):
        canvas.polygons(drawing.chosen * scale + (x, y), face=style.SELECTED)
    thin = float(np.clip(edge * LINE[0], *LINE[1:]))
    canvas.polygons(points[drawing.quads], line=style.EDGE, width=thin, gid=gid)
    loop = points[: drawing.perimeter]
    canvas.polygons(loop[None], line=style.BOUNDARY, width=BOUNDARY_LINES * thin)
    radius = float(np.clip(edge * MARKER[0], *MARKER[1:]))
    corner = min(0.75 * radius, 2.6)
    if len(drawing.convex):
        dots = points[drawing.convex][:, None] + style.make_circle() * corner
        canvas.polygons(dots, face=style.BOUNDARY)
    if len(drawing.reflex):
        diamonds = points[drawing.reflex][:, None] + style.make_diamond() * 1.5 * corner
        canvas.polygons(diamonds, face=style.PAPER, line=style.BOUNDARY, width=1.3 * thin)
    for mark in drawing.marks:
        _paint_mark(canvas, mark, points, STROKE_LINES * thin)
    for kind in np.unique(drawing.valences).tolist():
        at = points[drawing.irregular[drawing.valences == kind]]
        canvas.polygons(
            at[:, None] + style.choose_valence_shape(kind) * radius,
            face=style.choose_valence_colour(kind),
            line=style.PAPER,
            width=max(0.4, 0.16 * radius),
        )


def _paint_mark(canvas: PaintTarget, mark: StrokeMark, points: Points, width: float) -> None:
    """Paint the midline of the strand that carries a stroke, and bars on the edges asked for.

    points: (v, 2) of the fill on the canvas.
    """
    middle = points[mark.edges].mean(axis=1)
    pieces = np.concatenate([np.stack([middle[:-1], middle[1:]], axis=1), points[mark.ends]])
    wide = np.full(len(pieces), width)
    wide[len(pieces) - len(mark.ends) :] *= END_WIDTH
    canvas.polygons(make_bars(pieces[:, 0], pieces[:, 1], wide), face=style.STROKE)
    # Round where a midline bends.
    canvas.polygons(middle[:, None] + style.make_circle() * width / 2.0, face=style.STROKE)


def measure_scale(size: float) -> float:
    """Measure the points per unit of a drawing that is painted in a square of this size."""
    return size / 2.0 - BLEED


def paint_legend(
    canvas: PaintTarget, drawings: Iterable[DiskDrawing], x: float, y: float, size: float
) -> None:
    """Explain the markers that occur in the drawings, in one line centred at x.

    y: baseline; size: of the type, in points.
    """
    drawings = list(drawings)
    kinds = sorted({int(k) for d in drawings for k in d.valences})
    entries: list[tuple[str, Points, str, str]] = []
    for kind in kinds:
        colour = style.choose_valence_colour(kind)
        entries.append((f"valence {kind}", style.choose_valence_shape(kind), colour, colour))
    if any(len(d.convex) for d in drawings):
        entries.append(("convex corner", style.make_circle() * 0.9, style.BOUNDARY, style.BOUNDARY))
    if any(len(d.reflex) for d in drawings):
        entries.append(("reflex corner", style.make_diamond() * 1.3, style.PAPER, style.BOUNDARY))
    if any(d.marks for d in drawings):
        bar = np.array([[-1.2, -0.35], [1.2, -0.35], [1.2, 0.35], [-1.2, 0.35]])
        entries.append(("stroke", bar, style.STROKE, style.STROKE))
    # The exact width of a text needs a renderer; DejaVu Sans is about 0.6 as wide as high.
    widths = [size * (2.4 + 0.6 * len(text)) for text, *_ in entries]
    at = x - (sum(widths) - size) / 2.0
    radius = 0.36 * size
    for (text, shape, face, line), width in zip(entries, widths, strict=True):
        marker = shape * radius + (at + radius, y + radius)
        canvas.polygons(marker[None], face=face, line=line, width=0.7)
        canvas.text(at + 3.3 * radius, y, text, size, colour=style.FAINT_TEXT, align="left")
        at += width
