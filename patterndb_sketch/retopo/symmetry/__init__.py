"""Symmetry: what is drawn on one side of a plane is on the other side, too.

:func:`half_of` cuts the ground; all tools work on ``Half.ground`` as on any other.
:func:`with_symmetry` takes a network there, with the cut as chains marked SYMMETRY, and
:func:`without_symmetry` back to the whole ground, with its image. :func:`parted` splits
strokes, drawn on the whole ground; :func:`mirrored` makes the whole mesh of that of a half.
:func:`proposed` finds the plane that a surface has by itself.
"""

from patterndb_sketch.retopo.symmetry.half import (
    Half,
    Parted,
    Plane,
    half_of,
    parted,
    refuse_beyond,
)
from patterndb_sketch.retopo.symmetry.images import MirroredMesh, mirrored, without_symmetry
from patterndb_sketch.retopo.symmetry.proposal import Proposal, proposed
from patterndb_sketch.retopo.symmetry.seam import with_symmetry

__all__ = [
    "Half",
    "MirroredMesh",
    "Parted",
    "Plane",
    "Proposal",
    "half_of",
    "mirrored",
    "parted",
    "proposed",
    "refuse_beyond",
    "with_symmetry",
    "without_symmetry",
]
