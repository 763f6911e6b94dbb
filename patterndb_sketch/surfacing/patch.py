"""What surfacing gives: patches, one per cycle, on vertices that neighbours share."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.verbs import PlotVerbs
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.sampling import Sampling


@dataclass(frozen=True, slots=True)
class LoopSurface:
    """The surface of one closed loop of n vertices.

    method:        the name of the one that answered, see
                   :data:`patterndb_sketch.surfacing.methods.METHODS`.
    note:          why that is not the one asked for, and what else a user should know; "" if
                   there is nothing to say.
    points:        (k, 3) float64, the vertices inside.
    faces:         per piece (f, 3) triangles or (f, 4) quads, int64, in the loop's sense. An
                   index below n is a position in the loop, n + i is row i of ``points``.
    candidates:    how many chords the search chose from, 0 unless chords were looked for.
    costly:        how many more were left out since they add too much area.
    unmatched:     how many ends of chords found no partner.
    chords:        (m, 2) int64, the chords that were chosen, as positions in the loop.
    n_subproblems: how many sub-cycles the search has scored.
    cost:          what the chosen cuts cost (Abbasinejad et al. 2013, Eq. 2), nan without any.
    area:          of all faces, in squared units of the points.
    self_intersections: pairs of faces that pass through each other.
    seconds:       what all of this took.
    corners:       positions in the loop of the corners of a grid that fills it, () without one.
    turned:        quads with a corner of more than 180 degrees.
    """

    method: str
    note: str
    points: Points = field(repr=False)
    faces: tuple[Int64Array, ...] = field(repr=False)
    candidates: int
    costly: int
    unmatched: int
    chords: NDArray[np.int64] = field(repr=False)
    n_subproblems: int
    cost: float
    area: float
    self_intersections: int
    seconds: float
    corners: tuple[int, ...] = ()
    turned: int = 0


@dataclass(frozen=True, slots=True)
class SurfacePatch:
    """The surface of one cycle of a network.

    cycle:   the cycle it fills.
    faces:   as :class:`LoopSurface` has them, of vertices of the whole :class:`Surfacing`.
    chords:  (m, 2) int64, the chosen chords, of the same vertices.
    surface: what else is known of it. None if no method could answer; ``note`` tells why, and
             there are no faces.
    note:    as in :class:`LoopSurface`.
    reused:  was it taken from an earlier stage of a growing sketch?
    """

    cycle: Cycle
    faces: tuple[Int64Array, ...] = field(repr=False)
    chords: NDArray[np.int64] = field(repr=False)
    surface: LoopSurface | None
    note: str
    reused: bool

    @property
    def method(self) -> str | None:
        """The name of the method that answered, None if none could."""
        return None if self.surface is None else self.surface.method


@dataclass(frozen=True, slots=True)
class Surfacing(PlotVerbs):
    """The surface of a network.

    network:   the network.
    sampling:  its shared vertices; they come first in ``points``.
    points:    (v, 3) float64, all vertices.
    patches:   one for each cycle, in the order of the cycles.
    crossings: (i, j, n) for patches i < j of which n pairs of faces pass through each other, the
               most first. No method excludes them, nor those within a patch.
    notes:     what else a user should know of the whole.
    """

    network: CurveNetwork = field(repr=False)
    sampling: Sampling = field(repr=False)
    points: Points = field(repr=False)
    patches: tuple[SurfacePatch, ...]
    crossings: tuple[tuple[int, int, int], ...]
    notes: tuple[str, ...] = ()

    @property
    def intersections(self) -> int:
        """Pairs of faces of two different patches that pass through each other."""
        return sum(pairs for _, _, pairs in self.crossings)

    @property
    def cycles(self) -> tuple[Cycle, ...]:
        """The cycles of the patches."""
        return tuple(patch.cycle for patch in self.patches)

    def list_surfaced_cycles(self) -> tuple[Cycle, ...]:
        """List the cycles whose patches have faces."""
        return tuple(patch.cycle for patch in self.patches if patch.surface is not None)

    @property
    def triangles(self) -> Int64Array:
        """(f, 3) all faces, quads cut in two along the diagonal from their first vertex."""
        pieces = [piece for patch in self.patches for piece in patch.faces]
        return as_triangles(pieces)

    @property
    def has_quads(self) -> bool:
        """Are faces of some patch quads?"""
        return any(piece.shape[1] == 4 for patch in self.patches for piece in patch.faces)

    def count_irregular(self) -> int:
        """Count the vertices inside the surface, in quads alone, that have not four of them."""
        pieces = [piece for patch in self.patches for piece in patch.faces]
        edges = [
            np.sort(np.stack([p, np.roll(p, -1, axis=1)], axis=2).reshape(-1, 2)) for p in pieces
        ]
        if not edges:
            return 0
        pairs, uses = np.unique(np.concatenate(edges), axis=0, return_counts=True)
        count = np.bincount(pairs.ravel(), minlength=len(self.points))
        outer = np.zeros(len(self.points), np.bool_)
        outer[pairs[uses != 2].ravel()] = True
        for piece in pieces:
            if piece.shape[1] != 4:
                outer[piece] = True
        return int(((count > 0) & (count != 4) & ~outer).sum())

    @property
    def area(self) -> float:
        """The summed area of the patches."""
        return sum(patch.surface.area for patch in self.patches if patch.surface)


def as_triangles(pieces: list[Int64Array] | tuple[Int64Array, ...]) -> Int64Array:
    """(f, 3) the faces of some pieces in order, quads cut in two from their first vertex."""
    parts = [np.zeros((0, 3), np.int64)]
    for piece in pieces:
        if piece.shape[1] == 4:
            piece = piece[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
        parts.append(piece)
    return np.concatenate(parts)
