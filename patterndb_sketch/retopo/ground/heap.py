"""Keep numbers in a heap by key on flat arrays, for kernels that visit the nearest first.

Not ``heapq``, which takes the other of two equal keys: on regular meshes many are equal, and maps
would not stay what they are, bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel


@kernel
def push(keys: Floats, items: Int32Array, n: Index, key: Any, item: Index) -> int:
    """Put an item in; the arrays have room for it. Returns how many there are now."""
    at = n
    while at > 0:
        above = (at - 1) // 2
        if keys[above] <= key:
            break
        keys[at] = keys[above]
        items[at] = items[above]
        at = above
    keys[at] = key
    items[at] = item
    return n + 1


@kernel
def pop(keys: Floats, items: Int32Array, n: Index) -> int:
    """Take the least of n >= 1 out, which was first in the arrays; how many are left."""
    n -= 1
    key, item = keys[n], items[n]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= n:
            break
        if below + 1 < n and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[at] = keys[below]
        items[at] = items[below]
        at = below
    keys[at] = key
    items[at] = item
    return n


@kernel
def grown(keys: Floats, items: Int32Array) -> tuple[Floats, Int32Array]:
    """The arrays with twice the room."""
    n = len(keys)
    more_keys = np.empty(2 * n + 16)
    more_items = np.empty(2 * n + 16, np.int32)
    more_keys[:n] = keys
    more_items[:n] = items
    return more_keys, more_items
