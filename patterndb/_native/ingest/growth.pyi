# Bound by rust/python/src/ingest.rs.
import numpy as np
from numpy.typing import NDArray

from ingest.census import Bench, Census, KernelMesh, UInt64Array
from patterndb.core.halfedge import Int32Array

def grow(
    roots: Int32Array,
    limit: int,
    convex: bool,
    smaller: int,
    others: UInt64Array,
    shard: Int32Array,
    mesh: KernelMesh,
    bench: Bench,
    census: Census,
    pulse: NDArray[np.int64],
) -> tuple[int, UInt64Array, UInt64Array, Int32Array, Census]:
    """Count all patches of at most ``limit`` quads that grow from the roots.

    smaller: patches of at most that many quads were counted by another mode already; they
    are grown on, and counted in the total, but not in the census. others: set of hashes of
    patches counted by another mode. shard: (q,) int32; the roots are all quads of one
    shard. A patch that reaches into another shard may be found from there too, so it is
    not counted but returned.

    Returns (patches counted, the set of all hashes met, and of the patches that reach
    into other shards: (r, 2) hashes and (r,) int32 2 * row + handedness, -1 where another
    mode counts it; the census). pulse: as in :func:`ingest.basic.count_basic`.
    """
