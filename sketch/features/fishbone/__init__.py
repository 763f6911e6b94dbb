"""Fishbones: ribs across a curve, what pulls the curve along them, and the cut through them."""

from sketch.features.fishbone.constraints import held_rows
from sketch.features.fishbone.cut import Cut, cut
from sketch.features.fishbone.fishbone import Fishbone, RibLike
from sketch.features.fishbone.moves import moves
from sketch.features.fishbone.synchronise import synchronised
from sketch.features.fishbone.terms import Terms, curvature, isophote, tau, terms

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
