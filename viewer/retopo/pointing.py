"""What is seen at a place of the picture: the surface, curves on it, and their ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from viewer.camera import UPRIGHT, ModelCamera, View

#: The pointer's way is cut into steps of so many points: a quick stroke stays on the surface.
STEP = 3.0

#: What lies deeper than the surface by this part of its diagonal is hidden.
BENEATH = 0.004


def pick_surface(view: View, surface: Surface, places: ArrayLike) -> SurfacePoints:
    """Pick the front-most points of the surface at places (n, 2) of the picture, in points from its
    middle."""
    toward = view.axes[2]
    at = np.asarray(places, np.float64).reshape(-1, 2)
    on = view.focus + at @ view.axes[:2] / view.scale
    box = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
    reach = 1.01 * surface.diagonal + float(np.abs((box.mean(axis=0) - view.focus) @ toward))
    return surface.cast_along(
        on + reach * toward,
        np.tile(toward, (len(at), 1)),
        np.full(len(at), 2.0 * reach),
    )


def pick_foot(view: View, surface: Surface, x: float, y: float) -> SurfacePoints | None:
    """Pick the front-most point of the surface at a place of the picture, as one foot."""
    feet = pick_surface(view, surface, [[x, y]])
    return feet if feet.found[0] else None


def pick_line(
    view: View, surface: Surface, last: tuple[float, float], now: tuple[float, float]
) -> Points:
    """Pick (k, 3) points of the surface along the pointer's way from one place to another, the last
    place included and the first not."""
    steps = max(1, round(float(np.hypot(now[0] - last[0], now[1] - last[1])) / STEP))
    share = (np.arange(1, steps + 1) / steps)[:, None]
    feet = pick_surface(view, surface, np.array(last) + share * (np.array(now) - np.array(last)))
    return feet.points[feet.found]


def find_visible(view: View, surface: Surface, points: Points) -> NDArray[np.bool_]:
    """Find (n,) which of points (n, 3) near the surface it does not hide."""
    if not len(points):
        return np.zeros(0, np.bool_)
    feet = pick_surface(view, surface, view.seen(points)[:, :2])
    before = (feet.points - points) @ view.axes[2]
    return ~feet.found | (before <= BENEATH * surface.diagonal)


#: From where a surface is looked at, by the axis that is upright: over its left front.
HOME = {"y": (0.62, 0.36, 1.0), "z": (-0.62, -1.0, 0.36), "x": (0.36, 1.0, 0.62)}


#: Sides that a surface is looked at from, by name; "home" is over its left front, as at first.
VIEW_SIDES = ("home", "front", "back", "left", "right", "top", "bottom")


def find_side(upright: str, side: str) -> tuple[float, float, float]:
    """Find the direction from a surface to who looks at it from a side; the front is the side that
    is nearest to where it is looked at from at first. Raises ValueError for no side."""
    if side not in VIEW_SIDES:
        raise ValueError(f"there is no side {side!r}; there are {', '.join(VIEW_SIDES)}")
    if side == "home":
        return HOME[upright]
    up = np.eye(3)["xyz".index(upright)]
    front = {"x": (0.0, 1.0, 0.0), "y": (0.0, 0.0, 1.0), "z": (0.0, -1.0, 0.0)}[upright]
    right = np.cross(up, front)
    way = {
        "front": np.array(front),
        "back": -np.array(front),
        "left": -right,
        "right": right,
        "top": up,
        "bottom": -up,
    }[side]
    x, y, z = way.tolist()
    return x, y, z


class RetopoCamera(ModelCamera):
    """A camera around a surface, which looks along directions of space.

    upright: the axis that is at first.
    """

    def __init__(self, points: Points, upright: str = "y") -> None:
        super().__init__(points, HOME[upright], upright)

    def next_upright(self) -> None:
        """Another axis is upright."""
        self.upright = UPRIGHT[(UPRIGHT.index(self.upright) + 1) % len(UPRIGHT)]
        self.fit()

    def look_along(self, direction: ArrayLike) -> None:
        """Look against a direction (3,), of space; from the other side if that is so already."""
        toward = np.array(direction, np.float64)
        toward /= np.linalg.norm(toward)
        self.look_from(-toward if np.allclose(self.view.axes[2], toward) else toward)

    def look_from(self, direction: ArrayLike) -> None:
        """Look against a direction (3,), of space, of any length."""
        toward = np.array(direction, np.float64)
        self._toward = toward / np.linalg.norm(toward)
        self.aim(self.fit_all())

    def fit(self) -> None:
        """The whole surface into the middle, as it was seen at first."""
        self._toward = np.array(HOME[self.upright])
        self.view = self.fit_all()
        self._moved = False
