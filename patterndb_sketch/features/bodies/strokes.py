"""Rough strokes along features, as users draw them."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.bodies.body import Body
from patterndb_sketch.features.errors import InvalidFeatureError

#: A stroke has from FEWEST to MOST points, and begins and ends within this share of the length.
FEWEST, MOST = 4, 8
ENDS = 0.03


def stroke(body: Body, feature: str, error: float = 0.01, seed: int = 0) -> Points:
    """(k, 3) float64 points on the clean body near a feature, 4 to 8 of them in order.

    error: the greatest distance from the feature across it, as a share of the diagonal; a point
           is as far as a number drawn evenly up to it, then moves to the nearest surface point,
           which is nowhere farther from its foot on the feature than twice the error.
    Raises InvalidFeatureError for an unknown or hidden feature, or an error out of 0 to 0.1.
    """
    curve = body.feature(feature)
    if curve.kind == "hidden":
        raise InvalidFeatureError(f"the curve {feature!r} is hidden: nobody can draw along it")
    if not 0.0 <= error <= 0.1:
        raise InvalidFeatureError(f"the error {error} is not between 0 and 0.1 of the diagonal")
    rng = np.random.default_rng(seed)
    count = int(rng.integers(FEWEST, MOST + 1))
    total = float(arc_length(curve.points)[-1])
    inner = (np.arange(1, count - 1) + rng.uniform(-0.3, 0.3, count - 2)) / (count - 1)
    shares = np.r_[rng.uniform(0.0, ENDS), inner, 1.0 - rng.uniform(0.0, ENDS)]
    feet = at_lengths(curve.points, shares * total)
    step = 1e-3 * total
    ahead = at_lengths(curve.points, shares * total + step)
    behind = at_lengths(curve.points, shares * total - step)
    tangents = (ahead - behind) / np.linalg.norm(ahead - behind, axis=1, keepdims=True)
    across = rng.normal(size=(count, 3))
    across -= np.einsum("ij,ij->i", across, tangents)[:, None] * tangents
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    sizes = error * body.diagonal * rng.uniform(0.0, 1.0, count)
    surface = Surface.from_arrays(body.points, body.triangles)
    return surface.nearest(feet + sizes[:, None] * across).points
