"""Symmetry: what is drawn on one side of a plane is on the other side, too.

:func:`half_of` cuts the ground; all tools work on ``Half.ground`` as on any other.
:func:`with_symmetry` takes a network there, with the cut as chains marked SYMMETRY, and
:func:`without_symmetry` back to the whole ground, with its image. :func:`insert_on_half` is for
strokes, drawn on the whole ground; :func:`mirrored` makes the whole mesh of that of a half.
:func:`proposed` finds the plane that a surface has by itself.
"""

from patterndb_sketch.retopo.symmetry.export import MirroredMesh, mirrored
from patterndb_sketch.retopo.symmetry.half import Half, half_of
from patterndb_sketch.retopo.symmetry.images import without_symmetry
from patterndb_sketch.retopo.symmetry.plane import Plane
from patterndb_sketch.retopo.symmetry.proposal import Proposal, proposed
from patterndb_sketch.retopo.symmetry.seam import with_symmetry
from patterndb_sketch.retopo.symmetry.strokes import Parted, insert_on_half, parted, refuse_beyond

__all__ = [
    "Half",
    "MirroredMesh",
    "Parted",
    "Plane",
    "Proposal",
    "half_of",
    "insert_on_half",
    "mirrored",
    "parted",
    "proposed",
    "refuse_beyond",
    "with_symmetry",
    "without_symmetry",
]
