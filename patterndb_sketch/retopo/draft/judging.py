"""Judge a draft: its mesh, what is wrong with that and where, and which draft is better.

Of a draft of one half it is the mesh with its image that counts: no surface is symmetric to the
last hair, and what lies near one side need not lie near the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import scaled_jacobian
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    weld_patches,
)
from patterndb_sketch.retopo.filling.mesh import RetopoMesh
from patterndb_sketch.retopo.filling.report import Report, cut_quads, hausdorff, report_mesh
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.symmetry import Half, mirror_mesh
from patterndb_sketch.retopo.wording import count_places, format_place

#: So many numbers of a rank say what is wrong.
WRONG = 4


@dataclass(frozen=True, slots=True)
class DraftJudge:
    """Judges the mesh of a draft on a surface. half: that the surface is, if it is one. most_off:
    how far off it may be, in diagonals."""

    surface: Surface
    half: Half | None
    most_off: float = SETTINGS.most_off

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
        worst = np.argsort(shape, kind="stable")[: int((shape < SETTINGS.poor_quad).sum())]
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


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A draft, filled and judged.

    found: its network, with counts and fills, and where these lie. report: of its mesh. flaws: what
    is wrong with that, in words, with places. rank: the less, the better. poor: (n, 3) the middles
    of poor quads, the worst first. notes: what the user should know of how it came, in words.
    creased: does it keep all creases?
    """

    found: FilledNetwork
    report: Report
    flaws: tuple[str, ...]
    rank: tuple[float, ...]
    poor: Points
    notes: tuple[str, ...] = ()
    creased: bool = True

    @classmethod
    def of(cls, found: FilledNetwork, judge: DraftJudge, notes: tuple[str, ...] = ()) -> Draft:
        """Judge quads that are fitted."""
        made = judge.report(found)
        off = max(made.to_surface, made.from_surface)
        wrong = (made.unfilled, made.tangled, made.flipped, max(off - judge.most_off, 0.0))
        rank = (*wrong, sum(made.irregular.values()), off)
        flaws = judge.list_flaws(found, made)
        return cls(found, made, flaws, rank, judge.find_poor(found), notes)

    @property
    def network(self) -> Network:
        """With counts and fills."""
        return self.found.network

    @property
    def sound(self) -> bool:
        """Is nothing wrong with it?"""
        return not any(self.rank[:WRONG])

    @property
    def nearly_sound(self) -> bool:
        """Is little wrong for its creases: few quads are flipped, or it is a little too far off?"""
        unfilled, tangled, flipped, off = self.rank[:WRONG]
        chains = self.network.chains.values()
        along = sum(chain.count for chain in chains if not (chain.auto or chain.marked))
        # Of a half, flipped quads of the image count, too.
        along *= self.report.quads / max(sum(len(p.quads) for p in self.found.placed.values()), 1)
        if not along or unfilled or tangled:
            return False
        return flipped <= SETTINGS.few_flipped * along and off <= SETTINGS.little_off

    @property
    def price(self) -> float:
        """The less, the better shaped it is: irregular vertices and poor quads in a thousand."""
        odd = sum(self.report.irregular.values()) / SETTINGS.irregular_per_thousand
        return 1000.0 * (odd + len(self.poor) / SETTINGS.poor_per_thousand) / self.report.quads
