"""A model made ready to be drawn: smooth where it is smooth, whatever the sense of its faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb._native.viewer.skin import blended
from patterndb._native.viewer.skin import seen as _seen
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from viewer import style
from viewer.camera import View
from viewer.solid import NOTHING, Triangles

#: Cosines of the angles between two faces up to which they are shaded as one smooth surface, and
#: from which on there is a crease between them: 28 and 46 degrees. Between, a bit of both.
SMOOTH, CREASED = float(np.cos(np.radians(28.0))), float(np.cos(np.radians(46.0)))


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """A model's triangles as they are shaded.

    corners: (t, 3, 3) float64. normals: (t, 3, 3) float64 unit normals at the corners, all on the
    side that the triangle's own corners give it; zeros where a triangle has no area.
    """

    corners: Points
    normals: Points

    @classmethod
    def of(cls, corners: Points, triangles: Int32Array) -> Skin:
        """Of triangles (t, 3) with corners (t, 3, 3), which know no inside and no outside."""
        return cls(corners, smooth_normals(corners, triangles))


def smooth_normals(corners: Points, triangles: Int32Array) -> Points:
    """Find (t, 3, 3) unit normals at the corners (t, 3, 3) of triangles (t, 3), smoothed.

    At each corner the mean, by area, of the triangles around that lie nearly flat beside its
    own; those that look the other way count as if they were turned.
    """
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(own, axis=1)
    unit = own / np.where(area > 0.0, area, 1.0)[:, None]
    order = np.argsort(triangles.ravel(), kind="stable")
    count = np.bincount(triangles.ravel())
    offsets = np.concatenate([[0], np.cumsum(count)])
    around = (order // 3).astype(np.int32)
    return blended(np.ascontiguousarray(triangles), offsets, around, unit, area, SMOOTH, CREASED)


# A model as it is seen: matte, lit from both sides alike, a little darker towards its edges.

MATTE = "#eceef0"

#: Where the light comes from, seen by the viewer: much of it from the upper left, and some from
#: the other side.
KEY = np.array([-0.38, 0.6, 0.7]) / np.linalg.norm([-0.38, 0.6, 0.7])
FILL = np.array([0.7, 0.1, 0.5]) / np.linalg.norm([0.7, 0.1, 0.5])

#: How bright is what no light reaches, and what each light adds.
AMBIENT, OF_KEY, OF_FILL = 0.56, 0.36, 0.14

#: How much darker a surface is that is seen edge on.
EDGE = 0.28

#: White that a model one can see through is mixed with, and how far it is behind all else: so
#: many times its depth, and so many points.
FADED, BEHIND = 0.62, (4.0, 100.0)


class Shading:
    """The triangles of a model in their colours; made anew only if the view has changed."""

    def __init__(self) -> None:
        self._skin: Skin | None = None
        self._view: View | None = None
        self._rest: tuple[object, ...] = ()
        self._made: Triangles = NOTHING

    def model(self, skin: Skin, view: View, look: str, middle: tuple[float, float]) -> Triangles:
        """look: solid, through or hidden. middle: of the view, in points of the picture."""
        if look == "hidden":
            return NOTHING
        if skin is not self._skin or view is not self._view or self._rest != (look, middle):
            self._skin, self._view, self._rest = skin, view, (look, middle)
            self._made = shade_model(skin, view, middle, through=look == "through")
        return self._made


def shade_model(skin: Skin, view: View, middle: tuple[float, float], *, through: bool) -> Triangles:
    """Shade corners (t, 3, 3) as they are seen, float64, and their colours (t, 3, 3) float32.

    through: the model is pale and behind everything else.
    """
    corners, normals = np.ascontiguousarray(skin.corners), np.ascontiguousarray(skin.normals)
    seen, bright = _seen(
        corners, normals, view.axes, view.focus, view.scale, KEY, FILL,
        (AMBIENT, OF_KEY, OF_FILL, EDGE),
    )  # fmt: skip
    colours = bright[..., None] * style.parse_colour(MATTE).astype(np.float32)
    np.minimum(colours, np.float32(1.0), out=colours)
    shift = np.array([*middle, 0.0])
    if through:
        colours += np.float32(FADED) * (np.float32(1.0) - colours)
        shift[2] -= BEHIND[0] * float(np.ptp(seen[..., 2])) + BEHIND[1]
    seen += shift
    return seen, colours
