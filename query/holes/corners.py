"""How many quads each vertex of a loop will get: a model of what artists do.

The model is an ensemble of decision trees, trained by scripts/train_holes.py on holes cut from
artists' meshes and shipped as arrays (patterndb/data/holes.npz). It is evaluated here, by a
kernel.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel

#: No number of quads is less likely than this, in natural logarithms.
LEAST_LOG = -12.0


@dataclass(frozen=True, slots=True, eq=False)
class CornerModel:
    """Trees whose leaves add up to a score for each number of quads.

    start:     (t + 1,) int32 where each tree's nodes begin; tree t scores t % 4 + 1 quads.
    feature:   (n,) int16 the number that a node looks at, -1 at a leaf.
    threshold: (n,) float32: not above it the left child is taken, above it the right.
    child:     (n,) int16 left child, counted from the tree's first node; the right is the next.
    value:     (n,) float32 what a leaf adds.
    base:      (4,) float64 the scores without any tree.
    """

    start: Int32Array
    feature: NDArray[np.int16]
    threshold: NDArray[np.float32]
    child: NDArray[np.int16]
    value: NDArray[np.float32]
    base: Floats

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> CornerModel:
        """The model whose arrays go by the names of its fields."""
        return cls(**{one.name: arrays[one.name] for one in fields(cls)})

    def log_probabilities(self, features: Floats) -> Floats:
        """(L, 4) float64: log of the probability of 1 to 4 quads at every vertex (L, f)."""
        scores = _score_trees(
            np.ascontiguousarray(features, np.float64),
            self.start,
            self.feature,
            self.threshold,
            self.child,
            self.value,
            self.base,
        )
        top = scores.max(axis=1, keepdims=True)
        log_sum = top + np.log(np.exp(scores - top).sum(axis=1, keepdims=True))
        return np.maximum(scores - log_sum, LEAST_LOG)


@kernel
def _score_trees(
    features: Floats,
    start: Int32Array,
    feature: NDArray[np.int16],
    threshold: NDArray[np.float32],
    child: NDArray[np.int16],
    value: NDArray[np.float32],
    base: Floats,
) -> Floats:
    n = len(features)
    scores = np.empty((n, 4))
    for i in range(n):
        for k in range(4):
            scores[i, k] = base[k]
        for t in range(len(start) - 1):
            first = start[t]
            at = first
            while feature[at] >= 0:
                right = features[i, feature[at]] > threshold[at]
                at = first + child[at] + (1 if right else 0)
            scores[i, t % 4] += value[at]
    return scores
