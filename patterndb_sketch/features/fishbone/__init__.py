"""Fishbones: ribs across a curve, what pulls the curve along them, and the cut through them.

Read fishbone (the ribs as arrays), terms (what pulls), cut (the cheapest way across).
"""

from patterndb_sketch.features.fishbone.cut import RibCut, cut, find_held_rows, find_moves
from patterndb_sketch.features.fishbone.fishbone import Fishbone, RibLike, synchronise
from patterndb_sketch.features.fishbone.terms import Terms, curvature, find_terms, isophote, tau

__all__ = [
    "Fishbone",
    "RibCut",
    "RibLike",
    "Terms",
    "curvature",
    "cut",
    "find_held_rows",
    "find_moves",
    "find_terms",
    "isophote",
    "synchronise",
    "tau",
]
