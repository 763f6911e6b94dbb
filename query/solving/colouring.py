"""What parity says about a matching: the two colours of a component."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel


@kernel
def two_colour(
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    component: Int32Array,
    colour: Int32Array,
    stack: Int32Array,
) -> None:
    """Write each side's component under the open classes, and its colour there.

    component: (w,) number of the component's first side; colour: (w,) 1 or -1 such that
    classes join unlike colours, 0 where the component has no such colouring. stack: (w,)
    scratch.
    """
    n_sides = len(component)
    for s in range(n_sides):
        component[s] = -1
    for root in range(n_sides):
        if component[root] >= 0:
            continue
        component[root] = root
        colour[root] = 1
        stack[0] = root
        head = 0
        tail = 1
        bipartite = True
        while head < tail:
            s = stack[head]
            head += 1
            for k in range(n_classes):
                if closed[k]:
                    continue
                if class_i[k] == s:
                    other = class_j[k]
                elif class_j[k] == s:
                    other = class_i[k]
                else:
                    continue
                if component[other] < 0:
                    component[other] = root
                    colour[other] = -colour[s]
                    stack[tail] = other
                    tail += 1
                elif colour[other] == colour[s]:
                    bipartite = False
        if not bipartite:
            for at in range(tail):
                colour[stack[at]] = 0


@kernel
def balanced(
    residual: Int32Array, component: Int32Array, colour: Int32Array, sums: Int32Array
) -> bool:
    """May the classes absorb the residual, component by component, by parity?

    A class takes as much from one end as from the other. So in a component whose sides
    are two-coloured both colours must add up to the same; in any other the sum must be
    even. component, colour: of :func:`two_colour`; sums: (w,) scratch.
    """
    n_sides = len(residual)
    for s in range(n_sides):
        sums[s] = 0
    for s in range(n_sides):
        sums[component[s]] += residual[s] if colour[s] == 0 else colour[s] * residual[s]
    for s in range(n_sides):
        if component[s] == s and (sums[s] % 2 != 0 if colour[s] == 0 else sums[s] != 0):
            return False
    return True
