"""Strips bent around an axis, and how near to their pipe a method surfaces them."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.joining import network_of_polylines
from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing import find_cycles, surface
from query.placing import Surface
from tests.support.surfacing.surfacedistance import distance

#: Points of an arc as it is drawn, and columns of the true surface.
DRAWN, FINE = 65, 513


def bend_strip(degrees: float, height: float, columns: int) -> Points:
    """(2, columns, 3) the strip's lower and upper arc."""
    angle = np.radians(degrees) * np.linspace(0.0, 1.0, columns)
    arc = np.stack([np.cos(angle), np.sin(angle), np.zeros(columns)], axis=1)
    return np.stack([arc, arc + np.array([0.0, 0.0, height])])


def draw_strip(degrees: float, height: float) -> CurveNetwork:
    """The four curves of a strip, joined."""
    low, high = bend_strip(degrees, height, DRAWN)
    return network_of_polylines(
        [low, high, np.stack([low[0], high[0]]), np.stack([low[-1], high[-1]])]
    )


def measure_strip(degrees: float, height: float, method: str) -> tuple[float, str] | None:
    """The mean distance of a method's surface to the true one, per diagonal, and who answered.

    None where there is no cycle, or more than one.
    """
    network = draw_strip(degrees, height)
    cycles = find_cycles(network).cycles
    if len(cycles) != 1:
        return None
    made = surface(network, cycles, method=method)
    low, high = bend_strip(degrees, height, FINE)
    at = np.arange(FINE - 1)
    quads = np.stack([at, at + 1, FINE + at + 1, FINE + at], axis=1)
    true = Surface.from_arrays(
        np.concatenate([low, high]), np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    )
    apart = distance(Surface.from_arrays(made.points, made.triangles), true).mean
    return apart / network.diagonal, str(made.patches[0].method)
