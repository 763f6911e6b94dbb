"""A fill: quads within a boundary, and the pattern they expand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.disk import Disk
from patterndb.core.display import render
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.verbs import PlotVerbs

if TYPE_CHECKING:
    from patterndb.geometry.surface import Triangles
    from query.placing import Placement, Surface
    from query.placing.region import Region
    from query.stroke import Stroke


class FillJson(TypedDict):
    """A fill as JSON; see :class:`Fill` for what the entries mean."""

    pattern: str
    origin: str
    frequency: int
    widths: list[int]
    rotation: int
    mirrored: bool
    n_irregular: int
    n_irregular_boundary: int
    strict: bool
    flow_distance: float | None
    n_vertices: int
    quads: list[list[int]]
    sides: list[list[int]]


@dataclass(frozen=True, slots=True, eq=False)
class Fill(PlotVerbs):
    """Quads that fill a boundary, and how they came from their pattern.

    quads:      (q, 4) int32, counter-clockwise. Boundary vertices are 0..P-1 in the order
                of the boundary asked for, 0 where its side 0 begins; interior ones follow.
    n_vertices: number of vertices.
    lengths:    edges of every side of the boundary asked for.
    pattern:    the pattern that is expanded.
    widths:     width of each of its polychords, open ones in label order, then loops.
    rotation, mirrored: side i of the boundary is the pattern's side rotation + i, or,
                mirrored, its side rotation - i read backwards. A fill that is not strict,
                and one closed side (N = 0), have no such sides: there edge i of the boundary
                is edge rotation + i, or rotation - i, of the expanded pattern.
    n_irregular: vertices, interior and boundary, whose number of quads is not what their
                place asks for: 4 inside, 2 on a side, 1 at a convex corner, 3 at a reflex one.
    origin:     "learned", "family", "constructed", or how else the pattern came about.
    n_irregular_boundary: those of n_irregular that lie on the boundary; 0 if strict.
    flow_distance: how far the strands lie from the strokes they were asked to follow, or None
                where there was no stroke. Where the strokes have points: the sum over strokes
                of the mean distance to the strand's midline times the stroke's length. Else
                in edges, by how many the strands' ends are off, over all strokes.
    """

    quads: Int32Array
    n_vertices: int
    lengths: tuple[int, ...]
    pattern: Pattern
    widths: tuple[int, ...]
    rotation: int
    mirrored: bool
    n_irregular: int
    origin: str
    n_irregular_boundary: int = 0
    flow_distance: float | None = None

    def __repr__(self) -> str:
        quads = "1 quad" if len(self.quads) == 1 else f"{len(self.quads):,} quads"
        irregular = f"{self.n_irregular} irregular" if self.n_irregular else "regular"
        sides = ", ".join(map(str, self.lengths))
        return (
            f"<Fill of sides {sides}: {quads}, {irregular}, {self.origin} pattern "
            f"{self.pattern.name}>"
        )

    def _repr_svg_(self) -> str:
        return render(self, ".svg").decode()

    def _repr_png_(self) -> bytes:
        return render(self, ".png")

    @property
    def strict(self) -> bool:
        """Are the pattern's corners exactly where the boundary's are, kind for kind?"""
        return self.n_irregular_boundary == 0

    @property
    def n_quads(self) -> int:
        return len(self.quads)

    @property
    def perimeter(self) -> int:
        """P, the number of boundary vertices and of boundary edges."""
        return sum(self.lengths)

    def disk(self) -> Disk:
        """The fill as a disk; its corners are those of the quads."""
        valence = np.bincount(self.quads.ravel(), minlength=self.n_vertices)
        corners = np.flatnonzero(valence[: self.perimeter] != 2).astype(np.int32)
        return Disk(self.quads, self.n_vertices, self.perimeter, corners)

    def sides(self) -> list[Int32Array]:
        """(L_i + 1,) int32 vertices along every side of the boundary, corner to corner."""
        return [np.array(side, dtype=np.int32) for side in self._list_sides()]

    def _list_sides(self) -> list[list[int]]:
        """The sides in Python's own numbers, of which an answer has thousands."""
        ends = [0, *accumulate(self.lengths)]
        sides = [list(range(first, last + 1)) for first, last in pairwise(ends)]
        sides[-1][-1] = 0
        return sides

    def place(
        self,
        points: ArrayLike,
        surface: Triangles | Surface | Region | None = None,
        strokes: Sequence[Stroke] | None = None,
        *,
        tolerance: int = 1,
    ) -> Placement:
        """Where the vertices lie, the boundary's being given; see :func:`query.placing.place`."""
        # Imported here because placing needs scipy, which a list of fills does not. Placing knows
        # nothing of fills but their quads and sides.
        from query.placing.placement import place

        return place(self, points, surface, strokes, tolerance=tolerance)

    def to_json(self) -> FillJson:
        """The fill as JSON takes it; the pattern goes by its name."""
        return {
            "pattern": self.pattern.name,
            "origin": self.origin,
            "frequency": self.pattern.frequency,
            "widths": list(self.widths),
            "rotation": self.rotation,
            "mirrored": self.mirrored,
            "n_irregular": self.n_irregular,
            "n_irregular_boundary": self.n_irregular_boundary,
            "strict": self.strict,
            "flow_distance": self.flow_distance,
            "n_vertices": self.n_vertices,
            "quads": self.quads.tolist(),
            "sides": self._list_sides(),
        }
