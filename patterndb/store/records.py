"""Records of the store: what goes in, what comes out, and the rows of its tables.

Columns have names here and are never counted. A row of a table is a :class:`typing.NamedTuple` with
the names of schema.sql; a row of ``mesh`` is a :class:`Mesh`, whose fields name their columns where
these are called otherwise. The statements that read and write whole rows are made of these types.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from typing import Any, NamedTuple, cast, get_type_hints

import numpy as np
from numpy.typing import NDArray

from patterndb.core.packing import take_rows
from patterndb.errors import DatabaseError

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

    basic: int = field(default=7, metadata={"column": "basic_limit"})
    side: int = field(default=12, metadata={"column": "side_limit"})
    convex: int = field(default=40, metadata={"column": "convex_limit"})
    prepare: bool = field(default=True, metadata={"column": "prepared"})
    most_patterns: int = field(default=0, metadata={"column": "pattern_limit"})

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
    """A mesh in the database: a row of the table ``mesh``.

    patterns: the number of its patterns that are kept, counted when it is read. origin: "learned",
    or "imported" for a table of patterns that another program made. left_out: patterns beyond the
    most that were to be kept.
    """

    name: str
    sha256: str
    provenance: Provenance
    options: LearningOptions
    quads_read: int
    quads_used: int
    basic: int = field(metadata={"column": "basic_patches"})
    side: int = field(metadata={"column": "side_patches"})
    convex: int = field(metadata={"column": "convex_patches"})
    distinct: int = field(metadata={"column": "distinct_patches"})
    patterns: int = field(metadata={"is_counted": True})
    origin: str = "learned"
    left_out: int = field(default=0, metadata={"column": "patterns_left_out"})

    @classmethod
    def from_columns(cls, row: Mapping[str, Any]) -> Mesh:
        """Make the mesh of a row's values by column, ``patterns`` among them.

        Raises DatabaseError for a hash that is not bytes, TypeError or ValueError for options that
        cannot be.
        """
        return _read_record(cls, {**row, "sha256": check_hash(row["sha256"]).hex()})

    def to_columns(self) -> dict[str, Any]:
        """Return the values of its row by column, without id and occurrence_sum."""
        return _list_values(self) | {"sha256": bytes.fromhex(self.sha256)}


def check_hash(value: object) -> bytes:
    """Return the SHA-256 of a mesh's row. Raises DatabaseError unless it is bytes: of a number,
    bytes() would make as many zeros."""
    if not isinstance(value, bytes):
        raise DatabaseError(
            f"the SHA-256 of a mesh is {repr(value)[:40]}, not bytes: the file is damaged; "
            "'patterndb verify' reports what is wrong"
        )
    return value


def _list_values(record: Any) -> dict[str, Any]:
    """Values of a record by column; records within it have columns of the same table."""
    values: dict[str, Any] = {}
    for one in fields(record):
        value = getattr(record, one.name)
        if is_dataclass(value):
            values |= _list_values(value)
        elif not one.metadata.get("is_counted"):
            values[one.metadata.get("column", one.name)] = value
    return values


def _read_record(kind: type[Any], row: Mapping[str, Any]) -> Any:
    """Make a record of values by column: the inverse of :func:`_list_values`."""
    values: dict[str, Any] = {}
    for name, (column, inner) in _columns_of(kind).items():
        if is_dataclass(inner):
            values[name] = _read_record(cast("type[Any]", inner), row)
        elif column in row:  # the shipped database may lack a new column
            values[name] = bool(row[column]) if inner is bool else row[column]
    if kind is LearningOptions and not any(values[mode] for mode in ("basic", "side", "convex")):
        return LearningOptions.none()
    return kind(**values)


@cache
def _columns_of(kind: type[Any]) -> dict[str, tuple[str, Any]]:
    """Column and type of every field of a record, by its name."""
    kinds = get_type_hints(kind)
    return {
        one.name: (one.metadata.get("column", one.name), kinds[one.name]) for one in fields(kind)
    }


class PatternRow(NamedTuple):
    """A row of the table ``pattern``."""

    id: int
    code: bytes
    n_sides: int
    n_reflex: int
    n_quads: int
    n_irregular: int
    chiral: int
    signature: bytes


class OccurrenceRow(NamedTuple):
    """A row of the table ``occurrence``."""

    pattern_id: int
    mesh_id: int
    patches: int
    mirrored_patches: int
    example: bytes


class UsageRow(NamedTuple):
    """A row of the table ``usage``."""

    pattern_id: int
    uses: int
    origin: str


SELECT_PATTERNS = f"SELECT {', '.join(PatternRow._fields)} FROM pattern"  # noqa: S608
SELECT_OCCURRENCES = f"SELECT {', '.join(OccurrenceRow._fields)} FROM occurrence"  # noqa: S608
SELECT_USAGE = f"SELECT {', '.join(UsageRow._fields)} FROM usage"  # noqa: S608


def make_insert(table: str, columns: Sequence[str]) -> str:
    """Return the statement that inserts a row with these columns, in this order."""
    marks = ", ".join("?" for _ in columns)
    return f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({marks})"  # noqa: S608


INSERT_PATTERN = make_insert("pattern", PatternRow._fields)
INSERT_OCCURRENCE = make_insert("occurrence", OccurrenceRow._fields)
INSERT_USAGE = make_insert("usage", UsageRow._fields)


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
    signatures: different ones; it and patterns_met are None where they were not counted.
    """

    patterns: int
    patterns_oriented: int
    patterns_met: int | None
    by_sides: dict[int, int]
    by_irregular: dict[int, int]
    signatures: int | None
    meshes: int
    patches: int
    content_hash: str
