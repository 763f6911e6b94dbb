"""Judge the mesh of a draft: what it is like, what is wrong with it and where, and what is refused.

Of a draft of one half it is the mesh with its image that counts: no surface is symmetric to the
last hair, and what lies near one side need not lie near the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import FilledNetwork, weld_fills
from patterndb_sketch.retopo.filling.mesh import RetopoMesh
from patterndb_sketch.retopo.filling.report import Report, cut_quads, hausdorff, report_mesh
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.symmetry import Half, mirror_mesh
from patterndb_sketch.retopo.wording import count_places, format_place

#: A draft further off than this part of the diagonal, or with more than this part of its quads
#: flipped, has lost a part of the surface: it is refused.
FAR_OFF, MOST_FLIPPED = 0.05, 0.02

#: A draft nearer to the surface than this part of its diagonal is near enough.
MOST_OFF = 0.02


@dataclass(frozen=True, slots=True)
class DraftJudge:
    """Says what the mesh of a draft on a ground is like. half: that the ground is, if it is one."""

    ground: Ground
    half: Half | None

    @property
    def whole(self) -> Ground:
        """What the mesh is measured against."""
        return self.ground if self.half is None else self.half.whole

    def weld(self, found: FilledNetwork) -> RetopoMesh:
        """The mesh, with its image."""
        mesh = weld_fills(found)
        return mesh if self.half is None else mirror_mesh(mesh, found.network, self.half.plane).mesh

    def report(self, found: FilledNetwork) -> Report:
        """What it is like; patches and flipped quads of the image count, too."""
        made = report_mesh(found, self.whole, self.weld(found))
        if self.half is None:
            return made
        twice = {corners: 2 * n for corners, n in made.patches.items()}
        return replace(made, patches=twice, unfilled=2 * made.unfilled, flipped=2 * made.flipped)

    def is_lopsided(self, found: FilledNetwork, made: Report) -> bool:
        """Is a mesh that is near to its half too far from the whole? Then the surface is not as
        symmetric as that, and no other draft of the half is nearer."""
        if self.half is None or max(made.to_ground, made.from_ground) <= MOST_OFF:
            return False
        mesh = weld_fills(found)
        own = hausdorff(mesh.vertices, mesh.quads, self.ground)
        return max(own) * self.ground.diagonal <= MOST_OFF * self.whole.diagonal

    def list_flaws(self, found: FilledNetwork, made: Report) -> tuple[str, ...]:
        """What of a mesh is flipped or far off, in words, with the first place."""
        said: list[str] = []
        if made.flipped:
            at = np.concatenate([one.find_flipped() for one in found.placed.values()])
            if self.half is not None:
                at = np.concatenate([at, self.half.plane.mirror(at)])
            said.append(count_places("a flipped quad", "flipped quads", at))
        off = max(made.to_ground, made.from_ground)
        if off > MOST_OFF:
            said.append(f"{100 * off:.2g} % off at {format_place(self.find_furthest(found))}")
        return tuple(said)

    def find_furthest(self, found: FilledNetwork) -> Points:
        """(3,) the vertex of the ground furthest from the quads, or of the quads from the
        ground."""
        mesh, ground = self.weld(found), self.whole
        surface = Surface.from_arrays(mesh.vertices, cut_quads(mesh.vertices, mesh.quads))
        missed = np.linalg.norm(surface.nearest(ground.vertices).points - ground.vertices, axis=1)
        gone = np.linalg.norm(ground.nearest(mesh.vertices).points - mesh.vertices, axis=1)
        if missed.max() >= gone.max():
            return ground.vertices[missed.argmax()]
        return mesh.vertices[gone.argmax()]

    def refuse_bad(self, made: Report, found: FilledNetwork) -> None:
        """RefusedError for a mesh that is not whole, or is another shape than the surface."""
        off = max(made.to_ground, made.from_ground)
        worst = format_place(self.find_furthest(found)) if made.quads else "everywhere"
        if made.unfilled or made.tangled:
            raise RefusedError(
                f"no draft: {made.unfilled} regions have no quads and {made.tangled} edges are "
                f"tangled; the worst is at {worst}: the surface is too thin or too fine for its "
                "edges there; take a smaller edge, or draw by hand"
            )
        if off > FAR_OFF or made.flipped > MOST_FLIPPED * made.quads:
            raise RefusedError(
                f"no draft: quads would be {100 * off:.2g} % of the diagonal off the surface, and "
                f"{made.flipped} of {made.quads} flipped; the worst is at {worst}: take a smaller "
                "edge, or draw by hand"
            )
