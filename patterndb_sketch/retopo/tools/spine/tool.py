"""The spine tool: a patch about a stroke on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.ground import Ground, LocalMap, Stroke, Window, local_map
from patterndb_sketch.retopo.network import Edit, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.around import Edge, edges_around, mapped_around, sampled_line
from patterndb_sketch.retopo.tools.closing import closed_patch, onto_ground
from patterndb_sketch.retopo.tools.plane import PlanarPatch, fault
from patterndb_sketch.retopo.tools.spine.spine import spine_patch

#: Points that a spine's stroke must have: fewer have no direction in the middle.
FEWEST_POINTS = 3


@dataclass(frozen=True, slots=True, eq=False)
class SpinePatch:
    """A patch about a stroke before it is in the network: what a preview shows."""

    patch: PlanarPatch
    edges: tuple[Edge, ...]
    onto: LocalMap

    def curves(self, sizes: Sizes) -> list[Points]:
        """Its new curves on the ground, each (m, 3)."""
        return [
            onto_ground(self.onto, sampled_line(line, sizes.sampling))[0]
            for line in self.patch.curves
        ]


def spine(network: Network, ground: Ground, stroke: Stroke, sizes: Sizes) -> Edit:
    """The network with a four-sided patch whose midline is the stroke.

    The patch is ``sizes.spine`` wide to either side, less where a boundary is nearer. Raises
    RefusedError, and nothing changes, for a stroke that is closed, too short or partly off the
    surface, and for a patch that would cross curves or leave the surface.

    Source: sketch-based quad meshes paper, section 4, and section 5 on its parameterisation.
    """
    found = spine_preview(network, ground, stroke, sizes)
    return closed_patch(network, found.patch, found.edges, found.onto, sizes)


def spine_preview(network: Network, ground: Ground, stroke: Stroke, sizes: Sizes) -> SpinePatch:
    """The patch that :func:`spine` would make; raises as that does."""
    if stroke.closed:
        raise RefusedError("a spine has two ends; this stroke is closed")
    if len(stroke.points) < FEWEST_POINTS:
        raise RefusedError(f"a spine needs {FEWEST_POINTS} points or more; draw it longer")
    if stroke.missed:
        raise RefusedError(
            f"{stroke.missed} points of the stroke are off the surface; draw it on the surface"
        )
    width, snap = sizes.spine, sizes.snap_within(sizes.spine)
    length = float(arc_length(stroke.points)[-1])
    seeds = ground.nearest_facing(stroke.points, stroke.normals).feet
    window = Window.spine(width, length)
    onto = local_map(ground, seeds, np.gradient(stroke.points, axis=0), window)
    edges = edges_around(network)
    boundaries, strokes = mapped_around(network, edges, onto)
    patch = spine_patch(boundaries, length, width, snap)
    wrong = fault(patch, [*boundaries, *strokes])
    if wrong is not None:
        raise RefusedError(f"the spine's patch would {wrong}; erase that, or draw elsewhere")
    return SpinePatch(patch, tuple(edges), onto)
