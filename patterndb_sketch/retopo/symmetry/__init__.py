"""Symmetry: what is drawn on one side of a plane is on the other side, too.

:func:`cut_half` cuts the ground; all tools work on ``Half.ground`` as on any other.
:func:`begin_symmetry` takes a network there, with the cut as chains marked SYMMETRY, and
:func:`end_symmetry` back to the whole ground, with its image. :func:`split_stroke` splits
strokes, drawn on the whole ground; :func:`mirror_mesh` makes the whole mesh of that of a half.
:func:`propose_plane` finds the plane that a surface has by itself.
"""

from patterndb_sketch.retopo.symmetry.half import (
    Half,
    Plane,
    SplitStroke,
    cut_half,
    refuse_beyond,
    split_stroke,
)
from patterndb_sketch.retopo.symmetry.images import MirroredMesh, end_symmetry, mirror_mesh
from patterndb_sketch.retopo.symmetry.proposal import Proposal, propose_plane
from patterndb_sketch.retopo.symmetry.seam import begin_symmetry

__all__ = [
    "Half",
    "MirroredMesh",
    "SplitStroke",
    "Plane",
    "Proposal",
    "cut_half",
    "mirror_mesh",
    "split_stroke",
    "propose_plane",
    "refuse_beyond",
    "begin_symmetry",
    "end_symmetry",
]
