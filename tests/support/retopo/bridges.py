"""A surface with a tiny feature: a thin handle between two places of a sheet, both feet fused
in."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial import Delaunay

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface

#: Half of the sheet's side, and where the feet are, left and right of the middle.
HALF, FOOT = 1.0, 0.4

#: Radius of the handle: 0.25 % of the diagonal.
THIN = 0.0025 * np.hypot(2 * HALF, 2 * HALF)

#: Points around the handle, and rings along it.
AROUND, ALONG = 24, 160


def ring(radius: float, n: int = AROUND) -> Points:
    """(n, 2) points of a circle, counter-clockwise."""
    turn = 2 * np.pi * np.arange(n) / n
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


@cache
def bridge() -> Surface:
    """A square sheet, finer towards two round holes, and half a ring of a tube between them."""
    radii = THIN * 1.35 ** np.arange(13)
    near = [ring(r) + np.array([x, 0.0]) for x in (-FOOT, FOOT) for r in radii]
    lattice = np.stack(np.meshgrid(*[np.linspace(-HALF, HALF, 41)] * 2), axis=-1).reshape(-1, 2)
    far = np.min([np.hypot(*(lattice - (x, 0.0)).T) for x in (-FOOT, FOOT)], axis=0) > radii[-1]
    flat = np.concatenate([*near, lattice[far]])
    corners = Delaunay(flat).simplices
    middle = flat[corners].mean(axis=1)
    hole = np.min([np.hypot(*(middle - (x, 0.0)).T) for x in (-FOOT, FOOT)], axis=0) < THIN
    a, b, c = (flat[corners[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    corners = np.where(turned[:, None], corners[:, ::-1], corners)[~hole]
    # The tube: from the left hole's rim over the sheet to the right one's, mirrored.
    first = np.arange(AROUND)
    last = AROUND * len(radii) + (AROUND // 2 - first) % AROUND
    rows = [first]
    points = [np.c_[flat, np.zeros(len(flat))]]
    for k in range(1, ALONG):
        angle = np.pi * k / ALONG
        out = FOOT - ring(THIN)[:, 0]
        points.append(
            np.stack([-out * np.cos(angle), ring(THIN)[:, 1], out * np.sin(angle)], axis=1)
        )
        rows.append(len(flat) + AROUND * (k - 1) + first)
    rows.append(last)
    low, high = np.array(rows[:-1]), np.array(rows[1:])
    low_next, high_next = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    tube = np.stack(
        [np.stack([low, low_next, high_next], -1), np.stack([low, high_next, high], -1)]
    ).reshape(-1, 3)
    return Surface.from_arrays(np.concatenate(points), np.concatenate([corners, tube])).orient()
