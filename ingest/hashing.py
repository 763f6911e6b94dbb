"""128-bit hashes of sets and sequences, and open-addressing sets of them.

A set of quads is hashed as the exclusive or of its quads' random numbers (Zobrist), so
adding a quad is one operation. Patch counts are exact as long as no two of a mesh's
patches share a hash; with 128 bits and 10^8 patches that has a chance of 10^-23.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

UInt64Array = NDArray[np.uint64]

#: Share of slots in use at which a set doubles: linear probing stays short below it.
LOAD = 0.625
