"""Car-like bodies that tests share, and how far points are from them."""

from __future__ import annotations

from functools import cache

import numpy as np
from bodies import Body, body, random_body
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface

#: Resolution of the bodies that all tests share.
COARSE = 0.5

#: Bodies that differ most: one with three boxes, with one, with a bed, with sharp edges, and one
#: that lies between the named ones.
NAMES = ["sedan", "van", "pickup", "off-roader", "random 0"]


@cache
def made(name: str, whole: bool = False) -> Body:
    if name.startswith("random"):
        return random_body(int(name.split()[1]), COARSE, whole)
    return body(name, COARSE, whole)


def directed(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)


def winding(surface: Body, points: Points) -> Points:
    """How often a closed body winds around points: 1 inside, 0 outside."""
    corners = [surface.points[surface.triangles[:, k]] for k in range(3)]
    result = np.zeros(len(points))
    for i, point in enumerate(points):
        a, b, c = (corner - point for corner in corners)
        la, lb, lc = (np.linalg.norm(one, axis=1) for one in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        low = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        result[i] = np.arctan2(top, low).sum() / (2.0 * np.pi)
    return result


def near(half: Body, points: Points) -> Points:
    """Distances of points to the clean body."""
    surface = Surface.from_arrays(half.points, half.triangles)
    return np.linalg.norm(surface.nearest(points).points - points, axis=1)


def sagitta(half: Body) -> float:
    """What edges of the clean mesh and of a patch may cut off, in metres."""
    return 0.0025 * half.diagonal
