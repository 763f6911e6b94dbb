"""The chord decomposition of one cycle: ends -> candidate chords -> search -> pieces.

After Abbasinejad et al. 2013, section 3.
"""

from patterndb_sketch.surfacing.chords.candidates import (
    TURNING_BOUND,
    Candidates,
    find_candidates,
    find_endpoints,
)
from patterndb_sketch.surfacing.chords.decompose import (
    ALPHA,
    AREA_PRICE,
    MAX_SUBPROBLEMS,
    Decomposition,
    decompose,
    find_affordable,
    keep_within_budget,
    measure_added_area,
)
from patterndb_sketch.surfacing.chords.flatness import Flatness, is_planar, measure_flatness
from patterndb_sketch.surfacing.chords.search import ChordCuts, search_cuts
from patterndb_sketch.surfacing.chords.subcycles import MOST_COUNTED, count_subproblems

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
    "count_subproblems",
    "decompose",
    "find_affordable",
    "find_candidates",
    "find_endpoints",
    "is_planar",
    "keep_within_budget",
    "measure_added_area",
    "measure_flatness",
    "search_cuts",
]
