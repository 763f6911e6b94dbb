"""Models with creases that go round: a can's rim, and the edges of a ring of square section."""

from __future__ import annotations

import numpy as np

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface


def revolve(profile: Points, count: int, *, closed: bool) -> Surface:
    """Triangles of a profile (k, 2) of radii and heights, turned about z; closed: a polygon."""
    k = len(profile)
    turn = np.arange(count) * 2.0 * np.pi / count
    points = np.array([(r * np.cos(a), r * np.sin(a), z) for a in turn for r, z in profile])
    i, j = np.meshgrid(np.arange(count), np.arange(k - (not closed)), indexing="ij")
    here, there = i.ravel() * k, (i.ravel() + 1) % count * k
    low, high = j.ravel(), (j.ravel() + 1) % k
    quads = here + low, there + low, there + high, here + high
    return Surface.from_soup(
        PolygonMesh.from_faces(
            points,
            np.concatenate([np.stack(quads[:3], 1), np.stack([quads[0], *quads[2:]], 1)]),
        )
    )


def can() -> Surface:
    """A cylinder of radius 1 with a lid at z = 1, whose rim is a crease of a right angle."""
    profile = [(1e-4, 1.0), (0.5, 1.0), (1.0, 1.0), (1.0, 0.5), (1.0, 0.0), (1.0, -1.0)]
    return revolve(np.array(profile), 96, closed=False)


def torus() -> Surface:
    """Round but for a crease on its top, at radius 1: two arcs that meet there at an angle."""
    turn = np.linspace(np.radians(110.0), np.radians(430.0), 41)
    section = 0.4 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    # The ends of the open section meet in an apex above its middle.
    apex = [0.0, 0.4 / np.sin(np.radians(70.0))]
    profile = np.concatenate([section, [apex]])
    return revolve(profile - apex + [1.0, 0.0], 96, closed=True)


def rim() -> Points:
    """(k, 3) the crease of the can, closed."""
    turn = np.linspace(0.0, 2.0 * np.pi, 2001)
    return np.stack([np.cos(turn), np.sin(turn), np.ones(2001)], axis=1)


def top() -> Points:
    """(k, 3) the crease of the torus, closed."""
    return rim() * [1.0, 1.0, 0.0]


def ring(model: Surface, crease: Points, clicks: int, start: float, off: float) -> Points:
    """(clicks, 3) places about a crease around z, up to ``off`` beside it, on the model."""
    share = (start + np.arange(clicks)) / clicks % 1.0
    feet = crease[np.round(share * (len(crease) - 1)).astype(np.int64)]
    wobble = off * np.sin(2.4 * np.arange(clicks))
    outwards = feet * [1.0, 1.0, 0.0]
    beside = feet + np.where(wobble > 0.0, -wobble, 0.0)[:, None] * outwards
    beside[:, 2] += np.minimum(wobble, 0.0)
    return model.nearest(beside).points
