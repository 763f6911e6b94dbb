# Bound by rust/python/src/query/marks/patterntable.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code

def meshes(flat: Code, offsets: NDArray[np.int64]) -> NDArray[np.bool_]:
    """"""
