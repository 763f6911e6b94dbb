# Bound by rust/python/src/query/holes/trees.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def score_trees(
    features: Floats,
    start: Int32Array,
    feature: NDArray[np.int16],
    threshold: NDArray[np.float32],
    child: NDArray[np.int16],
    value: NDArray[np.float32],
    base: Floats,
) -> Floats:
    """"""
