"""Subdivision counts for a whole network: every patch even, regular where it can be.

Evening (a T-join) -> strips -> walks -> balls; see :func:`choose`, :func:`changed`.
"""

from sketch.retopo.counts.choosing import Counts, changed, choose, improved, improvements
from sketch.retopo.counts.evening import Stuck
from sketch.retopo.counts.problem import REGULARITY, CheapRule, CountsProblem
from sketch.retopo.counts.rules import family_rule, has_cheap_fill, judged_narrowly

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
