"""Keep which fill a patch has: its choice, the lines that it follows, vertices moved by hand."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from query.fill import Fill

#: Who took a fill: the program, the first of its list; or the user.
By = Literal["program", "user"]


@dataclass(frozen=True, slots=True)
class Choice:
    """A fill with everything that tells it apart: it needs no database to be placed again.

    lengths:  edges of every side of the patch; it is good for these alone.
    quads:    (q, 4) int32 little-endian, as bytes: boundary vertices are 0..P - 1 from the
              patch's first corner on, interior ones follow.
    n_vertices: of the fill.
    code:     the pattern's, as bytes. widths, rotation, mirrored: see :class:`query.fill.Fill`.
    origin:   where the pattern came from. n_irregular: see there.
    by:       who took it. A user's is kept as long as a fill of its pattern fits.
    """

    lengths: tuple[int, ...]
    quads: bytes = field(repr=False)
    n_vertices: int
    code: bytes = field(repr=False)
    widths: tuple[int, ...]
    rotation: int
    mirrored: bool
    origin: str
    n_irregular: int
    by: By = "program"

    @classmethod
    def of(cls, fill: Fill, by: By = "program") -> Choice:
        """Of a fill from the query engine."""
        return cls(
            lengths=fill.lengths,
            quads=np.ascontiguousarray(fill.quads, "<i4").tobytes(),
            n_vertices=fill.n_vertices,
            code=pattern_code(fill),
            widths=fill.widths,
            rotation=fill.rotation,
            mirrored=fill.mirrored,
            origin=fill.origin,
            n_irregular=fill.n_irregular,
            by=by,
        )

    @property
    def faces(self) -> Int32Array:
        """(q, 4) int32."""
        return np.frombuffer(self.quads, "<i4").reshape(-1, 4).astype(np.int32)

    @property
    def perimeter(self) -> int:
        """P: vertices, and edges, of the boundary."""
        return sum(self.lengths)


def pattern_code(fill: Fill) -> bytes:
    """The code of a fill's pattern, which tells patterns apart."""
    return np.ascontiguousarray(fill.pattern.code).tobytes()


@dataclass(frozen=True, slots=True)
class Flow:
    """A line along which the user wants edges to run: points (n, 3) on the surface, as bytes."""

    line: bytes = field(repr=False)

    @classmethod
    def of(cls, points: ArrayLike) -> Flow:
        return cls(np.ascontiguousarray(points, "<f8").tobytes())

    @property
    def points(self) -> Points:
        """(n, 3) float64."""
        return np.frombuffer(self.line, "<f8").reshape(-1, 3).astype(np.float64)


@dataclass(frozen=True, slots=True)
class Filling:
    """What a network keeps of a patch: its fill, the lines it follows, and vertices moved by hand.

    choice: None until one is made. flows: lines for edges to follow.
    moved:  (k,) numbers of vertices and (k, 3) where they are, as bytes, for ``choice`` alone.
    """

    choice: Choice | None = None
    flows: tuple[Flow, ...] = ()
    moved: tuple[bytes, bytes] = field(default=(b"", b""), repr=False)

    def with_choice(self, choice: Choice | None) -> Filling:
        """With another fill, whose vertices lie where they fall."""
        return replace(self, choice=choice, moved=(b"", b""))

    def with_moved(self, which: ArrayLike, points: ArrayLike) -> Filling:
        """With (k,) vertices held at (k, 3) points."""
        numbers = np.ascontiguousarray(which, "<i4").tobytes()
        return replace(self, moved=(numbers, np.ascontiguousarray(points, "<f8").tobytes()))

    @property
    def moved_vertices(self) -> tuple[Int32Array, Points]:
        """(k,) int32 numbers and (k, 3) float64 points."""
        which, at = self.moved
        return (
            np.frombuffer(which, "<i4").astype(np.int32),
            np.frombuffer(at, "<f8").reshape(-1, 3).astype(np.float64),
        )
