# Bound by rust/python/src/query/holes.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def measure(logs: Floats, regular_valence: Int32Array, assignments: Int32Array) -> Floats:
    """Return the traits (a, k) of assignments (a, L) of quads to the vertices of a loop.

    logs: (L, 4) log probability of 1 to 4 quads at each vertex. regular_valence: (L,) quads that
    make it regular.
    """

def score_trees(
    features: Floats,
    start: Int32Array,
    feature: NDArray[np.int16],
    threshold: NDArray[np.float32],
    child: NDArray[np.int16],
    value: NDArray[np.float32],
    base: Floats,
) -> Floats:
    """Return the scores (n, m) that ensembles of decision trees give to rows of features (n, f).

    Tree t adds to score t % m. start: (t + 1,) where the nodes of each tree begin. feature:
    compared by a node, -1 at a leaf. threshold: the left child is taken where the feature is not
    above it. child: the left one, counted from the tree's first node; the right one is the next.
    value: what a leaf adds. base: (m,) scores without any tree.
    """
