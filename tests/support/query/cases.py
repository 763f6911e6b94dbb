"""What the query tests share: every small quad disk, classes of patterns, random systems."""

from __future__ import annotations

import csv
import random
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

import query
from patterndb.core.halfedge import Int32Array
from patterndb.core.label import join_matrices
from patterndb.core.packing import pack
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from query import Boundary, Fill, Fills
from query.boundary import CornerKind
from query.listing.table import StrictTable
from query.orientation import list_corners_seen
from query.solving.problem import Labels, WidthProblem, build_width_problem
from query.solving.widths import WidthSolver
from tests.support.reference.code import Code, mirrored, rooted_code
from tests.support.reference.halfedge import Quads, as_complex, border_loop, fans, twins
from tests.support.shared import DATA
from tests.support.smalldisks import read_small_disks

KIND: dict[int, CornerKind] = {1: "convex", 3: "reflex"}

Widths = tuple[int, ...]


@cache
def read_reference_fills() -> list[tuple[Boundary, int]]:
    """Return random boundaries of 2 to 6 sides, each with the irregular vertices of the fill that
    the 15 patterns of Takayama et al. (2014) give, by a program of others.

    Vertices of the border count where they have another number of quads than 1 at a corner and 2
    elsewhere.
    """
    with (DATA / "fifteen_patterns.csv").open(newline="") as file:
        return [
            (Boundary(map(int, row["lengths"].split("-"))), int(row["n_irregular"]))
            for row in csv.DictReader(file)
        ]


@cache
def small_disks() -> list[list[int]]:
    """Half-edges of all disks of at most 14 boundary and 4 interior vertices, the latter of
    valence 3 to 5, with at most 3 quads at a boundary vertex, up to rotation and mirror image."""
    return [
        QuadMesh.from_quads(np.array(quads)).twin.tolist() for _, _, quads in read_small_disks()
    ]


@cache
def small_patterns() -> list[Pattern]:
    """The patterns of the small disks, with made-up frequencies."""
    found: dict[int, Pattern] = {}
    for twin in small_disks():
        pattern = Pattern.from_disk(reduce_disk(np.array(twin, np.int32)))
        found[pattern.id] = pattern
    return [
        Pattern.from_trusted_code(p.code, frequency=1 + p.id % 7) for _, p in sorted(found.items())
    ]


@cache
def small_class(n_sides: int) -> PatternClass:
    """Those of ``n_sides`` sides."""
    return class_of(n_sides, [p for p in small_patterns() if p.n_sides == n_sides])


def class_of(n_sides: int, patterns: Sequence[Pattern]) -> PatternClass:
    """The class of these patterns."""
    if n_sides:
        return PatternClass.from_patterns(n_sides, patterns)
    patterns = sorted(patterns, key=lambda p: (p.n_irregular, -p.frequency, p.id))
    n = len(patterns)
    zeros = np.zeros(n, np.int32)
    return PatternClass(
        n_sides=0,
        ids=np.array([p.id for p in patterns], np.int64),
        frequency=np.array([p.frequency for p in patterns], np.int64),
        n_meshes=np.ones(n, np.int32),
        uses=np.zeros(n, np.int64),
        origin=np.zeros(n, np.int8),
        n_irregular=np.array([p.n_irregular for p in patterns], np.int32),
        n_quads=np.array([p.n_quads for p in patterns], np.int32),
        min_valence=np.array([min(p.valences) for p in patterns], np.int32),
        max_valence=np.array([max(p.valences) for p in patterns], np.int32),
        n_reflex=zeros,
        corners=np.zeros((n, 0), np.uint8),
        n_loops=np.array([p.n_loops for p in patterns], np.int32),
        chiral=np.array([p.chiral for p in patterns], np.bool_),
        rotations=np.array([p.rotations for p in patterns], np.int32),
        self_crossing=np.array([p.self_crossing for p in patterns], np.bool_),
        words=np.array([x for p in patterns for x in (len(p.label[0]), *p.label[0])], np.int16),
        word_start=np.cumsum([0, *(1 + len(p.label[0]) for p in patterns)], dtype=np.int64),
        signature=np.arange(n, dtype=np.int32),
        rotation=zeros,
        reflected=np.zeros(n, np.bool_),
        codes=[pack(p.code) for p in patterns],
        lengths=np.array([[len(p.label[0])] for p in patterns], np.int32).reshape(-1, 1),
        joins=np.array([[[p.n_chords]] for p in patterns], np.int32).reshape(-1, 1, 1),
    )


@cache
def small_fills() -> dict[Boundary, set[Code]]:
    """Every boundary that a small disk fills strictly, with the codes of its fills.

    A disk is laid on a boundary in every rotation and mirror image, by plain Python. A fill's
    code is read from vertex 0, that of a closed side is the smallest from any vertex.
    """
    found: dict[Boundary, set[Code]] = defaultdict(set)
    for disk in small_disks():
        for twin in (disk, mirrored(disk)):
            complex_ = as_complex(twin)
            vertex = fans(complex_)
            loop = border_loop(complex_, twin.index(-1))
            count = np.bincount([vertex[h] for h in complex_])[[vertex[h] for h in loop]]
            corners = np.flatnonzero(count != 2).tolist()
            if not corners:
                code = min(rooted_code(twin, h) for h in loop)
                found[Boundary.closed(len(loop))].add(code)
            for i in range(len(corners)):
                at = [*corners[i:], *(c + len(loop) for c in corners[:i])]
                lengths = np.diff([*at, at[0] + len(loop)]).tolist()
                kinds = [KIND[int(count[c % len(loop)])] for c in at]
                found[Boundary(lengths, kinds)].add(rooted_code(twin, loop[at[0]]))
    return dict(found)


def code_of(fill: Fill, closed: bool = False) -> Code:
    """The code of a fill, as in :func:`small_fills`, by plain Python.

    closed: the boundary is one closed side, which has no first vertex.
    """
    quads: Quads = fill.quads.tolist()
    twin = twins(quads)
    starts = [h for h, t in enumerate(twin) if t < 0 and (quads[h // 4][h % 4] == 0 or closed)]
    return min(rooted_code(twin, h) for h in starts)


class Source:
    """As much of a database as a query needs: the small patterns."""

    def pattern_class(self, n_sides: int) -> PatternClass:
        return small_class(n_sides)


class Answer(list[Fill]):
    """The fills of a query, and what it said about them."""

    def __init__(self, found: Fills) -> None:
        super().__init__(found)
        self.boundary = found.boundary
        self.truncated = found.truncated
        self.feasible_patterns = found.feasible_patterns
        self.reason = found.reason
        self.seconds = found.seconds


#: Options under which the answer is all about the patterns of the class.
LEARNED = {"strict": True, "origins": ("learned",), "order": "regular", "valence": None}


def answer(source: object, boundary: object, **options: object) -> Answer:
    """The whole answer to a query about learned patterns, or as the options have it."""
    return Answer(query.fills(source, boundary, **{**LEARNED, **options}))  # pyright: ignore


@dataclass(frozen=True, slots=True)
class Chords:
    """The open polychords of one pattern, as a table of one row in one orientation.

    label: per side, the polychord that crosses each edge. sides: (n, 2) the sides i <= j that
    each polychord joins.
    """

    label: tuple[tuple[int, ...], ...]
    sides: Int32Array

    @classmethod
    def from_label(cls, label: Sequence[Sequence[int]]) -> Chords:
        ends: dict[int, list[int]] = {}
        for side, chords in enumerate(label):
            for chord in chords:
                ends.setdefault(chord, []).append(side)
        sides = np.array([ends[chord] for chord in range(len(ends))], np.int32)
        return cls(tuple(map(tuple, label)), sides.reshape(-1, 2))

    @classmethod
    def from_sides(cls, n_sides: int, sides: ArrayLike) -> Chords:
        """From the two sides, in either order, of every polychord, in that order along sides."""
        label: list[list[int]] = [[] for _ in range(n_sides)]
        for chord, pair in enumerate(np.asarray(sides, np.int32).reshape(-1, 2).tolist()):
            for side in pair:
                label[side].append(chord)
        return cls.from_label(label)

    @property
    def n_sides(self) -> int:
        return len(self.label)

    @property
    def n(self) -> int:
        return len(self.sides)

    def side_lengths(self, widths: ArrayLike) -> NDArray[np.int64]:
        """(n_sides,) int64 edges of every side with the given widths (n,)."""
        return np.array([sum(np.asarray(widths)[list(side)]) for side in self.label], np.int64)

    def base_lengths(self) -> Int32Array:
        return np.array([len(side) for side in self.label], np.int32)

    # What a solver asks of a table.

    @property
    def labels(self) -> Labels:
        return Labels.of_pattern(self.label)

    @property
    def signatures(self) -> Chords:
        return self

    signature = rotation = property(lambda _: np.zeros(1, np.int32))
    reflected = property(lambda _: np.zeros(1, np.bool_))
    lengths = property(lambda self: self.base_lengths()[None])

    @property
    def joins(self) -> Int32Array:
        return join_matrices(self.n_sides, self.sides, np.zeros(self.n, np.int64), 1)


@dataclass(frozen=True, slots=True)
class Strokes:
    """Strokes as a pattern sees them: (s, 4) int32 side, edge, side, edge; and a tolerance."""

    rows: Int32Array
    tolerance: int


#: No strokes.
NO_STROKES = Strokes(np.zeros((0, 4), np.int32), 0)

#: One row of one pattern in one orientation.
ONE = np.zeros(1, np.int64)
ALONE = np.array([[0x80]], np.uint8)


def make_solver(
    lengths: ArrayLike, strokes: Strokes = NO_STROKES, *, by_cpsat: bool = False
) -> WidthSolver:
    """The solver for lengths (n,) and strokes in one orientation."""
    wanted = np.asarray(lengths, np.int32)
    problem = WidthProblem.of_lengths(wanted, strokes.rows, strokes.tolerance)
    return WidthSolver(problem, by_cpsat=by_cpsat)


def is_feasible(
    chords: Chords, lengths: ArrayLike, strokes: Strokes = NO_STROKES, *, by_cpsat: bool = False
) -> bool:
    """Are there widths of one pattern?"""
    solver = make_solver(lengths, strokes, by_cpsat=by_cpsat)
    found = bool(solver.is_feasible(chords, ONE, ALONE)[0])
    assert by_cpsat or solver.find_feasible(chords, ONE, ALONE).tolist() == [[found]]
    return found


def find_widths(
    chords: Chords,
    lengths: ArrayLike,
    limit: int | None = None,
    strokes: Strokes = NO_STROKES,
    *,
    by_cpsat: bool = False,
) -> list[Widths]:
    """The best widths of one pattern, at most ``limit``; None for all."""
    solver = make_solver(lengths, strokes, by_cpsat=by_cpsat)
    # CP-SAT lists all whatever is kept.
    keep = limit or (1 << 20 if by_cpsat else 64)
    while True:
        best = solver.find_best(chords.labels, ONE, np.ones((1, 1), np.bool_), keep)
        if limit is not None or len(best.row) < keep:
            return [tuple(row) for row in best.widths.tolist()]
        keep *= 8


def all_allowed(
    table: StrictTable, boundary: Boundary, rows: NDArray[np.int64]
) -> NDArray[np.uint8]:
    """Packed: the orientations in which corners fall on their like, symmetric ones included."""
    n = boundary.n_sides
    wanted = np.array(boundary.corner_counts, np.uint8)[list_corners_seen(n)]
    corners = table.patterns.corners[rows]
    allowed = (corners[:, None] == wanted[None]).all(axis=2)
    return np.packbits(allowed.reshape(len(rows), 2 * max(n, 1)), axis=1)


def find_orientations(
    table: StrictTable, boundary: Boundary, rows: NDArray[np.int64], threads: int | None = None
) -> NDArray[np.bool_]:
    """(r, o): in which orientations patterns fit strictly, symmetric ones included."""
    solver = WidthSolver(build_width_problem(boundary), threads=threads)
    return solver.find_feasible(table, rows, all_allowed(table, boundary, rows))


def find_rows(
    table: StrictTable, boundary: Boundary, rows: NDArray[np.int64], threads: int | None = None
) -> NDArray[np.int64]:
    """The rows whose patterns fit strictly in any orientation."""
    solver = WidthSolver(build_width_problem(boundary), threads=threads)
    return rows[solver.is_feasible(table, rows, all_allowed(table, boundary, rows))]


def brute_force(chords: Chords, lengths: Sequence[int]) -> list[Widths]:
    """All widths that meet the lengths, best first, by trying."""
    most = [min(lengths[i], lengths[j]) for i, j in chords.sides.tolist()]
    found: list[Widths] = []

    def extend(widths: Widths, left: list[int]) -> None:
        if len(widths) == chords.n:
            if not any(left):
                found.append(widths)
            return
        i, j = chords.sides[len(widths)].tolist()
        for x in range(1, most[len(widths)] + 1):
            rest = list(left)
            rest[i] -= x
            rest[j] -= x
            if min(rest) < 0:
                break
            extend((*widths, x), rest)

    extend((), list(lengths))
    return sorted(found, key=lambda widths: (sum(x * x for x in widths), widths))


def random_system(
    chance: random.Random, most_sides: int = 6, most_chords: int = 7, widest: int = 4
) -> tuple[Chords, list[int]]:
    """A random system: half of them have a solution by construction."""
    n_sides = chance.randint(1, most_sides)
    n = chance.randint(1, most_chords)
    sides = [(chance.randrange(n_sides), chance.randrange(n_sides)) for _ in range(n)]
    chords = Chords.from_sides(n_sides, sides)
    lengths = chords.side_lengths([chance.randint(1, widest) for _ in range(n)]).tolist()
    if chance.random() < 0.5:
        for _ in range(2):
            lengths[chance.randrange(n_sides)] += chance.choice([1, 1, 2])
    return chords, lengths


def laid_lengths(pattern: Pattern, widths: Sequence[int], rotation: int, mirror: bool) -> list[int]:
    """Edges of the boundary's sides where the pattern lies turned, by the definition."""
    sides = [sum(widths[c] for c in side) for side in pattern.label]
    n = len(sides)
    return [sides[(rotation - i if mirror else rotation + i) % n] for i in range(n)]


def laid_corners(pattern: Pattern, rotation: int, mirror: bool) -> list[int]:
    """Quads at the boundary's corners where the pattern lies turned.

    Corner i lies between sides i - 1 and i: between the pattern's sides that fall there.
    """
    n = pattern.n_sides
    result = []
    for i in range(n):
        side = (rotation - i if mirror else rotation + i) % n
        # Mirrored, the side is walked from its end, which is where the next one starts.
        result.append(pattern.corners[(side + 1) % n if mirror else side])
    return result


def all_orientations(n_sides: int) -> list[tuple[int, bool]]:
    return list(product(range(max(n_sides, 1)), (False, True)))


def grid_widths(chance: random.Random, pattern: Pattern, widest: int) -> NDArray[np.int64]:
    n = pattern.n_chords + pattern.n_loops
    return np.array([chance.randint(1, widest) for _ in range(n)])


def polygon(lengths: tuple[int, ...]) -> Boundary:
    """A boundary whose corners lie on a circle, a little out of round."""
    turn = np.linspace(0, 2 * np.pi, len(lengths), endpoint=False)
    at = np.c_[np.cos(turn), 0.8 * np.sin(turn)] * (1 + 0.1 * np.cos(3 * turn))[:, None]
    sides = [[at[i], at[(i + 1) % len(at)]] for i in range(len(at))]
    return Boundary.from_polylines(sides, lengths=lengths)
