"""The uncapacitated b-matching on the sides of one pattern: is there one, and which are there?

Given slack_i >= 0 for every side and classes that join sides (i, j), find integers
y_ij >= 0 with sum_j y_ij + 2 y_ii = slack_i: how much wider than 1 the polychords of each
class are in sum.

:func:`search_matchings` lists solutions depth-first; :func:`choose_class` says where it branches
and within which bounds, and :func:`query.solving.systems.is_balanced` rejects by parity. Source:
the integer program of Marcias et al. 2015, section 4. Differs from the paper: an own search instead
of a general solver, over classes instead of single polychords, since one class is one variable to
the sides.

:func:`is_matchable` decides whether there is a solution at all. A flow (:mod:`.halves`) gives a
matching with halves. Rounding the halves down leaves some sides short by a few units. The rest is
a matching problem in an ordinary graph, solved by augmenting paths (Edmonds, "Paths, trees, and
flowers", 1965), so that the decision is exact and takes polynomial time.

Give each side as many *copies* as it has slack, and join two copies wherever a class joins
their sides (two copies of one side if that side is joined to itself). A matching of the
sides is a perfect matching of the copies; one that leaves sides short leaves copies single.
If a perfect matching exists, then from every single copy there leads an augmenting path:
the difference of the two matchings. So one search from one single copy either shortens the
deficit or proves that there is no matching at all.

The copies need not all be made: two pairs of each class are enough, and one of a class
that joins a side to itself. Let a shortest augmenting path walk through two pairs of one
class in the same direction, (i', j') first and (i'', j'') later, and let x be the copy
before i'. Then x is joined to i'' as well, since copies of one side have the same
neighbours, and the path that goes from x to i'' at once is shorter. So each direction
occurs at most once; a class of a side with itself has only one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from query.solving.halves import meet_slack, tighten_bounds
from query.solving.systems import (
    Int16Array,
    is_balanced,
    list_neighbours,
    order_classes,
    two_colour,
)

#: Pairs of a class that a shortest augmenting path may use: one in each direction.
PAIRS = 2


@kernel(inline="always")
def is_matchable(
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
    """Is there a matching that gives every side its slack? Return 0 if so.

    Arguments and result are those of :func:`query.solving.halves.meet_slack`, but that the result
    is -1 where only halves would do. flow: overwritten.
    """
    cut = meet_slack(slack, row, first, class_i, class_j, claim, near_first, near, flow, scratch)
    if cut > 0:
        return cut
    odd = False
    for k in range(first[row], first[row + 1]):
        i = class_i[k]
        j = class_j[k]
        odd |= (flow[i, j] if i == j else flow[i, j] + flow[j, i]) & 1 != 0
    if not odd:
        return 0
    if _round(row, first, class_i, class_j, claim[row], near_first, near, flow, scratch[0]):
        return 0
    return -1


@kernel
def is_soluble(
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    n_classes: int,
    closed: NDArray[np.bool_],
) -> bool:
    """Do the open classes meet the slack? Exact, where :func:`.halves.find_transport` has halves.

    slack: (w,) >= 0; class_i, class_j: (m,) int32, several may join the same sides; closed:
    (m,) bool.
    """
    w = len(slack)
    joined = np.zeros((w, w), np.bool_)
    for k in range(n_classes):
        if not closed[k]:
            joined[class_i[k], class_j[k]] = True
            joined[class_j[k], class_i[k]] = True
    ordered_i = np.empty(w * (w + 1) // 2, np.int16)
    ordered_j = np.empty(w * (w + 1) // 2, np.int16)
    scratch = np.empty((5, w), np.int32)
    first = np.zeros(2, np.int32)
    first[1] = order_classes(joined, ordered_i, ordered_j, scratch[0])
    claim = np.arange(w).astype(np.int32).reshape(1, w)
    near_first = np.empty(w + 1, np.int32)
    near = np.empty(w * w, np.int16)
    list_neighbours(joined, near_first, near)
    flow = np.empty((w, w), np.int32)
    cut = is_matchable(
        slack, 0, first, ordered_i, ordered_j, claim, near_first, near, flow, scratch
    )
    return cut == 0


@kernel
def _round(
    row: int,
    first: Int32Array,
    class_i: Int16Array,
    class_j: Int16Array,
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    y: Int32Array,
    short: Int32Array,
) -> bool:
    """Turn the flow y into a matching, symmetric; False where there is none.

    claim, short: (w,), of this graph.
    """
    w = len(short)
    short[:] = 0
    for k in range(first[row], first[row + 1]):
        i = class_i[k]
        j = class_j[k]
        twice = y[i, j] if i == j else y[i, j] + y[j, i]
        y[i, j] = twice >> 1
        y[j, i] = twice >> 1
        short[i] += twice & 1
        short[j] += twice & 1
    for s in range(w):
        # Two halves each.
        short[s] >>= 1
    for k in range(first[row], first[row + 1]):
        i = class_i[k]
        j = class_j[k]
        more = short[i] >> 1 if i == j else min(short[i], short[j])
        y[i, j] += more
        short[i] -= more
        short[j] -= more
        y[j, i] = y[i, j]
    for s in range(w):
        while short[s] > 0:
            # Copies take long to make, and most sides need none.
            if not _take_detour(s, claim, near_first, near, y, short) and not _augment(
                s, claim, near_first, near, y, short
            ):
                return False
    return True


@kernel
def _take_detour(
    side: int,
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    y: Int32Array,
    short: Int32Array,
) -> bool:
    """Make the side and another one, or itself once more, less short by one each, by an augmenting
    path of three edges, if there is one: a class that two neighbours share gives up one.

    y, short: as in :func:`_augment`.
    """
    p = claim[side]
    for a in range(near_first[p], near_first[p + 1]):
        one = near[a]
        q = claim[one]
        for b in range(near_first[q], near_first[q + 1]):
            other = near[b]
            # A side that is joined to itself may be its own neighbour; then it is not short.
            if one == side or other == side or y[one, other] == 0:
                continue
            r = claim[other]
            for c in range(near_first[r], near_first[r + 1]):
                end = near[c]
                if end != other and short[end] > (1 if end == side else 0):
                    _widen(side, one, 1, y)
                    _widen(one, other, -1, y)
                    _widen(other, end, 1, y)
                    short[side] -= 1
                    short[end] -= 1
                    return True
    return False


@kernel
def _augment(
    root_side: int,
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    y: Int32Array,
    short: Int32Array,
) -> bool:
    """Make the side and another one, or itself once more, less short by one each.

    y: (w, w) int32 symmetric, short: (w,) int32; both updated. False where no augmenting
    path begins at the side: then there is no matching.
    """
    start, side_of, mate = _copies(claim, near_first, near, y, short)
    n = len(mate)
    # For a copy at odd distance from the root, the copy before it on an alternating path.
    by = np.full(n, -1, np.int32)
    base = np.arange(n).astype(np.int32)
    even = np.zeros(n, np.bool_)
    mark = np.empty(n, np.bool_)
    queue = np.empty(n, np.int32)
    root = start[root_side]
    while mate[root] >= 0:
        root += 1
    even[root] = True
    queue[0] = root
    head = 0
    tail = 1
    while head < tail:
        v = queue[head]
        head += 1
        q = claim[side_of[v]]
        for a in range(near_first[q], near_first[q + 1]):
            for u in range(start[near[a]], start[near[a] + 1]):
                if base[u] == base[v] or mate[v] == u:
                    continue
                if u == root or (mate[u] >= 0 and by[mate[u]] >= 0):
                    tail = _contract(u, v, mate, by, base, even, mark, queue, tail)
                elif by[u] < 0:
                    by[u] = v
                    if mate[u] >= 0:
                        even[mate[u]] = True
                        queue[tail] = mate[u]
                        tail += 1
                        continue
                    short[root_side] -= 1
                    short[side_of[u]] -= 1
                    while u >= 0:
                        before = int(by[u])
                        after = int(mate[before])
                        _widen(int(side_of[u]), int(side_of[before]), 1, y)
                        if after >= 0:
                            _widen(int(side_of[before]), int(side_of[after]), -1, y)
                        u = after
                    return True
    return False


@kernel
def _widen(i: int, j: int, by: int, y: Int32Array) -> None:
    y[i, j] += by
    if i != j:
        y[j, i] += by


@kernel
def _copies(
    claim: Int32Array,
    near_first: Int32Array,
    near: Int16Array,
    y: Int32Array,
    short: Int32Array,
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """The copies that a shortest augmenting path may need, those of side s from start[s] on.

    Returns ((w + 1,) int32 start, and for every copy its side and its mate or -1).
    """
    w = len(short)
    start = np.zeros(w + 1, np.int32)
    for i in range(w):
        count = short[i]
        for a in range(near_first[claim[i]], near_first[claim[i] + 1]):
            if near[a] == i:
                # One pair, both of this side.
                count += 2 * min(y[i, i], 1)
            else:
                count += min(y[i, near[a]], PAIRS)
        start[i + 1] = start[i] + count
    side_of = np.empty(start[w], np.int32)
    mate = np.full(start[w], -1, np.int32)
    free = start[:w].copy()
    for i in range(w):
        side_of[start[i] : start[i + 1]] = i
        for a in range(near_first[claim[i]], near_first[claim[i] + 1]):
            j = near[a]
            if j < i:
                continue
            for _ in range(min(y[i, j], PAIRS if i != j else 1)):
                one = free[i]
                free[i] += 1
                other = free[j]
                free[j] += 1
                mate[one] = other
                mate[other] = one
    return start, side_of, mate


@kernel
def _contract(
    u: int,
    v: int,
    mate: Int32Array,
    by: Int32Array,
    base: Int32Array,
    even: NDArray[np.bool_],
    mark: NDArray[np.bool_],
    queue: Int32Array,
    tail: int,
) -> int:
    """Shrink the odd cycle that the edge (u, v) closes; its copies are all even now.

    Returns the new end of the queue.
    """
    n = len(mate)
    mark[:] = False
    a = base[u]
    while True:
        mark[a] = True
        if mate[a] < 0:
            break
        a = base[by[mate[a]]]
    stem = base[v]
    while not mark[stem]:
        stem = base[by[mate[stem]]]
    mark[:] = False
    for end in range(2):
        a = v if end == 0 else u
        child = u if end == 0 else v
        while base[a] != stem:
            mark[base[a]] = True
            mark[base[mate[a]]] = True
            by[a] = child
            child = mate[a]
            a = by[child]
    for c in range(n):
        if mark[base[c]]:
            base[c] = stem
            if not even[c]:
                even[c] = True
                queue[tail] = c
                tail += 1
    return tail


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
def choose_class(
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
def count_splits(value: int, parts: int) -> int:
    """How many ways there are to write value >= 0 as an ordered sum of parts, capped at MANY."""
    ways = 1
    for p in range(1, parts):
        # C(value + p, p) from C(value + p - 1, p - 1): the division is exact.
        if ways > MANY:
            return MANY
        ways = ways * (value + p) // p
    return min(ways, MANY)


@kernel
def search_matchings(
    slack: Int32Array, class_i: Int32Array, class_j: Int32Array, class_n: Int32Array, limit: int
) -> tuple[Int32Array, int]:
    """List solutions until they stand for more than ``limit`` widths.

    slack: (w,) int32; class_n: (m,) polychords of each class, so that a row stands for the
    product of their :func:`count_splits`. Returns ((r, m) int32 rows, widths they stand for, at
    most MANY): the list is whole exactly if the second is at most ``limit``.
    """
    n_sides = len(slack)
    n_classes = len(class_n)
    residual = slack.copy()
    closed = np.zeros(n_classes, np.bool_)
    rows = np.empty((1, n_classes), np.int32)
    degree = np.empty(n_sides, np.int32)
    reach = np.empty(n_sides, np.int32)
    component = np.empty(n_sides, np.int32)
    colour = np.empty(n_sides, np.int32)
    stack = np.empty(n_sides, np.int32)
    chosen = np.empty(n_classes, np.int32)
    value = np.empty(n_classes, np.int32)
    least = np.empty(n_classes, np.int32)
    found = 0
    widths = 0
    depth = 0
    dead_ends = 0
    flow = np.empty((2, n_classes), np.int32)
    down = True
    while True:
        if down:
            down = False
            k, low, high = choose_class(
                residual, class_i, class_j, n_classes, closed, degree, reach
            )
            if dead_ends > PATIENCE and k >= 0 and low < high:
                if is_soluble(residual, class_i, class_j, n_classes, closed):
                    low, high = tighten_bounds(
                        residual,
                        class_i,
                        class_j,
                        n_classes,
                        closed,
                        k,
                        low,
                        high,
                        flow,
                    )
                else:
                    k = DEAD
            if k == DONE:
                if found == len(rows):
                    rows = np.concatenate((rows, np.empty_like(rows)))
                ways = 1
                for d in range(depth):
                    rows[found, chosen[d]] = value[d]
                    ways *= count_splits(int(value[d]), int(class_n[chosen[d]]))
                    ways = min(ways, MANY)
                found += 1
                widths = min(widths + ways, MANY)
                if widths > limit:
                    return rows[:found].copy(), widths
            elif k >= 0 and low <= high:
                down = True
                # Parity is dear to test: only where there is a choice to be spared.
                if low < high:
                    two_colour(class_i, class_j, n_classes, closed, component, colour, stack)
                    down = is_balanced(residual, component, colour, stack)
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
            return rows[:found].copy(), widths
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
