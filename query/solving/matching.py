"""Kernels for the uncapacitated b-matching on the sides of one pattern.

Given slack_i >= 0 for every side and classes that join sides (i, j), find integers
y_ij >= 0 with sum_j y_ij + 2 y_ii = slack_i: how much wider than 1 the polychords of each
class are in sum. ``search`` lists the solutions depth-first; ``choose`` says where it
branches and within which bounds, and ``balanced`` (:mod:`.colouring`) rejects by parity.

Source: the integer program of Marcias et al. 2015, section 4. Differs from the paper: an
own search instead of a general solver, over classes instead of single polychords, since
one class is one variable to the sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from query.solving.colouring import balanced, two_colour
from query.solving.rounding import soluble
from query.solving.transport import tighten

#: ``choose`` found every class decided, or that no solution is left.
DONE = -1
DEAD = -2

#: More than any slack: what a class with both ends on one side can absorb.
UNBOUNDED = 1 << 24

#: Dead ends after which a search no longer trusts its cheap bounds and asks, wherever it
#: branches, whether there is a solution at all. Most searches meet none; those that do may
#: meet millions. From then on the time between two solutions is polynomial.
PATIENCE = 30

#: Counting stops here, far above what a caller asks for; a product of two still fits.
MANY = 1 << 30


@kernel
def choose(
    residual: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    degree: Int32Array,
    reach: Int32Array,
) -> tuple[int, int, int]:
    """The open class to decide next, and the least and greatest value it may take.

    A class of the side with the fewest open classes: one left means one value. residual:
    (w,) slack not yet given to a class; closed: (m,) is the class decided? degree, reach:
    (w,) scratch. Returns (DONE, 0, 0) where all classes are decided and nothing is left
    over, (DEAD, 0, 0) where a side asks for more than its neighbours can give.
    """
    n_sides = len(residual)
    for s in range(n_sides):
        degree[s] = 0
        reach[s] = 0
    for k in range(n_classes):
        if closed[k]:
            continue
        i = class_i[k]
        j = class_j[k]
        degree[i] += 1
        if i == j:
            reach[i] += UNBOUNDED
        else:
            degree[j] += 1
            reach[i] += residual[j]
            reach[j] += residual[i]
    side = -1
    fewest = 0
    for s in range(n_sides):
        if residual[s] > reach[s]:
            return DEAD, 0, 0
        if degree[s] > 0:
            # Nothing left means that all classes of the side are 0: as good as decided.
            d = degree[s] if residual[s] > 0 else 1
            if side < 0 or d < fewest:
                side = s
                fewest = d
    if side < 0:
        return DONE, 0, 0
    k = 0
    while closed[k] or (class_i[k] != side and class_j[k] != side):
        k += 1
    i = class_i[k]
    j = class_j[k]
    a = int(residual[i])
    b = int(residual[j])
    if i == j:
        return k, (max(0, a - (int(reach[i]) - UNBOUNDED)) + 1) // 2, a // 2
    return k, max(0, a - (int(reach[i]) - b), b - (int(reach[j]) - a)), min(a, b)


@kernel
def splits(value: int, parts: int) -> int:
    """How many ways there are to write value >= 0 as an ordered sum of parts, capped at MANY."""
    ways = 1
    for p in range(1, parts):
        # C(value + p, p) from C(value + p - 1, p - 1): the division is exact.
        if ways > MANY:
            return MANY
        ways = ways * (value + p) // p
    return min(ways, MANY)


@kernel
def search(
    residual: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    n_classes: int,
    limit: int,
    rows: Int32Array,
    closed: NDArray[np.bool_],
    side_scratch: Int32Array,
    class_scratch: Int32Array,
) -> tuple[int, int]:
    """Write solutions into ``rows`` until they stand for more than ``limit`` widths.

    residual: (w,) int32 slack, spoilt; class_n: (m,) polychords of each class, so that
    a row stands for the product of their :func:`splits`. rows: (>= limit + 1, m) int32;
    closed: (m,) bool; side_scratch: (5, w) int32; class_scratch: (3, m) int32.
    Returns (rows written, widths they stand for): the list is whole exactly if the
    second is at most ``limit``.
    """
    degree = side_scratch[0]
    reach = side_scratch[1]
    component = side_scratch[2]
    colour = side_scratch[3]
    stack = side_scratch[4]
    chosen = class_scratch[0]
    value = class_scratch[1]
    least = class_scratch[2]
    for k in range(n_classes):
        closed[k] = False
    found = 0
    widths = 0
    depth = 0
    dead_ends = 0
    flow = np.empty((2, 0), np.int32)
    flow_scratch = np.empty((5, 0), np.int32)
    down = True
    while True:
        if down:
            down = False
            k, low, high = choose(residual, class_i, class_j, n_classes, closed, degree, reach)
            if dead_ends > PATIENCE and k >= 0 and low < high:
                if soluble(residual, class_i, class_j, n_classes, closed):
                    low, high = tighten(
                        residual,
                        class_i,
                        class_j,
                        n_classes,
                        closed,
                        k,
                        low,
                        high,
                        flow,
                        flow_scratch,
                    )
                else:
                    k = DEAD
            if k == DONE:
                ways = 1
                for d in range(depth):
                    rows[found, chosen[d]] = value[d]
                    ways *= splits(int(value[d]), int(class_n[chosen[d]]))
                    ways = min(ways, MANY)
                found += 1
                widths = min(widths + ways, MANY)
                if widths > limit:
                    return found, widths
            elif k >= 0 and low <= high:
                down = True
                # Parity is dear to test: only where there is a choice to be spared.
                if low < high:
                    two_colour(class_i, class_j, n_classes, closed, component, colour, stack)
                    down = balanced(residual, component, colour, stack)
            if down:
                chosen[depth] = k
                value[depth] = high
                least[depth] = low
                closed[k] = True
                residual[class_i[k]] -= high
                residual[class_j[k]] -= high
                depth += 1
            elif k != DONE:
                dead_ends += 1
                if dead_ends == PATIENCE + 1:
                    # Begin anew, this time with flows.
                    flow = np.empty((2, n_classes), np.int32)
                    flow_scratch = np.empty((5, len(residual)), np.int32)
                    while depth > 0:
                        depth -= 1
                        k = chosen[depth]
                        closed[k] = False
                        residual[class_i[k]] += value[depth]
                        residual[class_j[k]] += value[depth]
                    found = 0
                    widths = 0
                    down = True
        elif depth == 0:
            return found, widths
        else:
            k = chosen[depth - 1]
            back = 1
            if value[depth - 1] > least[depth - 1]:
                value[depth - 1] -= 1
                down = True
            else:
                depth -= 1
                back = value[depth]
                closed[k] = False
            residual[class_i[k]] += back
            residual[class_j[k]] += back
