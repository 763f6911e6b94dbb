"""A triangulated cycle, whoever made it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Filling:
    """What a method made of a cycle.

    vertices: (v, 3) float64; triangles: (t, 3) int64; seconds: what it took;
    note: why it is not by the method asked for, "" if it is.
    """

    vertices: NDArray[np.float64] = field(repr=False)
    triangles: NDArray[np.int64] = field(repr=False)
    seconds: float
    note: str = ""
