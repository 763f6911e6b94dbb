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

#: Depth that the stack of a walk has room for: boxes are halved by number.
DEPTH = 64
