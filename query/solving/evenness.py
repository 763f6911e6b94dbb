"""The most even widths: the K best solutions of one system, without listing them all.

The key of a solution is the sum of w_p x_p**2 over the open polychords, where w_p is 1, or,
where the boundary has geometry, grows with the squares of the edge lengths at p's two ends.
The strands' ends cover the boundary whichever the solution, so among all solutions of one
pattern, in any orientation, this sum and the squared deviation from the mean differ by a
constant: the smallest sum is the most even solution, in edges or in length, and the key is
an exact integer. Strokes come first: every edge by which a strand's end is off its stroke's
counts more than all widths together. Ties go to the lexicographically smaller widths, in
label order.

Branch and bound over classes. A price u_s on the slack of every side turns the key into a
constant plus one *excess* >= 0 per class (Lagrangian duality), so that a partial solution
is dropped as soon as the excesses of its decided classes exceed what the K-th best
leaves. Any prices give a valid bound; those of the continuous problem give a tight one.
Prices are integers in units of 1/SCALE: nothing is lost to rounding.

A polychord that strokes divide is several variables to the search, its *parts*. Squares
being convex, the parts' own squares bound the polychord's from below, so the same bound
holds; whole keys are computed where a solution is complete. Last, :func:`spread_slack` splits each
class's slack among its polychords, most evenly first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel
from query.solving.halves import tighten_bounds
from query.solving.matching import DONE, PATIENCE, choose_class, count_splits
from query.solving.systems import is_balanced, two_colour

#: Above every key; see :mod:`query.solving.evenness`.
INFINITE = 1 << 50


@kernel
def even_cost(parts: int, value: int) -> int:
    """The least sum of (1 + s)**2 over ``parts`` integers s >= 0 that add up to ``value``."""
    if parts == 0:
        return 0
    low = value // parts
    more = value - low * parts
    return (parts - more) * (1 + low) * (1 + low) + more * (2 + low) * (2 + low)


@kernel
def spread_slack(
    value: Int32Array,
    class_n: Int32Array,
    class_weight: Int32Array,
    class_of: Int32Array,
    budget: int,
    exactly: bool,
    rows: Int32Array,
    room: int,
    cancelled: NDArray[np.uint8],
) -> tuple[int, int]:
    """Write the widths that split each class's value among its polychords.

    In lexicographic order, at most ``room`` of them: those whose key is at most
    ``budget``, or with ``exactly`` equals it. value: (m,) slack of each class, class_weight:
    (m,) what the square of a width counts there; rows: (>= room, n) int32. Classes of 0
    polychords have nothing to split. Returns (number written, the least key above the
    budget, or INFINITE). The bound is met by a real solution, so no branch is in vain.
    cancelled: (1,), looked at all the time: where it is 1, the rest is left out.
    """
    n = len(class_of)
    left = value.copy()
    parts = class_n.copy()
    extra = np.full(n, -1, np.int32)
    bound = 0
    for k in range(len(class_n)):
        bound += class_weight[k] * even_cost(int(class_n[k]), int(value[k]))
    above = INFINITE
    count = 0
    if bound > budget:
        return 0, bound
    bounds = np.empty(n + 1, np.int64)
    bounds[0] = bound
    c = 0
    while c >= 0 and count < room and not cancelled[0]:
        if c == n:
            if bounds[n] == budget or not exactly:
                for p in range(n):
                    rows[count, p] = 1 + extra[p]
                count += 1
            c -= 1
            continue
        k = class_of[c]
        if extra[c] >= 0:
            left[k] += extra[c]
            parts[k] += 1
        weight = class_weight[k]
        before = bounds[c] - weight * even_cost(int(parts[k]), int(left[k]))
        e = extra[c] + 1
        if parts[k] == 1 and e < left[k]:
            e = left[k]
        chosen = -1
        while e <= left[k]:
            rest = even_cost(int(parts[k]) - 1, int(left[k] - e))
            cost = before + weight * ((1 + e) * (1 + e) + rest)
            if cost <= budget:
                chosen = e
                bounds[c + 1] = cost
                break
            above = min(above, cost)
            # Beyond the mean every further unit costs more.
            if e * parts[k] > left[k]:
                break
            e += 1
        if chosen < 0:
            extra[c] = -1
            c -= 1
        else:
            extra[c] = chosen
            left[k] -= chosen
            parts[k] -= 1
            c += 1
    return count, above


@kernel
def list_splits(values: Int32Array, class_n: Int32Array, class_of: Int32Array) -> Int32Array:
    """All widths that split the slack of classes among their polychords, (k, n) int32.

    values: (r, m) rows of the slack of each class; those of one row are in lexicographic order.
    """
    total = 0
    for r in range(len(values)):
        ways = 1
        for k in range(len(class_n)):
            ways *= count_splits(int(values[r, k]), int(class_n[k]))
        total += ways
    widths = np.empty((total, len(class_of)), np.int32)
    weights = np.ones(len(class_n), np.int32)
    never = np.zeros(1, np.uint8)
    at = 0
    for r in range(len(values)):
        room = widths[at:]
        at += spread_slack(
            values[r], class_n, weights, class_of, INFINITE, False, room, len(room), never
        )[0]
    return widths


#: Units of price per unit of the key; finer prices no longer tighten the bound.
SCALE = 64

#: Rounds of coordinate ascent on the prices. Fewer give a weaker bound, never a wrong one.
ROUNDS = 60


#: What an edge off a stroke's end counts: more than any sum of squares. Perimeters are at most
#: 2,000, so the squares add up to at most 1,000**2, each times a weight of at most MAX_WEIGHT.
OFF = 1 << 28

#: The weight of a square stays within 1..MAX_WEIGHT.
MAX_WEIGHT = 255


@kernel
def find_prices(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    class_weight: Int32Array,
) -> Int64Array:
    """(w,) int64 price of one unit of each node's slack, in units of 1/SCALE.

    Coordinate ascent on the dual of: minimise sum w_k n_k (1 + y_k / n_k)**2 over real
    y >= 0 that meet the slack. At the optimum y_k = n_k max(0, (u_i + u_j) / (2 w_k) - 1);
    one node's price is the root of an increasing piecewise linear function. A node of
    tolerance costs nothing: its price is what makes its classes cost least.
    """
    w = len(slack)
    m = len(class_i)
    u = np.full(w, 1.0)
    active = np.empty(m, np.bool_)
    for _ in range(ROUNDS):
        for s in range(w):
            for k in range(m):
                active[k] = class_n[k] > 0 and (class_i[k] == s or class_j[k] == s)
            changed = True
            root = u[s]
            while changed:
                # Root over the active classes; those that would turn negative leave.
                slope = 0.0
                level = float(slack[s])
                for k in range(m):
                    if active[k]:
                        weight = float(class_weight[k])
                        if class_i[k] == class_j[k]:
                            slope += 2.0 * class_n[k] / weight
                            level += 2.0 * class_n[k]
                        else:
                            other = class_j[k] if class_i[k] == s else class_i[k]
                            slope += 0.5 * class_n[k] / weight
                            level += class_n[k] * (1.0 - 0.5 * u[other] / weight)
                if slope == 0.0:
                    break
                root = level / slope
                changed = False
                for k in range(m):
                    if active[k]:
                        if class_i[k] == class_j[k]:
                            starts = float(class_weight[k])
                        else:
                            other = class_j[k] if class_i[k] == s else class_i[k]
                            starts = 2.0 * class_weight[k] - u[other]
                        if starts > root:
                            active[k] = False
                            changed = True
            u[s] = root
    for k in range(m):
        if class_n[k] == 0:
            # Its two classes follow each other: half the sum of the pieces' prices.
            t = class_j[k]
            u[t] = 0.0
    for k in range(m):
        if class_n[k] == 0:
            u[class_j[k]] -= 0.5 * u[class_i[k]]
    prices = np.empty(len(u), np.int64)
    for s in range(len(u)):
        prices[s] = np.int64(round(u[s] * SCALE))
    return prices


@kernel
def insert_solution(
    key: int,
    widths: Int32Array,
    distinct: bool,
    keys: Int64Array,
    best: Int32Array,
    order: Int64Array,
    count: int,
) -> int:
    """Insert a solution into the sorted list of the best; return the new length.

    keys: (keep,), best: (keep, n): solutions in no order; order: (keep,) says in which.
    distinct: no widths come twice; else equal ones stay once, with the smaller key. The same
    length as before and a full list means that it was left out, or that another made room.
    """
    keep = len(order)
    at = count
    last = -1
    for i in range(count - 1, -1, -1):
        other = order[i]
        equal = True
        smaller = False
        for p in range(len(widths)):
            if widths[p] != best[other, p]:
                equal = False
                smaller = widths[p] < best[other, p]
                break
        if equal and keys[other] <= key:
            return count
        if keys[other] > key or (keys[other] == key and smaller):
            at = i
        elif distinct:
            break
        if equal:
            last = i
    if at == keep:
        return count
    if last >= 0:
        slot = order[last]
    else:
        slot = count if count < keep else order[keep - 1]
        count = min(count + 1, keep)
        last = count - 1
    for i in range(last, at, -1):
        order[i] = order[i - 1]
    order[at] = slot
    keys[slot] = key
    best[slot] = widths
    return count


@kernel
def class_cost(parts: int, weight: int, tolerance: int, value: int) -> int:
    """The least key that a class of this value adds.

    parts: its polychords; 0 for a class of a tolerance, of which the first of each pair
    counts by how much it differs from the tolerance, and the other (weight 0) nothing.
    """
    if parts == 0:
        return OFF * weight * abs(value - tolerance)
    return weight * even_cost(parts, value)


@kernel
def add_most_even(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    class_weight: Int32Array,
    class_of: Int32Array,
    chord_of: Int32Array,
    own: Int32Array,
    chord_weight: Int32Array,
    tolerance: int,
    tag: int,
    keys: Int64Array,
    best: Int32Array,
    order: Int64Array,
    count: int,
    cancelled: NDArray[np.uint8],
) -> int:
    """Add the solutions of a system to the list of the best; return its new length.

    slack: (w,) >= 0; class_i, class_j, class_n, class_weight: (m,), see
    :class:`.systems.Chords`, with class_n 0 and class_weight 1, 0 for the two classes of
    a tolerance. class_of, chord_of: (parts,) class and polychord of every part; own: (n,) the
    width of every polychord when its parts have slack 0; chord_weight: (n,).
    keys: (keep,), best: (keep, n + 1), order: (keep,) hold ``count`` solutions, of other
    systems of the same polychords, in order; behind its widths each has the tag of its system.
    At the end they hold the best of all; where fewer than ``keep``, all there are. Equal
    widths with unlike tags are two solutions. cancelled: (1,), where it is 1, some are missing.
    """
    w = len(slack)
    m = len(class_i)
    n = len(own)
    keep = len(order)
    divided = len(chord_of) > n
    u = find_prices(slack, class_i, class_j, class_n, class_weight)
    # The excess of class k at y is SCALE * cost(y) - price * y - floor, 0 at ``bottom``.
    price = np.empty(m, np.int64)
    bottom = np.empty(m, np.int64)
    floor = np.empty(m, np.int64)
    constant = 0
    for s in range(w):
        constant += u[s] * slack[s]
    for k in range(m):
        price[k] = u[class_i[k]] + u[class_j[k]]
        if class_n[k] > 0:
            # Widening all from 1 + q to 2 + q pays off while weight * (2 q + 3) <= price.
            q = (price[k] // (SCALE * class_weight[k]) - 3) // 2 + 1
            bottom[k] = max(0, q) * class_n[k]
        elif class_weight[k] > 0 and abs(price[k]) <= SCALE * OFF:
            bottom[k] = tolerance
        else:
            bottom[k] = 2 * tolerance if price[k] > 0 else 0
        floor[k] = (
            SCALE * class_cost(int(class_n[k]), int(class_weight[k]), tolerance, int(bottom[k]))
            - price[k] * bottom[k]
        )
        constant += floor[k]

    room = keep
    buffer = np.empty((room, len(class_of)), np.int32)
    widths = np.empty(n + 1, np.int32)
    widths[n] = tag
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
    # What the parts' own squares leave out of a key at least.
    missing = 0
    for p in range(len(class_of)):
        missing -= class_weight[class_of[p]]
    for c in range(n):
        missing += chord_weight[c] * own[c] * own[c]
    dead_ends = 0
    depth = 0
    down = True
    while not cancelled[0]:
        if down:
            down = False
            ready = False
            k, least, most = choose_class(residual, class_i, class_j, m, closed, degree, reach)
            if dead_ends > PATIENCE and k >= 0 and least < most:
                least, most = tighten_bounds(
                    residual, class_i, class_j, m, closed, k, least, most, flow
                )
            if k == DONE:
                dead_ends = 0
                off = 0
                parts_key = 0
                for c in range(m):
                    cost = class_cost(int(class_n[c]), int(class_weight[c]), tolerance, value[c])
                    if class_n[c] == 0:
                        off += cost
                    else:
                        parts_key += cost
                got = 0
                while (divided or got < keep) and parts_key < INFINITE and not cancelled[0]:
                    if count == keep and off + parts_key + missing > keys[order[keep - 1]]:
                        break
                    found, above = spread_slack(
                        value,
                        class_n,
                        class_weight,
                        class_of,
                        parts_key,
                        True,
                        buffer,
                        room if divided else keep - got,
                        cancelled,
                    )
                    if divided and found == room:
                        # Unlike keys may hide among equal ones of the parts: take them all.
                        room *= 4
                        buffer = np.empty((room, len(class_of)), np.int32)
                        continue
                    for r in range(found):
                        key = off
                        for c in range(n):
                            widths[c] = own[c]
                        for p in range(len(class_of)):
                            widths[chord_of[p]] += buffer[r, p] - 1
                        for c in range(n):
                            key += chord_weight[c] * widths[c] * widths[c]
                        if count < keep or key <= keys[order[keep - 1]]:
                            count = insert_solution(
                                key, widths, not divided, keys, best, order, count
                            )
                    got += found
                    parts_key = above
            elif k >= 0 and least <= most:
                ready = True
                if least < most:
                    two_colour(class_i, class_j, m, closed, component, colour, reach)
                    ready = is_balanced(residual, component, colour, reach)
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
                budget = SCALE * (keys[order[keep - 1]] - missing) - constant
            excess = INFINITE
            y = left[d]
            parts = int(class_n[k])
            weight = int(class_weight[k])
            if left[d] >= low[d]:
                excess = SCALE * class_cost(parts, weight, tolerance, y) - price[k] * y - floor[k]
            if right[d] <= high[d]:
                y = right[d]
                other = SCALE * class_cost(parts, weight, tolerance, y) - price[k] * y - floor[k]
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
    return count
