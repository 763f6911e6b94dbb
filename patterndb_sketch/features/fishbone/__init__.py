"""Fishbones: ribs across a curve, what pulls the curve along them, and the cut through them.

Read fishbone (the ribs as arrays), terms (what pulls), pins (which crease is meant), cut (the
cheapest way across, also of a closed curve, and the cheapest that keeps to one crease).
"""

from patterndb_sketch.features.fishbone.cut import (
    RibCut,
    cut,
    find_held_rows,
    find_moves,
    find_reach,
    track_crease,
)
from patterndb_sketch.features.fishbone.fishbone import Fishbone, RibLike, synchronise
from patterndb_sketch.features.fishbone.pins import (
    compare_with_pins,
    move_with_pins,
    settle_on_crease,
)
from patterndb_sketch.features.fishbone.terms import (
    Terms,
    curvature,
    find_terms,
    isophote,
    tau,
    weigh_creases,
)

__all__ = [
    "Fishbone",
    "RibCut",
    "RibLike",
    "Terms",
    "compare_with_pins",
    "curvature",
    "cut",
    "find_held_rows",
    "find_moves",
    "find_reach",
    "find_terms",
    "isophote",
    "move_with_pins",
    "settle_on_crease",
    "synchronise",
    "tau",
    "track_crease",
    "weigh_creases",
]
