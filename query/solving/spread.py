"""How one class's slack is split among its polychords, most evenly first."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel

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
def spread(
    value: Int32Array,
    class_n: Int32Array,
    class_weight: Int32Array,
    class_of: Int32Array,
    budget: int,
    exactly: bool,
    rows: Int32Array,
    room: int,
) -> tuple[int, int]:
    """Write the widths that split each class's value among its polychords.

    In lexicographic order, at most ``room`` of them: those whose key is at most
    ``budget``, or with ``exactly`` equals it. value: (m,) slack of each class, class_weight:
    (m,) what the square of a width counts there; rows: (>= room, n) int32. Classes of 0
    polychords have nothing to split. Returns (number written, the least key above the
    budget, or INFINITE). The bound is met by a real solution, so no branch is in vain.
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
    while c >= 0 and count < room:
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
