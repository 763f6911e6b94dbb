"""Can the sides' slack be met with halves? The relaxation of the matching, by flow.

Doubled, a half-integral matching is an integral flow from every side to a copy of every
side: slack_i units leave i and arrive at its copy, and class (i, j) carries any number
of units from i to the copy of j and from j to the copy of i. Where there is no such flow
there is no matching.

Two kernels find one. :func:`meet_slack` is for many thousand systems a query, as lists of
neighbours: each begins with a guess that is often right, and where there is no flow the sides that
ask for too much are named, which answers other orientations of the system as well.
:func:`find_transport` is for one system whose classes are decided one after another: the values
that one class takes in all flows are an interval (:func:`tighten_bounds`), which cuts the search
where it would try in vain value by value.

scipy's maximum_flow gives the same answers, takes some 250 times as long for one system
(benchmarks/feasibility.py), and cannot be called within a kernel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from query.solving.systems import Int16Array

#: Rows of scratch in :func:`meet_slack`: units that a side has still to send and a copy to
#: receive; the copy whose inflow was cut back to reach a side, and the side that a copy was
#: reached from; the sides reached, in order.
SUPPLY = 0
DEMAND = 1
SIDE_BY = 2
COPY_BY = 3
QUEUE = 4


@kernel(inline="always")
def meet_slack(
    slack: Int32Array,
    row: int,
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    flow: Int32Array,
    scratch: Int32Array,
) -> int:
    """Find a flow; return 0, or how many sides ask for more than their neighbours have.

    slack: (w,); first to near: see :class:`.systems.Graphs`, of which this is the graph
    in this row, one by one since a tuple is slow to take apart. flow: (w, w) int32 units
    from a side to a copy, written at neighbours only; scratch: (5, w) int32. Where the
    result c is not 0, the sides are scratch[QUEUE, :c], and their neighbours s have
    scratch[COPY_BY, s] >= 0.
    """
    w = len(slack)
    left = _take_shares(slack, row, first, class_i, class_j, flow, scratch)
    if left == 0:
        return 0
    for s in range(w):
        scratch[DEMAND, s] = scratch[SUPPLY, s]
    for source in range(w):
        while scratch[SUPPLY, source] > 0:
            sink, tail = _reach(source, row, claim, near_first, near, flow, scratch)
            if sink < 0:
                return tail
            _augment(source, sink, flow, scratch)
    return 0


@kernel(inline="always")
def _take_shares(
    slack: Int32Array,
    row: int,
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
    flow: Int32Array,
    scratch: Int32Array,
) -> int:
    """Begin the flow: each side in turn shares its slack among its neighbours not yet served,
    in proportion to theirs. Writes what is left to supply; returns the sum of it."""
    left = 0
    for s in range(len(slack)):
        scratch[SUPPLY, s] = slack[s]
        left += slack[s]
    k = first[row]
    last = first[row + 1]
    while k < last:
        i = class_i[k]
        a = scratch[SUPPLY, i]
        end = k
        reach = 0
        while end < last and class_i[end] == i:
            reach += scratch[SUPPLY, class_j[end]]
            end += 1
        # Where a side is joined to itself, it counts as its own neighbour here.
        share = a / reach if reach > 0 else 0.0
        while k < end:
            j = class_j[k]
            k += 1
            if i == j:
                flow[i, i] = a
                left -= a
                a = 0
                continue
            b = scratch[SUPPLY, j]
            f = min(a, b, int(b * share + 0.5))
            flow[i, j] = f
            flow[j, i] = f
            a -= f
            scratch[SUPPLY, j] = b - f
            left -= 2 * f
        scratch[SUPPLY, i] = a
    return left  # pyright: ignore[reportReturnType]


@kernel(inline="always")
def _augment(source: int, sink: int, flow: Int32Array, scratch: Int32Array) -> None:
    """Send as much as can be along the path found, and the same along its mirror image.

    With both, the flow between two sides stays equal in both directions, and so whole
    when halved, for as long as there is a path from one side to the copy of another.
    """
    amount = min(scratch[SUPPLY, source], scratch[DEMAND, sink])
    s = scratch[COPY_BY, sink]
    while s != source:
        amount = min(amount, flow[s, scratch[SIDE_BY, s]])
        s = scratch[COPY_BY, scratch[SIDE_BY, s]]
    copy = sink
    while True:
        s = scratch[COPY_BY, copy]
        flow[s, copy] += amount
        if s == source:
            break
        copy = scratch[SIDE_BY, s]
        flow[s, copy] -= amount
    scratch[SUPPLY, source] -= amount
    scratch[DEMAND, sink] -= amount
    mirrored = source != sink and min(scratch[SUPPLY, sink], scratch[DEMAND, source]) >= amount
    s = scratch[COPY_BY, sink]
    while mirrored and s != source:
        copy = scratch[SIDE_BY, s]
        mirrored = flow[copy, s] >= amount
        s = scratch[COPY_BY, copy]
    if not mirrored:
        return
    copy = sink
    while True:
        s = scratch[COPY_BY, copy]
        flow[copy, s] += amount
        if s == source:
            break
        copy = scratch[SIDE_BY, s]
        flow[copy, s] -= amount
    scratch[SUPPLY, sink] -= amount
    scratch[DEMAND, source] -= amount


@kernel(inline="always")
def _reach(
    source: int,
    row: int,
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    flow: Int32Array,
    scratch: Int32Array,
) -> tuple[int, int]:
    """Search, breadth first, for a copy that takes more, from a side that has more to give.

    Returns (the copy or -1, number of sides reached); they are listed in scratch[QUEUE].
    """
    for s in range(scratch.shape[1]):
        scratch[SIDE_BY, s] = -1
        scratch[COPY_BY, s] = -1
    scratch[SIDE_BY, source] = source
    scratch[QUEUE, 0] = source
    head = 0
    tail = 1
    while head < tail:
        s = scratch[QUEUE, head]
        head += 1
        q = claim[row, s]
        for a in range(near_first[q], near_first[q + 1]):
            copy = near[a]
            if scratch[COPY_BY, copy] >= 0:
                continue
            scratch[COPY_BY, copy] = s
            if scratch[DEMAND, copy] > 0:
                return copy, tail
            # Units that arrive here may be sent elsewhere by the side they left.
            p = claim[row, copy]
            for b in range(near_first[p], near_first[p + 1]):
                t = near[b]
                if scratch[SIDE_BY, t] < 0 and flow[t, copy] > 0:
                    scratch[SIDE_BY, t] = copy
                    scratch[QUEUE, tail] = t
                    tail += 1
    return -1, tail


@kernel
def find_transport(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    flow: Int32Array,
) -> bool:
    """Find a flow over the open classes; False where there is none.

    slack: (w,); closed: (m,). flow: (2, m) int32, overwritten: units of class k from i to
    j, and from j to i (0 where i = j).
    """
    w = len(slack)
    scratch = np.empty((5, w), np.int32)
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
def is_integral(flow: Int32Array, n_classes: int) -> bool:
    """Is half the flow a matching, no class taking half a unit?"""
    odd = 0
    for k in range(n_classes):
        odd += (flow[0, k] + flow[1, k]) % 2
    return odd == 0


@kernel
def tighten_bounds(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
    k: int,
    low: int,
    high: int,
    flow: Int32Array,
) -> tuple[int, int]:
    """The least and greatest integer in low..high that class k takes in some flow.

    Arguments as in :func:`find_transport`; the first is above the second where there is none.
    """
    if not find_transport(slack, class_i, class_j, n_classes, closed, flow):
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
            if find_transport(slack, class_i, class_j, n_classes, closed, flow):
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
