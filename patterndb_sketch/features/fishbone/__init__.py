"""Fishbones: ribs across a curve, what pulls the curve along them, and the cut through them."""

from patterndb_sketch.features.fishbone.constraints import held_rows
from patterndb_sketch.features.fishbone.cut import Cut, cut
from patterndb_sketch.features.fishbone.fishbone import Fishbone, RibLike
from patterndb_sketch.features.fishbone.moves import moves
from patterndb_sketch.features.fishbone.synchronise import synchronised
from patterndb_sketch.features.fishbone.terms import Terms, curvature, isophote, tau, terms

__all__ = [
    "Cut",
    "Fishbone",
    "RibLike",
    "Terms",
    "curvature",
    "cut",
    "held_rows",
    "isophote",
    "moves",
    "synchronised",
    "tau",
    "terms",
]
