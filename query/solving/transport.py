"""Can the sides' slack be met with halves? The relaxation of the matching, by flow.

Doubled, a half-integral matching is an integral flow from every side to a copy of every
side: slack_i units leave i and arrive at its copy, and class (i, j) carries any number
of units from i to the copy of j and from j to the copy of i. Where there is no such flow
there is no matching, and the values that one class takes in all flows are an interval:
both cut the search where it would try in vain value by value.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel


@kernel
def transport(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    flow: Int32Array,
    scratch: Int32Array,
) -> bool:
    """Find a flow over the open classes; False where there is none.

    slack: (w,); closed: (m,). flow: (2, m) int32, overwritten: units of class k from i to
    j, and from j to i (0 where i = j). scratch: (5, w) int32.
    """
    w = len(slack)
    supply = scratch[0]
    demand = scratch[1]
    # How breadth-first search reached each side and each copy: class and direction.
    side_by = scratch[2]
    copy_by = scratch[3]
    queue = scratch[4]
    # Most calls end here: a side asks for more than all its neighbours can give.
    reach = queue
    for s in range(w):
        reach[s] = 0
    for k in range(n_classes):
        if not closed[k]:
            reach[class_i[k]] += slack[class_j[k]]
            reach[class_j[k]] += slack[class_i[k]]
    for s in range(w):
        if slack[s] > reach[s]:
            return False
    for s in range(w):
        supply[s] = slack[s]
        demand[s] = slack[s]
    for k in range(n_classes):
        flow[0, k] = 0
        flow[1, k] = 0
        if closed[k]:
            continue
        i = class_i[k]
        j = class_j[k]
        f = min(supply[i], demand[j])
        flow[0, k] = f
        supply[i] -= f
        demand[j] -= f
        if i != j:
            f = min(supply[j], demand[i])
            flow[1, k] = f
            supply[j] -= f
            demand[i] -= f
    for source in range(w):
        while supply[source] > 0:
            for s in range(w):
                side_by[s] = -1
                copy_by[s] = -1
            queue[0] = source
            head = 0
            tail = 1
            sink = -1
            while head < tail and sink < 0:
                s = queue[head]
                head += 1
                for k in range(n_classes):
                    if closed[k]:
                        continue
                    if class_i[k] == s:
                        copy = class_j[k]
                        arc = 2 * k
                    elif class_j[k] == s:
                        copy = class_i[k]
                        arc = 2 * k + 1
                    else:
                        continue
                    if copy_by[copy] >= 0:
                        continue
                    copy_by[copy] = arc
                    if demand[copy] > 0:
                        sink = copy
                        break
                    # Units that arrive here may be sent elsewhere by the side they left.
                    for b in range(n_classes):
                        for back in range(2):
                            if flow[back, b] == 0:
                                continue
                            end = class_j[b] if back == 0 else class_i[b]
                            if end != copy:
                                continue
                            start = class_i[b] if back == 0 else class_j[b]
                            if start != source and side_by[start] < 0:
                                side_by[start] = 2 * b + back
                                queue[tail] = start
                                tail += 1
            if sink < 0:
                return False
            amount = min(supply[source], demand[sink])
            for widen in (False, True):
                copy = sink
                while True:
                    arc = copy_by[copy]
                    k = arc >> 1
                    side = class_i[k] if arc & 1 == 0 else class_j[k]
                    if widen:
                        flow[arc & 1, k] += amount
                    if side == source:
                        break
                    arc = side_by[side]
                    k = arc >> 1
                    copy = class_j[k] if arc & 1 == 0 else class_i[k]
                    if widen:
                        flow[arc & 1, k] -= amount
                    else:
                        amount = min(amount, flow[arc & 1, k])
            supply[source] -= amount
            demand[sink] -= amount
    return True


@kernel
def integral(flow: Int32Array, n_classes: int) -> bool:
    """Is half the flow a matching, no class taking half a unit?"""
    odd = 0
    for k in range(n_classes):
        odd += (flow[0, k] + flow[1, k]) % 2
    return odd == 0


@kernel
def tighten(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    k: int,
    low: int,
    high: int,
    flow: Int32Array,
    scratch: Int32Array,
) -> tuple[int, int]:
    """The least and greatest integer in low..high that class k takes in some flow.

    Arguments as in :func:`transport`; the first is above the second where there is none.
    """
    if not transport(slack, class_i, class_j, n_classes, closed, flow, scratch):
        return 1, 0
    i = class_i[k]
    j = class_j[k]
    # A flow carries y from either end; a class with both ends on one side carries 2 y.
    twice = flow[0, k] + flow[1, k]
    below = twice // 2
    above = twice - below
    closed[k] = True
    # Bisect: good is a value that some flow takes, bad one beyond all of them.
    for up in (False, True):
        good = above if up else below
        bad = high + 1 if up else low - 1
        first = good
        good -= 1 if up else -1
        while abs(bad - good) > 1:
            middle = (good + bad) // 2
            slack[i] -= middle
            slack[j] -= middle
            if transport(slack, class_i, class_j, n_classes, closed, flow, scratch):
                good = middle
            else:
                bad = middle
            slack[i] += middle
            slack[j] += middle
        if up:
            high = good if good >= first else below
        else:
            low = good if good <= first else above
    closed[k] = False
    return low, high
