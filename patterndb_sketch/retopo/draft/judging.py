"""Judge the mesh of a draft: what it is like, what is wrong with it and where, and what is refused.

Of a draft of one half it is the mesh with its image that counts: no surface is symmetric to the
last hair, and what lies near one side need not lie near the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import scaled_jacobian
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.filling import FilledNetwork, weld_patches
from patterndb_sketch.retopo.filling.mesh import RetopoMesh
from patterndb_sketch.retopo.filling.report import Report, cut_quads, hausdorff, report_mesh
from patterndb_sketch.retopo.symmetry import Half, mirror_mesh
from patterndb_sketch.retopo.wording import count_places, format_place

#: A quad with a scaled Jacobian below this is poor.
POOR_QUAD = 0.3

#: A draft nearer to the surface than this part of its diagonal is near enough.
MOST_OFF = 0.02


@dataclass(frozen=True, slots=True)
class DraftJudge:
    """Judges the mesh of a draft on a surface. half: that the surface is, if it is one. most_off:
    how far off it may be, in diagonals."""

    surface: Surface
    half: Half | None
    most_off: float = MOST_OFF

    @property
    def whole(self) -> Surface:
        """What the mesh is measured against."""
        return self.surface if self.half is None else self.half.whole

    def weld(self, found: FilledNetwork) -> RetopoMesh:
        """The mesh, with its image."""
        mesh = weld_patches(found)
        return mesh if self.half is None else mirror_mesh(mesh, found.network, self.half.plane).mesh

    def report(self, found: FilledNetwork) -> Report:
        """What it is like; patches and flipped quads of the image count, too."""
        made = report_mesh(found, self.whole, self.weld(found))
        if self.half is None:
            return made
        twice = {corners: 2 * n for corners, n in made.patches.items()}
        return replace(made, patches=twice, unfilled=2 * made.unfilled, flipped=2 * made.flipped)

    def find_poor(self, found: FilledNetwork) -> Points:
        """(n, 3) the middles of poor quads, the worst first."""
        mesh = self.weld(found)
        shape = scaled_jacobian(mesh.quads, mesh.vertices)
        worst = np.argsort(shape, kind="stable")[: int((shape < POOR_QUAD).sum())]
        return mesh.vertices[mesh.quads[worst]].mean(axis=1)

    def is_lopsided(self, found: FilledNetwork, made: Report) -> bool:
        """Is a mesh that is near to its half too far from the whole? Then the surface is not as
        symmetric as that, and no other draft of the half is nearer."""
        if self.half is None or max(made.to_surface, made.from_surface) <= self.most_off:
            return False
        mesh = weld_patches(found)
        own = hausdorff(mesh.vertices, mesh.quads, self.surface)
        return max(own) * self.surface.diagonal <= self.most_off * self.whole.diagonal

    def list_flaws(self, found: FilledNetwork, made: Report) -> tuple[str, ...]:
        """What of a mesh is open, flipped or far off, in words, with the first place."""
        said: list[str] = []
        if made.unfilled:
            at = [
                found.network.chains[patch.loop[0] >> 1].points.mean(axis=0)
                for number, patch in sorted(found.network.patches.items())
                if number not in found.placed
            ]
            said.append(count_places("no quads in a patch", "patches without quads", np.array(at)))
        if made.tangled:
            mesh = self.weld(found)
            sides = np.stack(mesh.list_sides(), axis=1)
            _, first, uses = np.unique(sides, axis=0, return_index=True, return_counts=True)
            at = mesh.vertices[sides[first[uses > 1]]].mean(axis=1)
            if len(at):
                said.append(count_places("a tangled edge", "tangled edges", at))
        if made.flipped:
            at = np.concatenate([one.find_flipped() for one in found.placed.values()])
            if self.half is not None:
                at = np.concatenate([at, self.half.plane.mirror(at)])
            said.append(count_places("a flipped quad", "flipped quads", at))
        off = max(made.to_surface, made.from_surface)
        if made.quads and off > self.most_off:
            said.append(f"{100 * off:.2g} % off at {format_place(self.find_furthest(found))}")
        return tuple(said)

    def find_furthest(self, found: FilledNetwork) -> Points:
        """(3,) the vertex of the surface furthest from the quads, or of the quads from the
        surface."""
        mesh, surface = self.weld(found), self.whole
        cover = Surface.from_arrays(mesh.vertices, cut_quads(mesh.vertices, mesh.quads))
        missed = np.linalg.norm(cover.nearest(surface.vertices).points - surface.vertices, axis=1)
        gone = np.linalg.norm(surface.nearest(mesh.vertices).points - mesh.vertices, axis=1)
        if missed.max() >= gone.max():
            return surface.vertices[missed.argmax()]
        return mesh.vertices[gone.argmax()]
