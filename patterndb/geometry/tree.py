"""The tree of boxes over triangles, and the one walk down it.

:func:`build` makes the tree; :func:`make_walk` makes the kernel that goes down it for one kind of
question. The questions stand beside it: :mod:`patterndb.geometry.proximity` asks for what is
nearest or near, :mod:`patterndb.geometry.casting` for what lines hit. Arrays go by the same names
everywhere:

    corners: (t, 3, 3) float64, the triangles.
    boxes:   (b, 2, 3) float64, lower and upper corners; the first is around everything.
    nodes:   (b, 2) int32, (first child, -1), the other child being the next, or of a leaf (its
             first place in the order, how many triangles it has).
    order:   (t,) int32, the triangles, those of a leaf in a row.

An own kernel because of its speed: placing asks some ten times, and trimesh takes some twenty
times as long (benchmarks/triangle_tree.py).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel

#: Triangles in a leaf, at most.
LEAF = 4

#: Depth that the stack of a walk has room for: boxes are halved by number.
DEPTH = 64

#: How many boxes wait on a stack that no walk has begun with.
_NONE_YET = -1



@kernel
def build(corners: Points) -> tuple[Points, Int32Array, Int32Array]:
    """Boxes (b, 2, 3), their nodes (b, 2) and the order (t,) of triangles (t, 3, 3).

    A node is (first child, -1), its other child being the next, or (first place in order,
    how many).
    """
    t = len(corners)
    order = np.arange(t).astype(np.int32)
    boxes = np.empty((2 * t + 1, 2, 3))
    nodes = np.empty((2 * t + 1, 2), np.int32)
    nodes[0, 0] = 0
    nodes[0, 1] = t
    count = 1
    at = 0
    while at < count:
        first = nodes[at, 0]
        n = nodes[at, 1]
        middle_low = np.full(3, np.inf)
        middle_high = np.full(3, -np.inf)
        boxes[at, 0] = np.inf
        boxes[at, 1] = -np.inf
        for k in range(first, first + n):
            for c in range(3):
                middle = 0.0
                for e in range(3):
                    x = corners[order[k], e, c]
                    middle += x / 3.0
                    boxes[at, 0, c] = min(boxes[at, 0, c], x)
                    boxes[at, 1, c] = max(boxes[at, 1, c], x)
                middle_low[c] = min(middle_low[c], middle)
                middle_high[c] = max(middle_high[c], middle)
        if n > LEAF:
            axis = int(np.argmax(middle_high - middle_low))
            middles = np.empty(n)
            for k in range(n):
                f = order[first + k]
                middles[k] = corners[f, 0, axis] + corners[f, 1, axis] + corners[f, 2, axis]
            order[first : first + n] = order[first : first + n][np.argsort(middles)]
            nodes[at, 0] = count
            nodes[at, 1] = -1
            for half in range(2):
                nodes[count + half, 0] = first + half * (n // 2)
                nodes[count + half, 1] = n // 2 + half * (n % 2)
            count += 2
        at += 1
    return boxes[:count].copy(), nodes[:count].copy(), order


@kernel
def make_stack() -> tuple[Int32Array, Floats]:
    """Make the boxes that wait, and how far each is, for any number of walks in a row."""
    return np.empty(DEPTH + 1, np.int32), np.empty(DEPTH)


@kernel
def begin_walk(stack: Int32Array) -> None:
    """Let the next step of a walk begin at the root."""
    stack[DEPTH] = _NONE_YET


@kernel(forceinline=True)
def measure_backwards(boxes: Points, b: Index, asked: Any) -> float:
    """Order boxes by number, the last first, where none is nearer than another."""
    return -float(b)
