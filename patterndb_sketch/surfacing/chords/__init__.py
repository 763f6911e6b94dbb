"""The chord decomposition of one cycle: ends -> candidate chords -> search -> pieces.

After Abbasinejad et al. 2013, section 3.
"""

from patterndb_sketch.surfacing.chords.addedarea import AREA_PRICE, added_area, affordable
from patterndb_sketch.surfacing.chords.candidates import Candidates, candidate_chords
from patterndb_sketch.surfacing.chords.decompose import (
    ALPHA,
    MAX_SUBPROBLEMS,
    Decomposition,
    decompose,
    within_budget,
)
from patterndb_sketch.surfacing.chords.endpoints import TURNING_BOUND, endpoints, loop_turning
from patterndb_sketch.surfacing.chords.flatness import Flatness, flatness, is_planar
from patterndb_sketch.surfacing.chords.search import Cuts, search
from patterndb_sketch.surfacing.chords.subcycles import MOST_COUNTED, n_subproblems

__all__ = [
    "ALPHA",
    "AREA_PRICE",
    "MAX_SUBPROBLEMS",
    "MOST_COUNTED",
    "TURNING_BOUND",
    "Candidates",
    "Cuts",
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
