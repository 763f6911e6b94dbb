"""Symmetry: what is drawn on one side of a plane is on the other side, too.

Read :mod:`.half` (planes, the surface cut by one, strokes split at it), :mod:`.seam` (a network cut
there, with the cut as chains marked SYMMETRY), :mod:`.images` (back to the whole: of a network, a
mesh and painted density) and :mod:`.proposal` (the plane that a surface has by itself).
"""

from patterndb_sketch.retopo.symmetry.half import (
    Half,
    Plane,
    cut_half,
    refuse_beyond,
    split_stroke,
)
from patterndb_sketch.retopo.symmetry.images import (
    MirroredMesh,
    end_symmetry,
    mirror_density,
    mirror_mesh,
    mirror_paint,
)
from patterndb_sketch.retopo.symmetry.proposal import (
    Proposal,
    format_share,
    propose_given,
    propose_plane,
)
from patterndb_sketch.retopo.symmetry.seam import begin_symmetry

__all__ = [
    "Half",
    "MirroredMesh",
    "Plane",
    "Proposal",
    "begin_symmetry",
    "cut_half",
    "end_symmetry",
    "format_share",
    "mirror_density",
    "mirror_mesh",
    "mirror_paint",
    "propose_given",
    "propose_plane",
    "refuse_beyond",
    "split_stroke",
]
