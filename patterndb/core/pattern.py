"""A pattern: a reduced disk of quads under its canonical code."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from patterndb._native.core.halfedge import next_border_edge
from patterndb.core import description as d
from patterndb.core.code import Code, canonical_code, decode, format_id, pattern_id
from patterndb.core.disk import Disk
from patterndb.core.display import render
from patterndb.core.halfedge import Int32Array
from patterndb.core.label import split_word
from patterndb.core.polychord import Polychords, polychords
from patterndb.errors import InvalidCodeError, InvalidMeshError
from patterndb.verbs import PlotVerbs


class PatternJson(TypedDict):
    """A pattern as JSON; see :class:`Pattern` for what the entries mean.

    boundary: its first vertices are those of the boundary, in order. quads: counter-clockwise.
    """

    pattern: str
    origin: str
    frequency: int
    n_sides: int
    corners: list[int]
    valences: list[int]
    n_quads: int
    n_chords: int
    n_loops: int
    self_crossing: bool
    rotations: int
    chiral: bool
    label: list[list[int]]
    boundary: int
    quads: list[list[int]]


@dataclass(frozen=True, slots=True, eq=False)
class Pattern(PlotVerbs):
    """A pattern and what follows from its code. Patterns are equal if their codes are.

    id:          63-bit number from the code, the same in every database.
    code:        (4q,) uint16, see :mod:`patterndb.core.code`.
    n_sides:     N, the number of corners; 0 where the boundary is one closed side.
    corners:     (N,) number of quads at each corner: 1 convex, 3 and more reflex.
    valences:    valences of the irregular interior vertices, ascending.
    n_chords, n_loops: open and closed polychords.
    self_crossing: does a polychord cross itself?
    rotations:   how many rotations map the pattern onto itself.
    chiral:      is the mirror image another pattern?
    label:       per side, the number of the polychord that crosses each edge.
    frequency:   distinct patches that reduce to it in the database it came from.
    origin:      "learned" from meshes, or how else the pattern came about.
    """

    id: int
    code: Code
    n_sides: int
    corners: tuple[int, ...]
    valences: tuple[int, ...]
    n_chords: int
    n_loops: int
    self_crossing: bool
    rotations: int
    chiral: bool
    label: tuple[tuple[int, ...], ...]
    frequency: int = 0
    origin: str = "learned"

    @classmethod
    def from_code(cls, code: Code, *, frequency: int = 0, origin: str = "learned") -> Pattern:
        """The pattern of a canonical code.

        Raises InvalidCodeError if the list is no code, not a disk's, or not canonical.
        """
        twin = decode(code)
        try:
            Disk.from_twin(twin)
        except InvalidMeshError as error:
            raise InvalidCodeError(f"the code is not a disk's: {error}") from error
        if not np.array_equal(canonical_code(twin)[0], code):
            raise InvalidCodeError("the code is not canonical; canonical_code(decode(code)) is")
        return cls.from_trusted_code(code, frequency=frequency, origin=origin)

    @classmethod
    def from_disk(cls, twin: Int32Array) -> Pattern:
        """The pattern under which a disk that is already reduced is known."""
        return cls.from_trusted_code(canonical_code(twin)[0])

    @classmethod
    def from_trusted_code(
        cls, code: Code, *, frequency: int = 0, origin: str = "learned"
    ) -> Pattern:
        """As :meth:`from_code`, for a code known to be canonical: nothing is checked."""
        row = d.describe([code])
        counts = row.counts[0].tolist()
        n_sides = counts[d.N_CORNERS]
        return cls(
            id=pattern_id(code, n_sides),
            code=code,
            n_sides=n_sides,
            corners=tuple(row.numbers(0, d.CORNERS).tolist()),
            valences=tuple(row.numbers(0, d.VALENCES).tolist()),
            n_chords=counts[d.N_CHORDS],
            n_loops=counts[d.N_LOOPS],
            self_crossing=bool(counts[d.SELF_CROSSING]),
            rotations=counts[d.ROTATIONS],
            chiral=bool(counts[d.CHIRAL]),
            label=tuple(tuple(s) for s in split_word(row.numbers(0, d.LABEL), n_sides)),
            frequency=frequency,
            origin=origin,
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pattern) and np.array_equal(self.code, other.code)

    def __hash__(self) -> int:
        return hash(self.id)

    def __repr__(self) -> str:
        sides = "1 side" if self.n_sides == 1 else f"{self.n_sides} sides"
        valences = ", ".join(map(str, self.valences))
        word = "valence" if self.n_irregular == 1 else "valences"
        irregular = f"{self.n_irregular} irregular ({word} {valences})" if valences else "regular"
        seen = f", seen {self.frequency:,}×" if self.frequency else ""
        return f"<Pattern {self.name}: {sides}, {irregular}{seen}>"

    def _repr_svg_(self) -> str:
        return render(self, ".svg").decode()

    def _repr_png_(self) -> bytes:
        return render(self, ".png")

    @property
    def name(self) -> str:
        """The id as 16 hexadecimal digits: how people and JSON name the pattern."""
        return format_id(self.id)

    @property
    def n_quads(self) -> int:
        return len(self.code) // 4

    @property
    def n_irregular(self) -> int:
        return len(self.valences)

    @property
    def convex(self) -> bool:
        """Has it no reflex corner?"""
        return all(k == 1 for k in self.corners)

    def twin(self) -> Int32Array:
        """(4q,) int32 half-edges; half-edge 0 leaves corner 0 along side 0."""
        # What decode gives for a valid code, which a pattern's is.
        return self.code.astype(np.int32) - 1

    def polychords(self) -> Polychords:
        """The polychords, the open ones numbered as in ``label``, loops after them."""
        twin = self.twin()
        traced = polychords(twin)
        name = np.full(traced.n, -1, np.int32)
        fresh = 0
        h = 0
        while True:
            c = traced.of_edge[h]
            if name[c] < 0:
                name[c] = fresh
                fresh += 1
            h = int(next_border_edge(twin, h))
            if h == 0:
                break
        name[traced.n_open :] = np.arange(traced.n_open, traced.n)
        crosses = np.empty_like(traced.crosses_itself)
        crosses[name] = traced.crosses_itself
        return Polychords(name[traced.of_edge], traced.n_open, traced.n_loops, crosses)

    def disk(self) -> Disk:
        """The quads, with side 0 from boundary vertex 0."""
        return Disk.from_twin(self.twin(), 0)

    def to_json(self) -> PatternJson:
        """The pattern as JSON takes it, its quads as in :meth:`disk`."""
        disk = self.disk()
        return {
            "pattern": self.name,
            "origin": self.origin,
            "frequency": self.frequency,
            "n_sides": self.n_sides,
            "corners": list(self.corners),
            "valences": list(self.valences),
            "n_quads": self.n_quads,
            "n_chords": self.n_chords,
            "n_loops": self.n_loops,
            "self_crossing": self.self_crossing,
            "rotations": self.rotations,
            "chiral": self.chiral,
            "label": [list(side) for side in self.label],
            "boundary": disk.perimeter,
            "quads": disk.quads.tolist(),
        }
