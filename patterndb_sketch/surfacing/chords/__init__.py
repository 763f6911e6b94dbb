"""The chord decomposition of one cycle: ends -> candidate chords -> search -> pieces.

After Abbasinejad et al. 2013, section 3.
"""

from patterndb_sketch.surfacing.chords.candidates import (
    TURNING_BOUND,
    Candidates,
    candidate_chords,
    endpoints,
    loop_turning,
)
from patterndb_sketch.surfacing.chords.decompose import (
    ALPHA,
    AREA_PRICE,
    MAX_SUBPROBLEMS,
    Decomposition,
    added_area,
    affordable,
    decompose,
    within_budget,
)
from patterndb_sketch.surfacing.chords.flatness import Flatness, flatness, is_planar
from patterndb_sketch.surfacing.chords.search import ChordCuts, search
from patterndb_sketch.surfacing.chords.subcycles import MOST_COUNTED, n_subproblems

__all__ = [
    "ALPHA",
    "AREA_PRICE",
    "MAX_SUBPROBLEMS",
    "MOST_COUNTED",
    "TURNING_BOUND",
    "Candidates",
    "ChordCuts",
    "Decomposition",
    "Flatness",
    "added_area",
    "affordable",
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
