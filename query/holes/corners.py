"""How many quads each vertex of a loop will get: a model of what artists do.

The model is an ensemble of decision trees, trained by scripts/train_holes.py on holes cut from
artists' meshes and shipped as arrays (patterndb/data/holes.npz).
"""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Floats
from query.holes.trees import TreeModel

#: No number of quads is less likely than this, in natural logarithms.
LEAST_LOG = -12.0


class CornerModel(TreeModel):
    """Trees of which each kind scores a number of quads at a vertex, 1 to 4."""

    def log_probabilities(self, features: Floats) -> Floats:
        """(L, 4) float64: log of the probability of 1 to 4 quads at every vertex (L, f)."""
        scores = self.score(features)
        top = scores.max(axis=1, keepdims=True)
        log_sum = top + np.log(np.exp(scores - top).sum(axis=1, keepdims=True))
        return np.maximum(scores - log_sum, LEAST_LOG)
