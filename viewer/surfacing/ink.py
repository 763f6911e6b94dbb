"""A stroke while it is drawn on a surface with the pointer."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.inking import InkedStroke
from patterndb_sketch.surfacing.patch import Surfacing
from viewer.camera import View
from viewer.surfacing.body import SurfaceBody

#: A stroke is looked up on the surface every so many points of the picture, however fast the
#: pointer moves.
STEP = 3.0


class StrokePointer:
    """Draws on a body: rays so far, through places of the picture."""

    def __init__(self) -> None:
        self.lift()

    def lift(self) -> None:
        """Forget what was not finished."""
        self._origins: list[Points] = []
        self._directions: list[Points] = []
        self._last: tuple[float, float] | None = None

    @property
    def down(self) -> bool:
        """Has a stroke been begun?"""
        return self._last is not None

    def extend(self, view: View, x: float, y: float, reach: float) -> None:
        """The stroke goes on to here; reach: how far from the focus a ray begins."""
        places = np.array([[x, y]])
        if self._last is not None:
            way = np.hypot(x - self._last[0], y - self._last[1])
            if way < STEP:
                return
            share = np.linspace(0.0, 1.0, 1 + int(np.ceil(way / STEP)))[1:, None]
            places = np.array(self._last) * (1.0 - share) + places * share
        for place in places.tolist():
            origin, direction = cast_ray(view, place[0], place[1], reach)
            self._origins.append(origin)
            self._directions.append(direction)
        self._last = (x, y)

    def ink(self, surfacing: Surfacing, body: SurfaceBody) -> InkedStroke:
        """What has been drawn so far, on a surface; body: that of the surface."""
        origins, directions = np.stack(self._origins), np.stack(self._directions)
        hits = body.surface.cast_rays(origins, directions)
        runs = hits.list_runs()
        parts = tuple(hits.points[run] for run in runs)
        owners = tuple(body.owners[hits.triangles[run]] for run in runs)
        return InkedStroke(surfacing, parts, owners, int((~hits.found).sum()), len(origins))


def cast_ray(view: View, x: float, y: float, reach: float) -> tuple[Points, Points]:
    """Cast a ray: origin (3,) and direction (3,) of what is seen at a place of the picture."""
    toward = view.axes[2]
    return view.under(x, y) + reach * toward, -toward
