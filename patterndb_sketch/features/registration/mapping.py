"""Mapping a membrane onto a model: where its normals leave the model, and how far to trust that."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from patterndb.geometry.points import Bools, Floats, Points
from patterndb_sketch.features.model import Feet, Model
from patterndb_sketch.features.registration.membrane import Membrane


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Lines through points (v, 3) along normals (v, 3).

    asked: (v,) bool, those that a model is asked about. hollow: (v,) bool, of hollow parts.
    """

    points: Points
    normals: Points
    asked: Bools
    hollow: Bools


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Where vertices' normals leave a model.

    points: (v, 3) float64, nan without a hit. found: (v,) bool.
    doubt:  (v,) float64, the paper's d: the distance from the membrane over the reach, at most
            1; 1 without a hit. A hit counts with the weight 1 - d, smoothness with d.
    """

    points: Points
    found: Bools
    doubt: Floats

    @classmethod
    def nothing(cls, v: int) -> Hits:
        """No hit at any of v vertices."""
        return cls(np.full((v, 3), np.nan), np.zeros(v, np.bool_), np.ones(v))

    @property
    def trusted(self) -> Bools:
        """(v,) bool, does the hit count at all?"""
        return self.found & (self.doubt < 1.0)


def hits(model: Model, lines: Lines, reach: Floats) -> Hits:
    """The hits of the lines along vertices' normals.

    reach: (v,) from which distance on a hit is no more believed: delta times the shortest edge.

    Source: feature curve recovery paper, section 5.1.2. Differs from the paper: of hollow
    parts it takes the nearest hit, not the outermost. The outermost hit of a wheelhouse is
    the wheel in it, or the far end of the car.
    """
    v = len(reach)
    places, found, doubt = np.full((v, 3), np.nan), np.zeros(v, np.bool_), np.ones(v)
    asked = lines.asked & (lines.normals != 0.0).any(axis=1)
    length = np.full(v, np.inf)
    for chosen, ask in (
        (np.flatnonzero(asked & ~lines.hollow), model.outermost),
        (np.flatnonzero(asked & lines.hollow), partial(_nearest, model)),
    ):
        feet = ask(lines.points[chosen], lines.normals[chosen])
        places[chosen], length[chosen] = feet.points, np.abs(feet.lengths)
        found[chosen] = feet.found
    near = found & (length < reach)
    doubt[near] = length[near] / reach[near]
    return Hits(places, found, doubt)


def _nearest(model: Model, origins: Points, directions: Points) -> Feet:
    """The hits of lines nearest to their origins, before or behind them."""
    ahead = model.first_hits(origins, directions)
    behind = model.first_hits(origins, -directions)
    first = ahead.lengths <= behind.lengths
    return Feet(
        np.where(first[:, None], ahead.points, behind.points),
        np.where(first, ahead.triangles, behind.triangles),
        np.where(first, ahead.lengths, -behind.lengths),
    )


def mapped(membrane: Membrane, features: Points, found: Hits) -> Points:
    """(v, 3) the places with the least sum of squares that keep the feature vertices (v, 3).

    The sum has two kinds of terms for a free vertex: d times its distance from the mean of its
    neighbours, and, with a hit, 1 - d times its distance from the hit. Feature vertices are
    taken out of the system, so they stay to the last bit.

    Source: feature curve recovery paper, equations 2 to 4.
    """
    result = np.array(features, np.float64)
    free = membrane.free
    if not len(free):
        return result
    smooth, pull = found.doubt[free], membrane.pull(result)
    met = np.flatnonzero(found.trusted[free])
    trust = 1.0 - smooth[met]
    select = csr_array((trust, (np.arange(len(met)), met)), (len(met), len(free)))
    system = vstack([diags_array(smooth).tocsr() @ membrane.inner, select]).tocsr()
    wanted = np.concatenate([smooth[:, None] * pull, trust[:, None] * found.points[free][met]])
    normal = (system.T @ system).tocsc()
    factor = splu(normal)
    places = factor.solve(system.T @ wanted)
    # The normal matrix has half the digits: one round on the residual gets them back.
    places += factor.solve(system.T @ (wanted - system @ places))
    result[free] = places
    return result
