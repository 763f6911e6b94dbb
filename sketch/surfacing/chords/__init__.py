"""The chord decomposition of one cycle: ends -> candidate chords -> search -> pieces.

After Abbasinejad et al. 2013, section 3.
"""

from sketch.surfacing.chords.candidates import Candidates, candidate_chords
from sketch.surfacing.chords.decompose import (
    ALPHA,
    MAX_SUBPROBLEMS,
    Decomposition,
    decompose,
    within_budget,
)
from sketch.surfacing.chords.endpoints import TURNING_BOUND, endpoints, loop_turning
from sketch.surfacing.chords.flatness import Flatness, flatness, is_planar
from sketch.surfacing.chords.search import Cuts, search
from sketch.surfacing.chords.subcycles import MOST_COUNTED, n_subproblems

__all__ = [
    "ALPHA",
    "MAX_SUBPROBLEMS",
    "MOST_COUNTED",
    "TURNING_BOUND",
    "Candidates",
    "Cuts",
    "Decomposition",
    "Flatness",
    "candidate_chords",
    "decompose",
    "endpoints",
    "flatness",
    "is_planar",
    "loop_turning",
    "n_subproblems",
    "search",
    "within_budget",
]
