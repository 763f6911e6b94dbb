"""Density on both sides of a plane of symmetry: every brush stroke with its image."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from patterndb_sketch.retopo.network import Density, Paint
from patterndb_sketch.retopo.symmetry.half import Plane

#: An image that is this near to a line of the brush, in its radii, is that line.
SAME = 1e-9


def mirror_paint(stroke: Paint, plane: Plane) -> Paint:
    """A brush stroke along its lines and their images, each once.

    One stroke, not two: where both sides of it overlap, at the plane, it has its effect once.
    """
    image = replace(
        stroke,
        starts=plane.mirror(stroke.starts),
        ends=plane.mirror(stroke.ends),
        normals=plane.mirror_directions(stroke.normals),
    )
    there = np.concatenate([stroke.starts, stroke.ends], axis=1)
    back = np.concatenate([stroke.ends, stroke.starts], axis=1)
    made = np.concatenate([image.starts, image.ends], axis=1)
    away, _ = KDTree(np.concatenate([there, back])).query(made)
    new = away > SAME * stroke.radius
    if not new.any():
        return stroke
    return stroke.joined(
        replace(image, starts=image.starts[new], ends=image.ends[new], normals=image.normals[new])
    )


def mirror_density(density: Density, plane: Plane) -> Density:
    """The density with all its strokes on both sides."""
    if not density.strokes:
        return density
    return Density(tuple(mirror_paint(one, plane) for one in density.strokes))
