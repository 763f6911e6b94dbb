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

import numpy as np

from patterndb._native.surfacing.chords.subcycles import counted
from patterndb.core.halfedge import Int64Array

#: Counts stop here: exact below, "this many or more" at it. Twice this is still an int64.
#: The same as in rust/surfacing/src/chords/subcycles.rs.
MOST_COUNTED = 2**61


def count_subproblems(n: int, chords: Int64Array) -> int:
    """How many sub-problems a loop of n vertices has with these chords (m, 2), at most
    MOST_COUNTED: its sub-cycles. Found in polynomial time, without a search."""
    return int(counted(n, np.ascontiguousarray(chords, np.int64)))
