"""From where a fill is looked at: a camera without perspective."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points

#: Radians that a drag of one point turns the view.
TURN = 0.008


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What lies where in the picture.

    axes:  (3, 3) float64, orthonormal rows: to the right, up, and towards the viewer.
    focus: (3,) float64, what is seen in the middle.
    scale: points of the picture to a unit of space.

    Places in the picture are in points from its middle, x to the right and y up.
    """

    axes: Points
    focus: Points
    scale: float

    @classmethod
    def facing(cls, points: Points, toward: Points, radius: float) -> View:
        """Looking against ``toward`` (3,), with points (n, 3) within ``radius`` of the middle."""
        size = float(np.linalg.norm(toward))
        z = toward / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        # Most meshes stand along y; looked at from above, their back is up.
        up = np.array([0.0, 1.0, 0.0]) if abs(z[1]) < 0.9 else np.array([0.0, 0.0, -z[1]])
        x = np.cross(up, z)
        x /= np.linalg.norm(x)
        axes = np.stack([x, np.cross(z, x), z])
        flat = points @ axes.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        reach = float(np.abs(high - low)[:2].max()) / 2.0
        focus = axes.T @ ((low + high) / 2.0)
        return cls(axes, focus, radius / reach if reach > 0.0 else 1.0)

    def seen(self, points: Points) -> Points:
        """(..., 3) x, y and nearness to the viewer, in points of the picture."""
        return (points - self.focus) @ (self.axes.T * self.scale)

    def under(self, x: float, y: float) -> Points:
        """(3,) a point of space that is seen at (x, y), as near as the focus."""
        return self.focus + (x * self.axes[0] + y * self.axes[1]) / self.scale

    def turned(self, dx: float, dy: float) -> View:
        """After a drag: the thing turns the way the pointer goes."""
        return replace(self, axes=_about(1, -dx * TURN) @ (_about(0, dy * TURN) @ self.axes))

    def rolled(self) -> View:
        """A quarter turn about the line of sight."""
        return replace(self, axes=_about(2, math.pi / 2.0) @ self.axes)

    def moved(self, dx: float, dy: float) -> View:
        """What was in the middle goes to (dx, dy)."""
        return replace(self, focus=self.under(-dx, -dy))

    def zoomed(self, factor: float, x: float = 0.0, y: float = 0.0) -> View:
        """Larger by a factor, what is at (x, y) staying there."""
        at = self.under(x, y)
        return replace(self, focus=at + (self.focus - at) / factor, scale=self.scale * factor)


def _about(axis: int, angle: float) -> Points:
    """The rotation of space about one of the view's own axes."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, s, -s, c
    return turn
