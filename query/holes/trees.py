"""Ensembles of decision trees as arrays, which scripts/train_holes.py fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.trees import score_trees
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats


@dataclass(frozen=True, slots=True, eq=False)
class TreeModel:
    """Trees whose leaves add up to one score or more.

    start:     (t + 1,) int32 where each tree's nodes begin; tree t adds to score t % k.
    feature:   (n,) int16 the number that a node looks at, -1 at a leaf.
    threshold: (n,) float32: not above it the left child is taken, above it the right.
    child:     (n,) int16 left child, counted from the tree's first node; the right is the next.
    value:     (n,) float32 what a leaf adds.
    base:      (k,) float64 the scores without any tree.
    """

    start: Int32Array
    feature: NDArray[np.int16]
    threshold: NDArray[np.float32]
    child: NDArray[np.int16]
    value: NDArray[np.float32]
    base: Floats

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Self:
        """The model whose arrays go by the names of its fields, after the prefix."""
        return cls(**{one.name: arrays[prefix + one.name] for one in fields(cls)})

    def to_arrays(self, prefix: str = "") -> dict[str, NDArray[Any]]:
        """The arrays that :meth:`from_arrays` reads."""
        return {prefix + one.name: getattr(self, one.name) for one in fields(self)}

    def score(self, features: Floats) -> Floats:
        """(n, k) float64 the scores of rows (n, f)."""
        return score_trees(
            np.ascontiguousarray(features, np.float64),
            self.start,
            self.feature,
            self.threshold,
            self.child,
            self.value,
            self.base,
        )
