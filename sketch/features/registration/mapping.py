"""Mapping a membrane onto a model: where its normals leave the model, and how far to trust that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from query.polyline import Points
from sketch.features.errors import InvalidFeatureError
from sketch.features.model import Model
from sketch.features.registration.membrane import Membrane

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Which of a normal's hits counts: the outermost of all, or the outermost of those near enough
#: to have a weight.
Hit = Literal["outermost", "within reach"]


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

    @property
    def trusted(self) -> Bools:
        """(v,) bool, does the hit count at all?"""
        return self.found & (self.doubt < 1.0)


def hits(
    model: Model, points: Points, normals: Points, asked: Bools, reach: Floats, hit: Hit
) -> Hits:
    """The hits of the lines along normals (v, 3) of vertices (v, 3) that are asked for, (v,).

    reach: (v,) from which distance on a hit is no more believed: delta times the shortest edge.

    Source: feature curve recovery paper, section 5.1.2. Differs from the paper, with hit =
    "within reach": it takes the outermost hit of all, also where that is beyond reach and so
    counts for nothing; here the outermost of those that do count is taken, as the pane behind a
    mirror. A wheelhouse could not be mapped otherwise: beyond it there is the rest of the car.
    """
    v = len(points)
    places, found, doubt = np.full((v, 3), np.nan), np.zeros(v, np.bool_), np.ones(v)
    lines = np.flatnonzero(asked & (normals != 0.0).any(axis=1))
    if hit == "outermost":
        feet = model.outermost(points[lines], normals[lines])
        met, at, length = lines[feet.found], feet.points[feet.found], feet.lengths[feet.found]
    elif hit == "within reach":
        crossings = model.all_hits(points[lines], normals[lines])
        line = np.repeat(lines, np.diff(crossings.offsets))
        near = np.flatnonzero(np.abs(crossings.lengths) < reach[line])
        # Hits are ascending along each line: of equal lines the last.
        last = near[np.r_[line[near][1:] != line[near][:-1], True]] if len(near) else near
        met, at, length = line[last], crossings.points[last], crossings.lengths[last]
    else:
        raise InvalidFeatureError(f"hit is {hit!r}; give 'outermost' or 'within reach'")
    places[met], found[met] = at, True
    span = np.where(reach[met] > 0.0, reach[met], 1.0)
    doubt[met] = np.where(reach[met] > 0.0, np.minimum(np.abs(length) / span, 1.0), 1.0)
    return Hits(places, found, doubt)


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
