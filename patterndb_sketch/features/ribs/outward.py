"""Which side of a surface is outside, where triangles do not tell."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.features.model import Model

#: Directions that are looked along from a point, and points looked from for all ribs at once.
DIRECTIONS, PROBES = 32, 24

#: How far a point may lie below what is seen, as a share of the ribs' radius: sheets lie doubled.
SUNK = 0.02

#: Cosine between the normals of neighbouring ribs from which they tell which sides correspond.
SURE = 0.3


def signs(model: Model, feet: Points, normals: Points, radius: float) -> NDArray[np.float64]:
    """(m,) +1 or -1: the signs that make normals (m, 3) at feet (m, 3), on the surface and in the
    order of a curve, point out.

    Outside is where more of the world is seen: lines are drawn to a point from afar, from
    DIRECTIONS sides, and those count that meet nothing before it. Neighbours within the radius
    whose normals are nearly parallel share their votes, so that a curve has one outside even
    where clutter misleads the votes of some points. Where nothing is seen, or as much on both
    sides, outside is away from the middle of the model's box.
    """
    m = len(feet)
    relative = np.ones(m)
    cosine = np.einsum("ij,ij->i", normals[1:], normals[:-1])
    apart = np.linalg.norm(np.diff(feet, axis=0), axis=1) > radius
    breaks = np.r_[True, apart | (np.abs(cosine) < SURE)]
    relative[1:] = np.sign(cosine)
    run = np.cumsum(breaks) - 1
    for first, last in pairwise([*np.flatnonzero(breaks), m]):
        relative[first:last] = np.cumprod(np.r_[1.0, relative[first + 1 : last]])
    asked = _probes(run, m)
    seen = _seen(model, feet[asked], radius)
    ways = spread(DIRECTIONS)
    votes = np.einsum("pd,dc,pc->p", seen.astype(np.float64), ways, normals[asked])
    total = np.bincount(run[asked], votes * relative[asked], run[-1] + 1)
    middle = 0.5 * (model.points.min(axis=0) + model.points.max(axis=0))
    away = np.einsum("ij,ij->i", feet - middle, normals) * relative
    fallback = np.bincount(run, weights=away)
    count = np.bincount(run[asked], minlength=len(total))
    tie = np.abs(total) < 1e-6 * np.maximum(count, 1)
    total = np.where(tie, fallback, total)
    return relative * np.where(total < 0.0, -1.0, 1.0)[run]


def spread(count: int) -> Points:
    """(count, 3) unit vectors, spread evenly: a spiral with the golden angle."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _probes(run: NDArray[np.int64], m: int) -> NDArray[np.int64]:
    """The points to look from: spread over all, and at least one of every run."""
    even = np.unique(np.linspace(0, m - 1, min(m, PROBES)).round().astype(np.int64))
    first = np.searchsorted(run, np.arange(run[-1] + 1))
    last = np.searchsorted(run, np.arange(run[-1] + 1), side="right")
    return np.unique(np.r_[even, (first + last - 1) // 2])


def _seen(model: Model, feet: Points, radius: float) -> NDArray[np.bool_]:
    """(p, DIRECTIONS) are points seen from afar?"""
    ways = spread(DIRECTIONS)
    far = 2.0 * model.diagonal
    origins = (feet[:, None] + far * ways).reshape(-1, 3)
    rays = np.tile(-ways, (len(feet), 1))
    lengths = model.first_hits(origins, rays).lengths
    return (lengths > far - SUNK * radius).reshape(len(feet), DIRECTIONS)
