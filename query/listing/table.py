"""Tables: what a boundary can be matched with, one row for every pattern and set of marks.

A strict table holds the patterns of one class, whose corners fall on the boundary's corners.
A relaxed one holds marked patterns (:mod:`query.relaxed.corner_placement`), whose marks do. To a
query both are the same: labels of strands, and for each row and orientation a count of irregular
vertices.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from query.boundary import QUADS_AT, Boundary
from query.cancellation import NEVER, CancelFlag
from query.expand import expand_marked, expand_pattern
from query.fill import Fill
from query.orientation import list_chord_symmetries, list_corners_seen, list_orientations
from query.recognition import is_mesh
from query.relaxed.bestmarked import MOST_SIDES, find_best_marked, load_family_index
from query.relaxed.corner_placement import (
    MOST_SLOTS,
    MarkedClass,
    load_marked_family,
    mark_patterns,
)
from query.relaxed.family import PatternTable
from query.solving.problem import Labels
from query.solving.systems import SignatureRows

#: Ids (k,) int64 -> the patches (k,) int64 in which these patterns were seen.
Frequencies = Callable[[NDArray[np.int64]], NDArray[np.int64]]

#: Quads that a place without a corner asks for: where a closed side's vertex 0 falls.
FLAT = 2


@dataclass(frozen=True, slots=True, eq=False)
class TableEntries:
    """Rows of a table as candidates for one boundary, in no order.

    A row whose orientations cost unlike numbers of irregular vertices comes once for each.

    row:       (e,) int64 row of the table.
    n_irregular: (e,) int32 irregular vertices in all, the same in all allowed orientations.
    n_irregular_boundary: (e,) int32 those of them on the boundary.
    packed:    (e, ceil(o / 8)) uint8, the allowed orientations as np.packbits packs them,
               without those that the pattern's own symmetries make equal: a query keeps some
               million entries for each order, and looks at few of them.
    n_orientations: o.
    """

    row: NDArray[np.int64]
    n_irregular: Int32Array
    n_irregular_boundary: Int32Array
    packed: NDArray[np.uint8]
    n_orientations: int

    def __len__(self) -> int:
        return len(self.row)

    def take(self, at: NDArray[np.int64] | NDArray[np.bool_] | slice) -> TableEntries:
        """Those of the entries, in that order."""
        return TableEntries(
            self.row[at],
            self.n_irregular[at],
            self.n_irregular_boundary[at],
            self.packed[at],
            self.n_orientations,
        )


def _unpack(packed: NDArray[np.uint8], n: int) -> NDArray[np.bool_]:
    return np.unpackbits(packed, axis=1, count=n).view(np.bool_)


class Table(Protocol):
    """Rows that a boundary can be matched with.

    labels, signatures: of the rows, see :class:`query.solving.widths.WidthTable`.
    ids, frequency, uses: (r,) int64 of the rows' patterns; frequency is 0 for those that no
               mesh has shown.
    n_meshes:  (r,) int32 meshes in which the rows' patterns were seen.
    n_symmetries: (r,) int32 rotations and mirror images that map them onto themselves.
    n_quads, n_loops, n_corners, min_valence, max_valence: (r,) int32 of the rows' patterns.
    listings:  what queries keep with the table.
    """

    labels: Labels
    ids: NDArray[np.int64]
    frequency: NDArray[np.int64]
    uses: NDArray[np.int64]
    n_meshes: Int32Array
    n_symmetries: Int32Array
    n_quads: Int32Array
    n_loops: Int32Array
    n_corners: Int32Array
    min_valence: Int32Array
    max_valence: Int32Array
    listings: dict[Any, Any]

    @property
    def signatures(self) -> SignatureRows: ...

    def entries(self, boundary: Boundary, passing: NDArray[np.bool_]) -> TableEntries:
        """The rows that pass (r,) and have corners that the boundary may take."""
        ...

    def pattern(self, row: int) -> Pattern:
        """The pattern of a row."""
        ...

    def fill(
        self, row: int, orientation: int, widths: tuple[int, ...], loops: tuple[int, ...]
    ) -> Fill:
        """Expand a row. widths: of its strands; loops: of its loop polychords."""
        ...

    def copies(self, rows: NDArray[np.int64]) -> int:
        """How many widths at most are the same fill of one of these rows."""
        ...

    def one_of_each(self, row: int, widths: Int32Array) -> NDArray[np.bool_]:
        """(k,) which of the widths (k, n) of a row stand for all that are the same fill."""
        ...

    def may_repeat(self, row: int) -> bool:
        """May fills of this row equal others', or be no meshes?"""
        ...


class StrictTable:
    """The patterns of a class."""

    def __init__(self, patterns: PatternClass) -> None:
        self.patterns = patterns
        n = max(patterns.n_sides, 1)
        self.labels = Labels(n, patterns.words, patterns.word_start)
        self.signatures = patterns
        self.ids = patterns.ids
        self.frequency = patterns.frequency
        self.uses = patterns.uses
        self.n_meshes = patterns.n_meshes
        self.n_symmetries = patterns.rotations * np.where(patterns.chiral, 1, 2).astype(np.int32)
        self.n_quads = patterns.n_quads
        self.n_loops = patterns.n_loops
        self.n_corners = np.full(len(patterns), patterns.n_sides, np.int32)
        self.min_valence = patterns.min_valence
        self.max_valence = patterns.max_valence
        self.listings: dict[Any, Any] = {}
        self._distinct = np.packbits(_distinct(patterns), axis=1)
        self._repeats: dict[int, bool] = {}
        # Queries expand few patterns, many times each.
        self.pattern = lru_cache(maxsize=4096)(patterns.pattern)

    def entries(self, boundary: Boundary, passing: NDArray[np.bool_]) -> TableEntries:
        patterns = self.patterns
        reflex = boundary.n_reflex
        rows = np.flatnonzero(passing & (patterns.n_reflex == reflex))
        n_orientations = len(list_orientations(patterns.n_sides))
        packed = self._distinct[rows]
        if reflex:
            allowed = _unpack(packed, n_orientations)
            wanted = np.array(boundary.corner_counts, np.uint8)[list_corners_seen(boundary.n_sides)]
            corners = patterns.corners[rows]
            for o in range(len(wanted)):
                allowed[:, o] &= (corners == wanted[o]).all(axis=1)
            some = allowed.any(axis=1)
            rows, packed = rows[some], np.packbits(allowed[some], axis=1)
        zeros = np.zeros(len(rows), np.int32)
        return TableEntries(rows, patterns.n_irregular[rows], zeros, packed, n_orientations)

    def fill(
        self, row: int, orientation: int, widths: tuple[int, ...], loops: tuple[int, ...]
    ) -> Fill:
        o = list_orientations(self.patterns.n_sides)[orientation]
        pattern = self.pattern(row)
        return expand_pattern(
            pattern,
            widths[: pattern.n_chords] + loops,
            rotation=o.rotation,
            mirrored=o.mirrored,
        )

    def copies(self, rows: NDArray[np.int64]) -> int:
        return 1 if self.patterns.n_sides else int(self.patterns.rotations[rows].max(initial=1))

    def one_of_each(self, row: int, widths: Int32Array) -> NDArray[np.bool_]:
        smallest = np.ones(len(widths), np.bool_)
        if self.patterns.n_sides or self.patterns.rotations[row] == 1:
            return smallest
        # One closed side has no first edge: fits that differ by a rotation of it are one.
        pattern = self.pattern(row)
        widths = widths[:, : pattern.n_chords]
        for moved in list_chord_symmetries(pattern):
            turned = widths[:, moved]
            differ = turned != widths
            first = differ.argmax(axis=1)
            at = np.arange(len(widths))
            smallest &= ~differ.any(axis=1) | (widths[at, first] < turned[at, first])
        return smallest

    def may_repeat(self, row: int) -> bool:
        if row not in self._repeats:
            pattern = self.pattern(row)
            self._repeats[row] = pattern.self_crossing or not is_mesh(pattern.disk().quads)
        return self._repeats[row]


def _distinct(patterns: PatternClass) -> NDArray[np.bool_]:
    """(p, o) bool: the orientations less those that the patterns' own symmetries make equal.

    ``rotations`` of the N rotations map a pattern onto itself, so only the first N / rotations
    differ; its mirror image differs only where it is chiral.
    """
    every = list_orientations(patterns.n_sides)
    rotation = np.array([o.rotation for o in every])
    mirrored = np.array([o.mirrored for o in every])
    turns = np.maximum(patterns.n_sides // patterns.rotations, 1)
    return (rotation < turns[:, None]) & (patterns.chiral[:, None] | ~mirrored)


class RelaxedTable:
    """Marked patterns; those that are strict too are left out where a class holds them."""

    def __init__(
        self, marked: MarkedClass, known: PatternClass | None, frequencies: Frequencies | None
    ) -> None:
        """known: the class of as many sides whose patterns a strict table lists already.
        frequencies: how often artists made the patterns; None where the table knows."""
        self.marked = marked
        patterns, of = marked.patterns, marked.pattern
        seen = patterns.frequency if frequencies is None else frequencies(patterns.ids)
        self.labels = Labels(marked.n_sides, marked.label, marked.label_start)
        self.signatures = marked
        self.ids = patterns.ids[of]
        self.frequency = seen[of]
        self.uses = np.zeros(len(marked), np.int64)
        self.n_meshes = np.zeros(len(marked), np.int32)
        self.n_symmetries = np.ones(len(marked), np.int32)
        self.n_quads = patterns.n_quads[of]
        self.n_loops = patterns.n_loops[of]
        self.n_corners = patterns.n_sides[of]
        self.min_valence = patterns.min_valence[of]
        self.max_valence = patterns.max_valence[of]
        self.listings: dict[Any, Any] = {}
        self.fresh = np.ones(len(marked), np.bool_)
        if known is not None:
            self.fresh = ~(marked.strict & np.isin(self.ids, known.ids))
        self.pattern = lru_cache(maxsize=4096)(self._pattern)

    def _pattern(self, row: int) -> Pattern:
        pattern = self.marked.patterns.pattern(int(self.marked.pattern[row]))
        seen = int(self.frequency[row])
        return replace(pattern, frequency=seen, origin="learned") if seen else pattern

    def entries(self, boundary: Boundary, passing: NDArray[np.bool_]) -> TableEntries:
        marked = self.marked
        rows = np.flatnonzero(passing & self.fresh)
        counts = marked.counts[rows]
        every = list_orientations(marked.n_sides)
        if boundary.convex or self.marked.free:
            target = FLAT if self.marked.free else QUADS_AT["convex"]
            wrong = np.broadcast_to(
                (counts != target).sum(axis=1)[:, None], (len(rows), len(every))
            )
        else:
            wrong = np.stack([(counts != o.seen(boundary)[1]).sum(axis=1) for o in every], axis=1)
        at_boundary = (marked.n_unmarked[rows][:, None] + wrong).astype(np.int32)
        parts: list[TableEntries] = []
        for level in np.unique(at_boundary).tolist():
            allowed = at_boundary == level
            some = np.flatnonzero(allowed.any(axis=1))
            interior = marked.cost[rows[some]] - marked.n_unmarked[rows[some]]
            on_boundary = np.full(len(some), level, np.int32)
            packed = np.packbits(allowed[some], axis=1)
            parts.append(
                TableEntries(rows[some], interior + on_boundary, on_boundary, packed, len(every))
            )
        if not parts:
            none = np.zeros(0, np.int32)
            packed = np.packbits(np.zeros((0, len(every)), np.bool_), axis=1)
            return TableEntries(rows[:0], none, none, packed, len(every))
        return TableEntries(
            np.concatenate([p.row for p in parts]),
            np.concatenate([p.n_irregular for p in parts]),
            np.concatenate([p.n_irregular_boundary for p in parts]),
            np.concatenate([p.packed for p in parts]),
            len(every),
        )

    def fill(
        self, row: int, orientation: int, widths: tuple[int, ...], loops: tuple[int, ...]
    ) -> Fill:
        o = list_orientations(self.marked.n_sides)[orientation]
        n = len(self.marked.chords(row))
        got = expand_marked(self.marked, row, widths[:n], o, loops)
        return Fill(
            quads=got.quads,
            n_vertices=got.n_vertices,
            lengths=got.lengths,
            pattern=self.pattern(row),
            widths=got.widths,
            rotation=(got.first - o.mirrored) % sum(got.lengths),
            mirrored=o.mirrored,
            n_irregular=got.pattern.n_irregular,
            origin=self.pattern(row).origin,
        )

    def copies(self, rows: NDArray[np.int64]) -> int:
        return 1

    def one_of_each(self, row: int, widths: Int32Array) -> NDArray[np.bool_]:
        return np.ones(len(widths), np.bool_)

    def may_repeat(self, row: int) -> bool:
        # Marks that a symmetry of the pattern moves onto each other are tried in all orientations.
        return True


#: One table is made once, however many threads ask for it.
_MAKING = threading.RLock()


def get_strict_table(patterns: PatternClass) -> StrictTable:
    """The table of a class, kept as long as the class is."""
    with _MAKING:
        if "strict" not in patterns.tables:
            patterns.tables["strict"] = StrictTable(patterns)
        return patterns.tables["strict"]


def get_relaxed_table(
    patterns: PatternClass,
    frequencies: Frequencies | None = None,
    cancelled: CancelFlag = NEVER,
) -> RelaxedTable:
    """The complete family's marked patterns of as many sides, less the strict ones of the class.

    frequencies: of the database that the class is of. Raises QueryCancelledError once ``cancelled``
    is set before the family is loaded.
    """
    with _MAKING:
        if "relaxed" not in patterns.tables:
            n = patterns.n_sides
            marked = load_marked_family(max(n, 1), free=n == 0, cancelled=cancelled)
            patterns.tables["relaxed"] = RelaxedTable(marked, patterns, frequencies)
        return patterns.tables["relaxed"]


def find_least_irregular(
    boundary: Boundary, most_on_boundary: int, cancelled: CancelFlag = NEVER
) -> int | None:
    """The fewest irregular vertices of a relaxed fill with at most so many on the boundary.

    None where there is no such fill; 0 where that cannot be found out at once. Raises
    QueryCancelledError once ``cancelled`` is set before the family is loaded.
    """
    n = boundary.n_sides
    if n > MOST_SIDES:
        return 0
    index = load_family_index(max(n, 1), free=n == 0, cancelled=cancelled)
    found = find_best_marked(index, boundary, cap=most_on_boundary)
    return None if found is None else found.n_irregular


def get_begun_table(patterns: PatternClass) -> RelaxedTable:
    """The patterns of one closed side, begun at every place where its vertex 0 may fall.

    Without strokes it does not matter where a closed side begins; a stroke's ends are counted
    from there. Patterns of more than MOST_SLOTS irregular vertices are left out.
    """
    with _MAKING:
        if "begun" not in patterns.tables:
            table = PatternTable.from_class(patterns, MOST_SLOTS)
            marked = mark_patterns(table, 1, most=MOST_SLOTS, free=True)
            patterns.tables["begun"] = RelaxedTable(marked, None, None)
        return patterns.tables["begun"]
