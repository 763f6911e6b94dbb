"""Where the cut must pass: rows of ribs that are held."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import as_points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone.fishbone import Fishbone
from patterndb_sketch.features.splines import Constraint


def held_rows(fishbone: Fishbone, constraints: Sequence[Constraint]) -> NDArray[np.int64]:
    """(m,) the rows nearest to the constraints of ribs, -1 for ribs without one.

    constraints: (number of a rib, point (3,)); those of ribs that are not there hold nothing.
    """
    rows = np.full(len(fishbone.points), -1, np.int64)
    for number, place in constraints:
        target = as_points(
            np.asarray(place)[None], f"the point of rib {number}", InvalidFeatureError
        )
        for i in np.flatnonzero(fishbone.ribs == number):
            away = np.linalg.norm(fishbone.points[i] - target, axis=1)
            rows[i] = np.argmin(np.where(fishbone.valid[i], away, np.inf))
    return rows


def with_held(costs: NDArray[np.float64], rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m, k) costs with 0 at the held rows (m,) and inf elsewhere in their ribs.

    Source: feature curve recovery paper, section 4.3.3.
    """
    result = costs.copy()
    held = np.flatnonzero(rows >= 0)
    result[held] = np.inf
    result[held, rows[held]] = 0.0
    return result
