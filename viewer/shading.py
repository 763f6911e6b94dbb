"""A model as it is seen: matte, lit from both sides alike, a little darker towards its edges."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.kernels import kernel
from viewer import style
from viewer.raster import Grid
from viewer.ribbons import NOTHING, Triangles
from viewer.skin import Skin
from viewer.view import View

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
            self._made = shaded(skin, view, middle, through=look == "through")
        return self._made


def shaded(skin: Skin, view: View, middle: tuple[float, float], *, through: bool) -> Triangles:
    """Corners (t, 3, 3) as they are seen, float64, and their colours (t, 3, 3) float32.

    through: the model is pale and behind everything else.
    """
    seen, bright = _seen(
        skin.corners, skin.normals, view.axes, view.focus, view.scale, KEY, FILL,
        (AMBIENT, OF_KEY, OF_FILL, EDGE),
    )  # fmt: skip
    colours = bright[..., None] * style.rgb(MATTE).astype(np.float32)
    np.minimum(colours, np.float32(1.0), out=colours)
    shift = np.array([*middle, 0.0])
    if through:
        colours += np.float32(FADED) * (np.float32(1.0) - colours)
        shift[2] -= BEHIND[0] * float(np.ptp(seen[..., 2])) + BEHIND[1]
    seen += shift
    return seen, colours


@kernel
def _seen(
    corners: Points,
    normals: Points,
    axes: Points,
    focus: Points,
    scale: float,
    key: Points,
    fill: Points,
    lights: tuple[float, float, float, float],
) -> tuple[Points, Grid]:
    """Corners as they are seen, and how bright (t, 3) each is: a normal that points away from
    the side that is seen counts as if it were turned."""
    ambient, of_key, of_fill, edge = lights
    count = len(corners)
    seen = np.empty((count, 3, 3))
    bright = np.empty((count, 3), np.float32)
    normal = np.empty(3)
    for t in range(count):
        for c in range(3):
            for i in range(3):
                total = 0.0
                for k in range(3):
                    total += axes[i, k] * (corners[t, c, k] - focus[k])
                seen[t, c, i] = scale * total
        ax = seen[t, 1, 0] - seen[t, 0, 0]
        ay = seen[t, 1, 1] - seen[t, 0, 1]
        bx = seen[t, 2, 0] - seen[t, 0, 0]
        by = seen[t, 2, 1] - seen[t, 0, 1]
        side = -1.0 if ax * by - ay * bx < 0.0 else 1.0
        for c in range(3):
            for i in range(3):
                total = 0.0
                for k in range(3):
                    total += axes[i, k] * normals[t, c, k]
                normal[i] = side * total
            one = normal[0] * key[0] + normal[1] * key[1] + normal[2] * key[2]
            two = normal[0] * fill[0] + normal[1] * fill[1] + normal[2] * fill[2]
            value = ambient + of_key * min(max(one, 0.0), 1.0) + of_fill * min(max(two, 0.0), 1.0)
            rim = 1.0 - min(abs(normal[2]), 1.0)
            bright[t, c] = value * (1.0 - edge * rim * rim * rim)
    return seen, bright
