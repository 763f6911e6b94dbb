"""The shape of a head without nose, lips and ears: rounded solids, joined with fillets.

Decimetres: x to the head's left, y up, z forwards; the origin lies between the eyes, inside the
skull.
"""

from __future__ import annotations

import numpy as np
from modelling import Points


def ellipsoid(
    p: Points, centre: tuple[float, float, float], radii: tuple[float, float, float]
) -> Points:
    """An approximate signed distance of points (n, 3) to an ellipsoid, exact in sign."""
    q = (p - centre) / radii
    near = np.linalg.norm(q, axis=1)
    return near * (near - 1.0) / np.maximum(np.linalg.norm(q / radii, axis=1), 1e-9)


def capsule(p: Points, a: tuple[float, ...], b: tuple[float, ...], ra: float, rb: float) -> Points:
    """The signed distance to a bar from ``a`` to ``b`` whose radius runs from ``ra`` to ``rb``."""
    start, axis = np.array(a), np.array(b) - np.array(a)
    t = np.clip((p - start) @ axis / (axis @ axis), 0.0, 1.0)
    return np.linalg.norm(p - start - t[:, None] * axis, axis=1) - (ra + (rb - ra) * t)


def join(a: Points, b: Points, radius: float) -> Points:
    """The union of two shapes with a fillet."""
    h = np.maximum(radius - np.abs(a - b), 0.0) / radius
    return np.minimum(a, b) - h * h * radius / 4


def cut(a: Points, b: Points, radius: float) -> Points:
    """The first shape without the second, with a fillet."""
    return -join(-a, b, radius)


def skull(points: Points) -> Points:
    """A rough signed distance of points (n, 3) to the head, negative inside."""
    p = points.copy()
    p[:, 0] = np.abs(p[:, 0])
    # Cranium, face, jaw, chin, neck, brow, cheekbone, eye socket, eyeball, bridge of the nose,
    # mouth.
    d = ellipsoid(p, (0.0, 0.32, -0.10), (0.73, 0.78, 0.93))
    d = join(d, ellipsoid(p, (0.0, -0.25, 0.25), (0.58, 0.78, 0.60)), 0.25)
    d = join(d, ellipsoid(p, (0.0, -0.70, 0.30), (0.43, 0.42, 0.52)), 0.25)
    d = join(d, capsule(p, (0.0, -0.97, 0.77), (0.08, -0.97, 0.75), 0.14, 0.13), 0.20)
    d = join(d, capsule(p, (0.0, -0.4, -0.32), (0.0, -1.8, -0.42), 0.46, 0.44), 0.20)
    d = join(d, capsule(p, (0.10, 0.18, 0.72), (0.40, 0.23, 0.54), 0.14, 0.11), 0.20)
    d = join(d, ellipsoid(p, (0.42, -0.27, 0.46), (0.20, 0.20, 0.20)), 0.25)
    d = cut(d, ellipsoid(p, (0.32, -0.02, 0.93), (0.15, 0.12, 0.17)), 0.20)
    d = join(d, ellipsoid(p, (0.312, 0.0, 0.60), (0.155, 0.155, 0.155)), 0.04)
    d = join(d, capsule(p, (0.0, 0.10, 0.80), (0.0, -0.20, 0.95), 0.05, 0.05), 0.15)
    return join(d, ellipsoid(p, (0.0, -0.66, 0.63), (0.26, 0.24, 0.25)), 0.25)


def trace(points: Points, axis: int) -> Points:
    """Points (n, 3) outside the skull moved down an axis until they hit it (sphere tracing)."""
    p = points.copy()
    for _ in range(120):
        p[:, axis] -= 0.6 * skull(p)  # the distance is rough: short of it, not past it
    return p


def drop(xy: Points) -> Points:
    """Points (n, 2) of the front view on the face, (n, 3): the first hit from in front."""
    return trace(np.column_stack([xy, np.full(len(xy), 1.6)]), 2)
