"""The models that fill holes, as they are shipped: corners, assignments, ranking.

All are arrays in one file, patterndb/data/holes.npz, fitted by scripts/train_holes.py; nothing in
it is executed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from query.holes.corners import AssignmentModel, CornerModel, TreeModel
from query.holes.patterns import HolePatterns
from query.holes.ranking import RankingModel, WholeModel


@dataclass(frozen=True, slots=True, eq=False)
class HoleModels:
    """What is known of how artists fill holes.

    corners:     quads at each vertex of a loop, one by one.
    assignments: quads at all vertices together.
    patterns:    what fills of holes reduce to.
    facts:       ranks candidates before they are placed.
    whole:       ranks those that are placed.
    plain:       ranks fills of boundaries in space that no mesh surrounds.
    """

    corners: CornerModel
    assignments: AssignmentModel
    patterns: HolePatterns
    facts: RankingModel
    whole: WholeModel
    plain: RankingModel

    @classmethod
    def load(cls, file: IO[bytes]) -> HoleModels:
        """Read the models from a file that scripts/train_holes.py has written."""
        with np.load(file, allow_pickle=False) as arrays:
            return cls.from_arrays(arrays)

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> HoleModels:
        """The models of arrays by name."""
        return cls(
            CornerModel.from_arrays(arrays),
            AssignmentModel(*_logit_of(arrays, "assignments")),
            HolePatterns.from_arrays(arrays),
            RankingModel(*_logit_of(arrays, "facts")),
            WholeModel(
                RankingModel(*_logit_of(arrays, "whole")),
                TreeModel.from_arrays(arrays, "whole_tree_"),
            ),
            RankingModel(*_logit_of(arrays, "plain")),
        )


@cache
def shipped_models() -> HoleModels:
    """The models that come with the package."""
    with (files("patterndb") / "data" / "holes.npz").open("rb") as file:
        return HoleModels.load(file)


def _logit_of(arrays: Mapping[str, NDArray[Any]], name: str) -> list[NDArray[np.float64]]:
    return [arrays[f"{name}_{part}"] for part in ("mean", "spread", "weights")]
