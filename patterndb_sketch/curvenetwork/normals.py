"""Normals of the surface along drawn curves, carried over to the curves of the network.

A program that draws on a model, or by hand over a plane, knows how the surface lies along a curve.
Joining cuts curves at nodes and moves their ends: the normals follow by where they were drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError, Step


def as_normals(normals: ArrayLike, points: ArrayLike, name: str) -> Points:
    """(k, 3) normals of a curve's points at length 1.

    Raises InvalidNetworkError, naming the curve, unless there is one of finite length above 0 for
    every point.
    """
    given = as_points(normals, f"the normals of {name}", InvalidNetworkError)
    wanted = len(np.asarray(points))
    if len(given) != wanted:
        raise InvalidNetworkError(
            f"{name} has {wanted} points and {len(given)} normals; give one normal for each point"
        )
    lengths = np.linalg.norm(given, axis=1)
    if not (np.isfinite(lengths) & (lengths > 0.0)).all():
        at = int(np.argmin(np.isfinite(lengths) & (lengths > 0.0)))
        raise InvalidNetworkError(
            f"normal {at} of {name} is {given[at].tolist()}, which has no direction; give another"
        )
    return given / lengths[:, None]


def carry_normals(
    network: CurveNetwork,
    drawn: Sequence[tuple[Points, Points | None]],
    walks: Sequence[Sequence[Step]],
) -> CurveNetwork:
    """Give the curves of a network the normals of the drawn ones that they are parts of.

    drawn: of every drawn curve its points (k, 3) and its normals (k, 3), or None. walks: for each
    the steps along the network that it became. Of two drawn curves that became one the first
    counts. A point has the normal of the nearest place of its drawn curve.
    """
    curves = list(network.curves)
    done: set[int] = set()
    for (points, normals), walk in zip(drawn, walks, strict=True):
        for curve, _ in walk:
            if normals is not None and curve not in done:
                done.add(curve)
                found = find_nearest_normals(points, normals, curves[curve].points)
                curves[curve] = replace(curves[curve], normals=found)
    return replace(network, curves=tuple(curves)) if done else network


def sample_normals(points: Points, normals: Points, at: Points) -> Points:
    """(m, 3) the normals of a curve (k, 3) at samples (m, 3) of it, first to last."""
    along, wanted = arc_length(points), arc_length(at)
    share = wanted * (along[-1] / wanted[-1])
    return _normalise(np.stack([np.interp(share, along, part) for part in normals.T], axis=1))


def find_nearest_normals(points: Points, normals: Points, at: Points) -> Points:
    """(m, 3) the normals (k, 3) of a polyline (k, 3) at its places nearest to points (m, 3)."""
    steps = np.diff(points, axis=0)
    squared = np.maximum((steps**2).sum(axis=1), 1e-300)
    found = np.empty_like(at)
    for i, place in enumerate(at):
        share = np.clip(((place - points[:-1]) * steps).sum(axis=1) / squared, 0.0, 1.0)
        gaps = ((points[:-1] + share[:, None] * steps - place) ** 2).sum(axis=1)
        k = int(gaps.argmin())
        found[i] = (1.0 - share[k]) * normals[k] + share[k] * normals[k + 1]
    return _normalise(found)


def _normalise(normals: Points) -> Points:
    """Normals at length 1; where opposite ones cancel, any across neither is as good as another."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(lengths > 1e-12, normals, (0.0, 0.0, 1.0)) / np.where(
        lengths > 1e-12, lengths, 1
    )
