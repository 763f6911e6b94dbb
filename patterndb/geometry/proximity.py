"""Triangles near a box, from the tree of :mod:`patterndb.geometry.tree`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.tree import DEPTH
from patterndb.system.kernels import kernel


@kernel
def within_box(
    corners: Points,
    boxes: Points,
    nodes: Int32Array,
    order: Int32Array,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> Int32Array:
    """(k,) the triangles whose own boxes meet a box (3,) to (3,), ascending."""
    found = np.empty(len(order), np.int32)
    stack = np.empty(DEPTH, np.int32)
    stack[0] = 0
    top = 1
    n = 0
    while top:
        top -= 1
        b = stack[top]
        apart = False
        for c in range(3):
            apart |= boxes[b, 0, c] > high[c] or boxes[b, 1, c] < low[c]
        if apart:
            continue
        if nodes[b, 1] < 0:
            stack[top] = nodes[b, 0]
            stack[top + 1] = nodes[b, 0] + 1
            top += 2
            continue
        for k in range(nodes[b, 0], nodes[b, 0] + nodes[b, 1]):
            f = order[k]
            apart = False
            for c in range(3):
                one, two, three = corners[f, 0, c], corners[f, 1, c], corners[f, 2, c]
                apart |= min(one, two, three) > high[c] or max(one, two, three) < low[c]
            if not apart:
                found[n] = f
                n += 1
    return np.sort(found[:n])
