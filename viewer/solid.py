"""Shaded triangles of a picture: a surface, and a fill on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from query.placing import Surface
from viewer import style
from viewer.net import Net
from viewer.raster import Grid, farthest_nearby, paint
from viewer.view import View

SURFACE = "#c3ccd6"
SURFACE_BACK = "#97a2ae"
FILL = "#fff8ea"
FILL_BACK = "#d6ccb6"
CARRIED = "#ffcb80"

#: Where the light comes from, seen by the viewer; how bright is what it does not reach, of a
#: surface and of a fill, whose lines must stand out; and how much it brightens: what faces the
#: viewer is as good as fully lit.
LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])
SHADE = 0.62
FILL_SHADE = 0.78
LIT = 1.15

#: A fill's pieces cut through the surface's triangles: it is painted nearer by this part of an
#: edge, and by so many points at least.
LIFT = (0.12, 2.0)

#: What lies so far behind the nearest thing around, in lifts, is hidden.
HIDDEN = 2.5

#: Points to a pixel of the buffer that says what is hidden.
COARSE = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Triangles as they are seen.

    corners: (t, 3, 3) float64 x, y in points from the picture's lower left, and nearness.
    colours: (t, 3, 3) float32, 0 to 1, of the corners.
    lift:    points by which the fill is nearer than it is.
    """

    corners: Points
    colours: Grid
    lift: float

    @classmethod
    def of(
        cls, view: View, middle: tuple[float, float], surface: Surface | None, net: Net | None
    ) -> Solid:
        """A surface and a fill, either of which may be missing; middle: of the view."""
        corners: list[Points] = [np.zeros((0, 3, 3))]
        colours: list[Grid] = [np.zeros((0, 3, 3), np.float32)]
        shift = np.array([*middle, 0.0])
        lift = LIFT[1]
        if surface is not None:
            seen = (view.seen(surface.vertices) + shift)[surface.triangles]
            normals = (surface.normals @ view.axes.T)[surface.triangles]
            corners.append(seen)
            base, back = style.rgb(SURFACE), style.rgb(SURFACE_BACK)
            colours.append(_shaded(seen, normals, base, back, SHADE))
        if net is not None:
            lift = max(LIFT[0] * net.edge * view.scale, LIFT[1])
            seen = _triangles(view.seen(net.patches) + shift + (0.0, 0.0, lift))
            normals = _triangles(net.normals @ view.axes.T)
            base = np.tile(style.rgb(FILL), (len(net.patches), 1))
            base[net.carried] = style.rgb(CARRIED)
            each = np.repeat(base, len(seen) // max(len(net.patches), 1), axis=0)
            corners.append(seen)
            colours.append(_shaded(seen, normals, each[:, None], style.rgb(FILL_BACK), FILL_SHADE))
        return cls(np.concatenate(corners), np.concatenate(colours), lift)

    def image(self, width: float, height: float, scale: float) -> tuple[Grid, Grid]:
        """Painted on white: (h, w, 3) float32 colours and (h, w) nearness, -inf where nothing
        is. width, height: in points; scale: pixels to a point."""
        rows, columns = round(height * scale), round(width * scale)
        depth = np.full((rows, columns), -np.inf, np.float32)
        image = np.tile(style.rgb(style.PAPER).astype(np.float32), (rows, columns, 1))
        pixels = self.corners * (scale, -scale, 1.0) + (0.0, rows, 0.0)
        paint(pixels, self.colours, depth, image)
        return image, depth


class Hiding:
    """What of a picture is hidden behind a solid."""

    def __init__(self, solid: Solid, width: float, height: float) -> None:
        depth = solid.image(width, height, 1.0 / COARSE)[1]
        self._nearest = farthest_nearby(depth)
        self._slack = HIDDEN * solid.lift

    def visible(self, points: Points) -> NDArray[np.bool_]:
        """(...) which of (..., 3) seen points are not hidden, and within the picture."""
        rows, columns = self._nearest.shape
        j = np.floor(points[..., 0] / COARSE).astype(np.int64)
        i = np.floor(rows - points[..., 1] / COARSE).astype(np.int64)
        inside = (i >= 0) & (i < rows) & (j >= 0) & (j < columns)
        nearest = self._nearest[np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)]
        return inside & (points[..., 2] >= nearest - self._slack)


def _shaded(seen: Points, normals: Points, front: Points, back: Points, shade: float) -> Grid:
    """(t, 3, 3) colours of triangles (t, 3, 3) with normals at their corners."""
    a, b, c = (seen[:, e, :2] for e in range(3))
    along, across = b - a, c - a
    away = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] < 0.0
    normals = np.where(away[:, None, None], -normals, normals)
    base = np.where(away[:, None, None], back, front)
    bright = shade + (1.0 - shade) * np.clip(LIT * (normals @ LIGHT), 0.0, 1.0)
    return (base * bright[..., None]).astype(np.float32)


def _triangles(patches: Points) -> Points:
    """(q * 2 (n - 1)**2, 3, 3) triangles of patches (q, n, n, 3), those of a patch together."""
    a, b = patches[:, :-1, :-1], patches[:, 1:, :-1]
    c, d = patches[:, 1:, 1:], patches[:, :-1, 1:]
    both = np.stack([np.stack([a, b, c], axis=3), np.stack([a, c, d], axis=3)], axis=3)
    return both.reshape(-1, 3, 3)
