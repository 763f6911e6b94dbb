"""The most even widths: the K best solutions of one system, without listing them all.

The key of a solution is the sum of x_p**2 over the open polychords. Their widths add up
to half the perimeter whichever the solution, so among all solutions of one pattern, in
any orientation, this sum and the squared deviation from the mean width differ by a
constant: the smallest sum is the most even solution, and the key is an exact integer.
Ties go to the lexicographically smaller widths, in label order.

Branch and bound over classes. A price u_s on the slack of every side turns the key into a
constant plus one *excess* >= 0 per class (Lagrangian duality), so that a partial solution
is dropped as soon as the excesses of its decided classes exceed what the K-th best
leaves. Any prices give a valid bound; those of the continuous problem give a tight one.
Prices are integers in units of 1/SCALE: nothing is lost to rounding.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from patterndb.halfedge import Int32Array
from query.matching import DONE, PATIENCE, balanced, choose, two_colour
from query.spread import INFINITE, even_cost, spread
from query.transport import tighten

Int64Array = NDArray[np.int64]

#: Units of price per unit of the key; finer prices no longer tighten the bound.
SCALE = 64

#: Rounds of coordinate ascent on the prices. Fewer give a weaker bound, never a wrong one.
ROUNDS = 60


@njit(cache=True, nogil=True)
def prices(
    slack: Int32Array, class_i: Int32Array, class_j: Int32Array, class_n: Int32Array
) -> Int64Array:
    """(w,) int64 price of one unit of each side's slack, in units of 1/SCALE.

    Coordinate ascent on the dual of: minimise sum n_k (1 + y_k / n_k)**2 over real
    y >= 0 that meet the slack. At the optimum y_k = n_k max(0, (u_i + u_j) / 2 - 1); one
    side's price is the root of an increasing piecewise linear function.
    """
    w = len(slack)
    m = len(class_i)
    u = np.full(w, 1.0)
    active = np.empty(m, np.bool_)
    for _ in range(ROUNDS):
        for s in range(w):
            for k in range(m):
                active[k] = class_i[k] == s or class_j[k] == s
            changed = True
            root = u[s]
            while changed:
                # Root over the active classes; those that would turn negative leave.
                slope = 0.0
                level = float(slack[s])
                for k in range(m):
                    if active[k]:
                        if class_i[k] == class_j[k]:
                            slope += 2.0 * class_n[k]
                            level += 2.0 * class_n[k]
                        else:
                            other = class_j[k] if class_i[k] == s else class_i[k]
                            slope += 0.5 * class_n[k]
                            level += class_n[k] * (1.0 - 0.5 * u[other])
                if slope == 0.0:
                    break
                root = level / slope
                changed = False
                for k in range(m):
                    if active[k]:
                        if class_i[k] == class_j[k]:
                            starts = 1.0
                        else:
                            other = class_j[k] if class_i[k] == s else class_i[k]
                            starts = 2.0 - u[other]
                        if starts > root:
                            active[k] = False
                            changed = True
            u[s] = root
    return np.round(u * SCALE).astype(np.int64)


@njit(cache=True, nogil=True)
def insert(
    key: int,
    widths: Int32Array,
    keys: Int64Array,
    best: Int32Array,
    order: Int64Array,
    count: int,
) -> int:
    """Insert a solution into the sorted list of the best; return the new length.

    keys: (keep,), best: (keep, n): solutions in no order; order: (keep,) says in which.
    The same length as before and a full list means that it was left out or that the last
    one made room.
    """
    keep = len(order)
    at = count
    while at > 0:
        other = order[at - 1]
        if keys[other] < key:
            break
        if keys[other] == key:
            smaller = False
            for p in range(len(widths)):
                if widths[p] != best[other, p]:
                    smaller = widths[p] < best[other, p]
                    break
            if not smaller:
                break
        at -= 1
    if at == keep:
        return count
    slot = count if count < keep else order[keep - 1]
    count = min(count + 1, keep)
    for i in range(count - 1, at, -1):
        order[i] = order[i - 1]
    order[at] = slot
    keys[slot] = key
    best[slot] = widths
    return count


@njit(cache=True, nogil=True)
def most_even(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    class_of: Int32Array,
    keep: int,
) -> Int32Array:
    """(k <= keep, n) int32 widths of the best solutions, best first.

    slack: (w,) >= 0; class_i, class_j, class_n, class_of: see :class:`query.chords.Chords`;
    keep: >= 1. Fewer than ``keep`` rows are all the solutions there are.
    """
    w = len(slack)
    m = len(class_i)
    u = prices(slack, class_i, class_j, class_n)
    # The excess of class k at y is SCALE * even_cost(y) - price * y - floor, 0 at ``bottom``.
    price = np.empty(m, np.int64)
    bottom = np.empty(m, np.int64)
    floor = np.empty(m, np.int64)
    constant = 0
    for s in range(w):
        constant += u[s] * slack[s]
    for k in range(m):
        price[k] = u[class_i[k]] + u[class_j[k]]
        # Widening all from 1 + q to 2 + q pays off while SCALE * (2 q + 3) <= price.
        q = (price[k] // SCALE - 3) // 2 + 1
        bottom[k] = max(0, q) * class_n[k]
        floor[k] = SCALE * even_cost(int(class_n[k]), int(bottom[k])) - price[k] * bottom[k]
        constant += floor[k]

    best = np.empty((keep, len(class_of)), np.int32)
    keys = np.empty(keep, np.int64)
    order = np.empty(keep, np.int64)
    count = 0
    buffer = np.empty((keep, len(class_of)), np.int32)

    residual = slack.copy()
    closed = np.zeros(m, np.bool_)
    value = np.zeros(m, np.int32)
    chosen = np.empty(m, np.int64)
    # Untried values of the class decided at each depth: low..left and right..high.
    low = np.empty(m, np.int64)
    left = np.empty(m, np.int64)
    right = np.empty(m, np.int64)
    high = np.empty(m, np.int64)
    spent = np.zeros(m + 1, np.int64)
    degree = np.empty(w, np.int32)
    reach = np.empty(w, np.int32)
    component = np.empty(w, np.int32)
    colour = np.empty(w, np.int32)
    flow = np.empty((2, m), np.int32)
    flow_scratch = np.empty((5, w), np.int32)
    dead_ends = 0
    depth = 0
    down = True
    while True:
        if down:
            down = False
            ready = False
            k, least, most = choose(residual, class_i, class_j, m, closed, degree, reach)
            if dead_ends > PATIENCE and k >= 0 and least < most:
                least, most = tighten(
                    residual, class_i, class_j, m, closed, k, least, most, flow, flow_scratch
                )
            if k == DONE:
                dead_ends = 0
                key = 0
                for c in range(m):
                    key += even_cost(int(class_n[c]), int(value[c]))
                got = 0
                while got < keep and key < INFINITE:
                    if count == keep and key > keys[order[keep - 1]]:
                        break
                    found, above = spread(value, class_n, class_of, key, True, buffer, keep - got)
                    for r in range(found):
                        count = insert(key, buffer[r], keys, best, order, count)
                    got += found
                    key = above
            elif k >= 0 and least <= most:
                ready = True
                if least < most:
                    two_colour(class_i, class_j, m, closed, component, colour, reach)
                    ready = balanced(residual, component, colour, reach)
            if ready:
                chosen[depth] = k
                low[depth] = least
                high[depth] = most
                left[depth] = min(max(bottom[k], least), most)
                right[depth] = left[depth] + 1
                closed[k] = True
                depth += 1
            elif k != DONE:
                dead_ends += 1
        elif depth == 0:
            break
        else:
            d = depth - 1
            k = chosen[d]
            residual[class_i[k]] += value[k]
            residual[class_j[k]] += value[k]
            value[k] = 0
            budget = INFINITE
            if count == keep:
                budget = SCALE * keys[order[keep - 1]] - constant
            excess = INFINITE
            y = left[d]
            if left[d] >= low[d]:
                excess = SCALE * even_cost(int(class_n[k]), int(y)) - price[k] * y - floor[k]
            if right[d] <= high[d]:
                y = right[d]
                other = SCALE * even_cost(int(class_n[k]), int(y)) - price[k] * y - floor[k]
                if other < excess:
                    excess = other
                else:
                    y = left[d]
            if excess == INFINITE or spent[d] + excess > budget:
                closed[k] = False
                depth -= 1
                continue
            if y == left[d]:
                left[d] -= 1
            else:
                right[d] += 1
            spent[depth] = spent[d] + excess
            value[k] = y
            residual[class_i[k]] -= y
            residual[class_j[k]] -= y
            down = True
    return best[order[:count]]
