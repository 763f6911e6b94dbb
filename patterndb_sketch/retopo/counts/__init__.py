"""Edge counts for a whole network: every patch even, regular where it can be.

Read :mod:`.problem` (the question, and which patches are regular), :mod:`.parity` (even counts, by
a T-join), :mod:`.cycles` and :mod:`.neighbourhoods` (better ones), then :mod:`.choosing`, which
puts them together: see :func:`solve_counts` and :func:`change_count`.
"""

from patterndb_sketch.retopo.counts.choosing import (
    MOST_NEIGHBOURHOODS,
    Counts,
    change_count,
    solve_counts,
)
from patterndb_sketch.retopo.counts.parity import Stuck, even_by_fewest_changes
from patterndb_sketch.retopo.counts.problem import (
    FLOW_REGULARITY,
    REGULARITY,
    CountsProblem,
    has_regular_fill,
)

__all__ = [
    "FLOW_REGULARITY",
    "MOST_NEIGHBOURHOODS",
    "REGULARITY",
    "Counts",
    "CountsProblem",
    "Stuck",
    "change_count",
    "even_by_fewest_changes",
    "has_regular_fill",
    "solve_counts",
]
