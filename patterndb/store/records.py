"""What goes into the store and what comes out of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb.core.packing import take_rows

#: No mode takes larger patches: time and the 16 bits of a code's symbols end long before.
LARGEST_PATCH = 4096

#: No database holds more: a limit beyond is a slip, and SQLite's integers end somewhere.
MOST_PATTERNS = 1 << 40


@dataclass(frozen=True, slots=True)
class LearningOptions:
    """How patches are taken from a mesh.

    basic, side, convex: the largest patch of each mode in quads; 0 switches a mode off.
    prepare: collapse the polychords that only refine the mesh first.
    most_patterns: keep at most so many patterns of a mesh, those that most of its patches have;
    0 keeps all.
    """

    basic: int = 7
    side: int = 12
    convex: int = 40
    prepare: bool = True
    most_patterns: int = 0

    def __post_init__(self) -> None:
        for name in ("basic", "side", "convex"):
            limit = getattr(self, name)
            if not 0 <= limit <= LARGEST_PATCH:
                raise ValueError(
                    f"the limit of the {name} mode must lie in 0..{LARGEST_PATCH}, not {limit}; "
                    "0 switches the mode off"
                )
        if not 0 <= self.most_patterns <= MOST_PATTERNS:
            raise ValueError(
                f"the most patterns of a mesh must lie in 0..{MOST_PATTERNS}, not "
                f"{self.most_patterns}; 0 keeps all"
            )
        if not (self.basic or self.side or self.convex):
            raise ValueError("all modes are switched off; give at least one a limit above 0")

    @classmethod
    def none(cls) -> LearningOptions:
        """All modes off, which cannot be asked for: those of an imported table of patterns."""
        options = object.__new__(cls)
        for name, value in (("basic", 0), ("side", 0), ("convex", 0), ("prepare", False)):
            object.__setattr__(options, name, value)
        object.__setattr__(options, "most_patterns", 0)
        return options


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a mesh comes from; None where that is not known."""

    author: str | None = None
    source: str | None = None
    licence: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """What one mesh taught: counts, and one row a pattern met in it.

    quads_read, quads_used: quads in the file, and after preparation.
    basic, side, convex, distinct: patches of each mode, and over all of them.
    codes: packed canonical codes. sides: (k,) int32 number of sides of each.
    patches: (k, 2) int64, patches as the code is and as its mirror image.
    examples: per pattern the quads of one patch, packed (see schema.sql).
    origin: "learned", or "imported" where another program counted.
    left_out: further patterns, of which there are no rows here because the mesh was to teach no
    more; their patches count in the numbers above.
    """

    quads_read: int
    quads_used: int
    basic: int
    side: int
    convex: int
    distinct: int
    codes: Sequence[bytes]
    sides: NDArray[np.int32]
    patches: NDArray[np.int64]
    examples: Sequence[bytes]
    origin: str = "learned"
    left_out: int = 0


def take_patterns(learned: Learned, rows: NDArray[np.integer]) -> Learned:
    """What a mesh taught, of the patterns of these rows (k,) alone and in this order."""
    return replace(
        learned,
        codes=take_rows(learned.codes, rows),
        sides=learned.sides[rows],
        patches=learned.patches[rows],
        examples=take_rows(learned.examples, rows),
    )


@dataclass(frozen=True, slots=True)
class Mesh:
    """A mesh in the database; field by field as in schema.sql.

    patterns: how many of its patterns are kept. origin: "learned", or "imported": a table of
    patterns that another program made. left_out: patterns that it has beyond the most that were
    to be kept.
    """

    name: str
    sha256: str
    provenance: Provenance
    options: LearningOptions
    quads_read: int
    quads_used: int
    basic: int
    side: int
    convex: int
    distinct: int
    patterns: int
    origin: str = "learned"
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A pattern in a mesh: how many patches, and the quads of one of them (file faces).

    example: empty where the mesh is an imported table, which does not tell.
    """

    mesh: str
    patches: int
    mirrored_patches: int
    example: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Statistics:
    """Counts over the whole database.

    patterns: mirror images merged, those that were only used included.
    patterns_oriented: a chiral one counts twice.
    patterns_met: handednesses that patches were really met in.
    by_sides, by_irregular: patterns by number of sides and of irregular vertices.
    """

    patterns: int
    patterns_oriented: int
    patterns_met: int
    by_sides: dict[int, int]
    by_irregular: dict[int, int]
    signatures: int
    meshes: int
    patches: int
    content_hash: str
