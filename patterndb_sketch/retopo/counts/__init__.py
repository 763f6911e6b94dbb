"""Subdivision counts for a whole network: every patch even, regular where it can be.

Evening (a T-join) -> strips -> walks -> balls; see :func:`choose`, :func:`changed`.
"""

from patterndb_sketch.retopo.counts.choosing import Counts, changed, choose, improved, improvements
from patterndb_sketch.retopo.counts.evening import Stuck
from patterndb_sketch.retopo.counts.problem import REGULARITY, CheapRule, CountsProblem
from patterndb_sketch.retopo.counts.rules import family_rule, has_cheap_fill, judged_narrowly

__all__ = [
    "REGULARITY",
    "CheapRule",
    "Counts",
    "CountsProblem",
    "Stuck",
    "changed",
    "choose",
    "family_rule",
    "has_cheap_fill",
    "improved",
    "improvements",
    "judged_narrowly",
]
