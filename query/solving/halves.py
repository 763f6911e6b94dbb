"""Can the sides' slack be met with halves? A flow over lists of neighbours.

The same flow as in :mod:`query.solving.transport`, for many thousand systems a query: each begins
with a guess that is often right, and where there is no flow the sides that ask for too
much are named, which answers other orientations of the system as well.
"""

from __future__ import annotations

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from query.solving.systems import Int16Array

#: Rows of scratch in :func:`meet`: units that a side has still to send and a copy to
#: receive; the copy whose inflow was cut back to reach a side, and the side that a copy was
#: reached from; the sides reached, in order.
SUPPLY = 0
DEMAND = 1
SIDE_BY = 2
COPY_BY = 3
QUEUE = 4


@kernel(inline="always")
def meet(
    slack: Int32Array,
    row: int,
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
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
            sink, tail = _reach(source, row, near_first, near, flow, scratch)
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
        for a in range(near_first[row, s], near_first[row, s + 1]):
            copy = near[a]
            if scratch[COPY_BY, copy] >= 0:
                continue
            scratch[COPY_BY, copy] = s
            if scratch[DEMAND, copy] > 0:
                return copy, tail
            # Units that arrive here may be sent elsewhere by the side they left.
            for b in range(near_first[row, copy], near_first[row, copy + 1]):
                t = near[b]
                if scratch[SIDE_BY, t] < 0 and flow[t, copy] > 0:
                    scratch[SIDE_BY, t] = copy
                    scratch[QUEUE, tail] = t
                    tail += 1
    return -1, tail
