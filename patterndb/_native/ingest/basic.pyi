# Bound by rust/python/src/ingest.rs.
import numpy as np
from numpy.typing import NDArray

from ingest.census import Bench, Census, KernelMesh

def count_basic(
    first: int,
    last: int,
    limit: int,
    mesh: KernelMesh,
    bench: Bench,
    census: Census,
    pulse: NDArray[np.int64],
) -> tuple[int, Census]:
    """Count the patches of at most ``limit`` quads whose smallest quad is in first..last - 1.

    pulse: (2,) int64; the work is broken off once pulse[0] is not 0, and pulse[1] is raised
    by the patches met. Returns their number and the census with their patterns counted.
    """
