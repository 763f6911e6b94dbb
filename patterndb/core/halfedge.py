"""Quad connectivity as half-edges: the one representation under everything else.

Half-edge ``h = 4 * quad + edge`` runs from the quad's corner ``edge`` to the next
one counter-clockwise. ``twin[h]`` is the half-edge on the other side, -1 on the
border. Corner ``h`` is the tail of half-edge ``h``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]

#: A half-edge, or an array of them.
Index = Any


def next_edge(h: Index) -> Index:
    """The half-edge after h in its quad, counter-clockwise."""
    return (h & ~3) | ((h + 1) & 3)


def prev_edge(h: Index) -> Index:
    """The half-edge before h in its quad."""
    return (h & ~3) | ((h + 3) & 3)
