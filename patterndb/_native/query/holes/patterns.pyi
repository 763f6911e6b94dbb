# Bound by rust/python/src/query/holes.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from query.cancellation import CancelFlag
from query.holes.patterns import PatternTables

def enumerate_embeddings(
    loss: Floats,
    n: int,
    tables: PatternTables,
    prior: Floats,
    most: int,
    cancelled: CancelFlag,
) -> tuple[Floats, Int32Array, Int32Array, NDArray[np.bool_], Int32Array]:
    """Enumerate the likeliest embeddings: scores, patterns, turns, mirrored (c,), and widths
    (c, MOST_CHORDS).

    loss: (2, 2 n, 5) how much less likely 1 to 4 quads at a loop vertex are than the likeliest
    number, twice around; and the same backwards. A pattern is laid along its boundary edge by edge:
    a polychord that is met first may have any width, and is as wide where it comes out. What is
    lost never shrinks, so that a way is left where it has lost too much. Once cancelled, the result
    is what was found until then.
    """
