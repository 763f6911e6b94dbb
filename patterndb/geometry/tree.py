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

#: From the tree's boxes and nodes, what is asked, the bound and the stack, the next leaf or -1.
Walk = Callable[[Points, Int32Array, Any, float, Int32Array, Floats], int]


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


def make_walk(
    measure: Callable[[Points, Index, Any], float],
    is_beyond: Callable[[Points, Index, float, Any, float], bool],
) -> Walk:
    """Make the kernel that finds the leaves of a tree which may hold the answer to a question.

    measure:   kernel (boxes, b, asked) -> how far box b is; of two boxes the nearer is opened
               first, of equal ones the first.
    is_beyond: kernel (boxes, b, far, asked, bound) -> may box b, so far by its measure, be left
               out, now that the bound is this?

    asked is a tuple of what the question is about, arrays and numbers; bound is what the best
    answer so far is worth. With ``forceinline`` both kernels, and the walk, become part of the
    kernel that asks: it costs what a walk written by hand does, for which it is to call the walk
    in one place.

    Example::

        stack, far = make_stack()
        for i in range(len(points)):
            best = np.inf
            begin_walk(stack)
            while True:
                leaf = walk(boxes, nodes, (points, i), best, stack, far)
                if leaf < 0:
                    break
                for k in range(nodes[leaf, 0], nodes[leaf, 0] + nodes[leaf, 1]):
                    ...  # look at triangle order[k], perhaps lower best
    """

    @kernel(forceinline=True)
    def walk(
        boxes: Points, nodes: Int32Array, asked: Any, bound: float, stack: Int32Array, far: Floats
    ) -> int:
        # The stack's last place counts what is on it.
        top = stack[DEPTH]
        if top == _NONE_YET:
            stack[0] = 0
            far[0] = measure(boxes, 0, asked)
            top = 1
        while top:
            top -= 1
            b = stack[top]
            if is_beyond(boxes, b, far[top], asked, bound):
                continue
            first = nodes[b, 0]
            if nodes[b, 1] >= 0:
                stack[DEPTH] = top
                return b
            # The nearer child is opened first: it is pushed last.
            one = measure(boxes, first, asked)
            two = measure(boxes, first + 1, asked)
            if one > two:
                stack[top], far[top] = first, one
                stack[top + 1], far[top + 1] = first + 1, two
            else:
                stack[top], far[top] = first + 1, two
                stack[top + 1], far[top + 1] = first, one
            top += 2
        stack[DEPTH] = 0
        return -1

    return walk


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
