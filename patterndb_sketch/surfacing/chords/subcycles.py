"""The sub-cycles that chords can cut out of a cycle: counted and numbered without a search.

Every chord on the boundary of a sub-cycle stands for a stretch of the cycle that was cut off,
and no two such stretches overlap. Conversely, every set of chords with stretches that do not
overlap bounds a sub-cycle that some order of cuts reaches. Take as ends the vertices where
chords end, 0 to k - 1 around the cycle, and end 0 once more as end k. Call a chord (i, j), i < j,
a wrap if the stretch cut off is the one that contains the arc from end k - 1 to end 0, else a
jump. At most one chord of a sub-cycle is its wrap. So a sub-cycle is

- a path from 0 to k (no wrap), or from i to j (its wrap is (i, j), which is not the whole path),
- whose steps are arcs from an end to the next, and jumps.

Paths are counted by a small table. They are numbered, within those of one wrap, in the order in
which, at the first step where two differ, the longer jump comes first and the arc last. A number
is the sum of its steps' offsets. To cut a sub-cycle replaces a part of the path by a jump: the
number becomes smaller, by an amount that follows from the part alone. So the sub-cycles evaluated
in the order of their numbers meet their parts evaluated, and the number replaces a hash table.

Differs from the paper (Abbasinejad et al. 2013, section 3.2): its hash key, the chords on the
boundary, cannot tell the two sides of a chord apart. Here they are the path beyond the jump and
the path under the wrap. There is no limit to the number of ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.system.kernels import kernel

#: Counts stop here: exact below, "this many or more" at it. Twice this is still an int64.
#: The same as in rust/surfacing/src/chords/subcycles.rs.
MOST_COUNTED = 2**61


class Subcycles(NamedTuple):
    """The numbering of the sub-cycles of a cycle.

    ends:     (k,) positions in the loop where chords end, ascending.
    first, last: (m,) the ends that the chords join, first < last.
    starting: (m,) the chords by their first end, those of one end the longest first;
    start_at: (k + 2,) where each end's begin in it.
    ending:   (m,) the chords by their last end, those of one end the shortest first;
    end_at:   (k + 2,) where each end's begin in it.
    paths:    (k + 1, k + 1) [b, a] how many paths there are from end a to end b.
    offsets:  (k + 1, m) [b, c] what jump c adds to the number of a path to end b.
    base:     (m + 1,) where the paths under each wrap begin, and those without one.
    n_all:    how many sub-cycles there are, the cycle itself among them.
    """

    ends: Int64Array
    first: Int64Array
    last: Int64Array
    starting: Int64Array
    start_at: Int64Array
    ending: Int64Array
    end_at: Int64Array
    paths: Int64Array
    offsets: Int64Array
    base: Int64Array
    n_all: int


@kernel
def number_subcycles(n: int, chords: Int64Array) -> Subcycles:
    """The numbering for a loop of n vertices and its chords (m, 2), positions i < j, no two alike.

    If there are MOST_COUNTED sub-cycles or more, only the count is of use.
    """
    m = len(chords)
    end_of = np.full(n, -1, np.int64)
    for c in range(m):
        end_of[chords[c, 0]] = 0
        end_of[chords[c, 1]] = 0
    ends = np.flatnonzero(end_of == 0)
    k = len(ends)
    for i in range(k):
        end_of[ends[i]] = i
    first = np.empty(m, np.int64)
    last = np.empty(m, np.int64)
    for c in range(m):
        first[c] = end_of[chords[c, 0]]
        last[c] = end_of[chords[c, 1]]
    starting, start_at = _grouped(first, last, k)
    ending, end_at = _grouped(last, first, k)
    paths = np.zeros((k + 1, k + 1), np.int64)
    offsets = np.zeros((k + 1, m), np.int64)
    for b in range(k + 1):
        paths[b, b] = 1
        for a in range(b - 1, -1, -1):
            found = 0
            for s in range(start_at[a], start_at[a + 1]):
                c = starting[s]
                offsets[b, c] = found
                if last[c] <= b:
                    found = min(MOST_COUNTED, found + paths[b, last[c]])
            paths[b, a] = min(MOST_COUNTED, found + paths[b, a + 1])
    base = np.empty(m + 1, np.int64)
    count, at = 0, 0
    for c in range(m):
        base[c] = at
        inside = paths[last[c], first[c]]
        at = min(MOST_COUNTED, at + inside)
        # The path that is the wrap itself, number 0, is no sub-cycle.
        count = min(MOST_COUNTED, count + inside - 1)
    base[m] = at
    count = min(MOST_COUNTED, count + paths[k, 0])
    return Subcycles(
        ends, first, last, starting, start_at, ending, end_at, paths, offsets, base, count
    )


@kernel
def _grouped(by: Int64Array, then: Int64Array, k: int) -> tuple[Int64Array, Int64Array]:
    """The chords (m,) by one end, those of the same by the other descending, and where in that
    order (k + 2,) those of every end begin."""
    m = len(by)
    # Sorted by counting, twice: each keeps the order of what it finds equal.
    order = np.arange(m)
    at = np.zeros(k + 2, np.int64)
    for key in (k - then, by):
        before = order.copy()
        at[:] = 0
        for c in range(m):
            at[key[c] + 1] += 1
        for i in range(k + 1):
            at[i + 1] += at[i]
        filled = at.copy()
        for c in before:
            order[filled[key[c]]] = c
            filled[key[c]] += 1
    return order, at


def count_subproblems(n: int, chords: Int64Array) -> int:
    """How many sub-problems a loop of n vertices has with these chords (m, 2), at most
    MOST_COUNTED: its sub-cycles. Found in polynomial time, without a search."""
    return int(_counted(n, np.ascontiguousarray(chords, np.int64)))


@kernel
def _counted(n: int, chords: Int64Array) -> int:
    return number_subcycles(n, chords).n_all


@kernel
def path_of(
    numbering: Subcycles, wrap: int, number: int, path: Int64Array, steps: Int64Array
) -> int:
    """Write the ends and steps of a path; returns how many steps it has.

    wrap: the sub-cycle's wrap, or m for none. steps: a jump's chord, or -1 for an arc.
    """
    m = len(numbering.first)
    at, stop = 0, len(numbering.ends)
    if wrap < m:
        at, stop = numbering.first[wrap], numbering.last[wrap]
    n_steps = 0
    path[0] = at
    while at < stop:
        step, to = -1, at + 1
        for s in range(numbering.start_at[at], numbering.start_at[at + 1]):
            c = numbering.starting[s]
            if numbering.last[c] <= stop:
                inside = numbering.paths[stop, numbering.last[c]]
                if number < inside:
                    step, to = c, numbering.last[c]
                    break
                number -= inside
        steps[n_steps] = step
        n_steps += 1
        at = to
        path[n_steps] = at
    return n_steps


@kernel
def part_number(
    numbering: Subcycles, path: Int64Array, steps: Int64Array, start: int, stop: int
) -> int:
    """The number of a part of a path, from its step ``start`` to before its step ``stop``, among
    the paths between the same ends."""
    to = path[stop]
    number = 0
    for t in range(start, stop):
        number += step_offset(numbering, path[t], steps[t], to)
    return number


@kernel
def step_offset(numbering: Subcycles, at: int, step: int, to: int) -> int:
    """What a step from the end ``at`` adds to the number of a path that goes on to ``to``."""
    if step >= 0:
        return numbering.offsets[to, step]
    return numbering.paths[to, at] - numbering.paths[to, at + 1]
