"""Spine: one stroke makes a four-sided patch about itself, snapped to boundaries around it.

:mod:`.ends` snaps the patch's ends, where the stroke meets a boundary, :mod:`.flanks` its long
sides, where boundaries run along, and :mod:`.spine` puts the patch together, all in the plane
of the stroke's parameterisation (:mod:`patterndb_sketch.retopo.tools.plane`). :mod:`.tool` takes it from
the ground there and back into the network.
"""

from patterndb_sketch.retopo.tools.spine.spine import spine_patch
from patterndb_sketch.retopo.tools.spine.tool import SpinePatch, spine, spine_preview

__all__ = ["SpinePatch", "spine", "spine_patch", "spine_preview"]
