"""Subdivision counts for a whole network: every patch even, regular where it can be.

Read :mod:`.problem` (what is asked), :mod:`.rules` (which patches are regular), :mod:`.tjoin` and
:mod:`.evening` (even counts), :mod:`.walks` and :mod:`.balls` (better ones), then :mod:`.choosing`,
which puts them together: evening by a T-join -> walks -> balls; see :func:`solve_counts` and
:func:`change_count`.
"""

from patterndb_sketch.retopo.counts.choosing import (
    Counts,
    change_count,
    improve_change,
    improve_counts,
    solve_counts,
)
from patterndb_sketch.retopo.counts.evening import Stuck
from patterndb_sketch.retopo.counts.problem import (
    FLOW_REGULARITY,
    REGULARITY,
    CheapRule,
    CountsProblem,
)
from patterndb_sketch.retopo.counts.rules import (
    find_misjudged_patches,
    has_cheap_fill,
    is_cheap_by_family,
)

__all__ = [
    "FLOW_REGULARITY",
    "REGULARITY",
    "CheapRule",
    "Counts",
    "CountsProblem",
    "Stuck",
    "change_count",
    "find_misjudged_patches",
    "has_cheap_fill",
    "improve_change",
    "improve_counts",
    "is_cheap_by_family",
    "solve_counts",
]
