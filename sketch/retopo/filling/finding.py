"""Finding: which patch a point of the ground is in."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from query.placing import enclosed
from sketch.retopo.errors import RefusedError
from sketch.retopo.ground import Ground
from sketch.retopo.network import Network, outline


def patch_at(network: Network, ground: Ground, point: ArrayLike) -> int:
    """The patch that a point (3,) of the ground is in.

    Patches are tried in the order of how near their borders are; the ground within each is
    flooded until one has the point's triangle. Raises RefusedError if none has.
    """
    foot = ground.nearest(np.asarray(point, np.float64)[None])
    triangle = ground.triangles[foot.triangles[0]]
    away = []
    for patch in network.patches.values():
        points, _ = outline(network, patch.loop)
        away.append((float(np.linalg.norm(points - foot.points[0], axis=1).min()), patch.id))
    best: int | None = None
    for _, patch in sorted(away):
        points, _ = outline(network, network.patches[patch].loop)
        inside = enclosed(ground.surface, points)
        if not inside.separates:
            continue
        own = (inside.surface.triangles == triangle).all(axis=1)
        if not own.any():
            continue
        if np.isnan(inside.around[own]).all():
            return patch
        # On a triangle that the border crosses: this patch unless another has it within.
        best = patch if best is None else best
    if best is None:
        raise RefusedError("there is no patch here; point into one")
    return best
