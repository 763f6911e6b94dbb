"""Read a fill as the pattern that it expands, so that its polychords can be made wider."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.code import rooted_code
from patterndb._native.query.expand import expand_quads
from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.errors import PatternDBError
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.choice import By, Choice
from query.boundary import Boundary
from query.expand import list_pattern_edges
from query.recognition import read_fill


@dataclass(frozen=True, slots=True, eq=False)
class Expansion:
    """What a choice is: a pattern, how wide its polychords are, and where the boundary begins.

    widths:   of the pattern's polychords, open ones in label order, then loops.
    first:    the boundary vertex of the expanded pattern that is vertex 0, counted from the
              pattern's first. Edge i of the boundary is edge first + i, or, mirrored,
              first - i - 1.
    mirrored: is the pattern turned over? strict: are its corners where the patch's are?
    twin:     (4q,) int32 half-edges of the choice's quads.
    border:   (P,) int32, the half-edge of every boundary edge.
    chord:    (4q,) int32, the pattern's polychord that crosses every half-edge.
    """

    choice: Choice
    pattern: Pattern
    widths: tuple[int, ...]
    first: int
    mirrored: bool
    strict: bool
    twin: Int32Array
    border: Int32Array
    chord: Int32Array

    @classmethod
    def of(cls, choice: Choice) -> Expansion:
        """Read a choice as an expansion, its own pattern's if that gives its quads.

        Else, as after an import, the pattern is recognised from the quads. Raises RefusedError
        for quads that are no disk, or of a pattern beyond what codes can name.
        """
        quads = choice.faces
        twin, fault = weld_quads(quads, choice.n_vertices, choice.perimeter)
        if fault:
            raise RefusedError("the patch's quads are no disk; choose another fill for it")
        tail = quads.ravel()
        border = np.empty(choice.perimeter, np.int32)
        rim = np.flatnonzero(twin < 0).astype(np.int32)
        border[tail[rim]] = rim
        code, edges = _read_code(twin, int(border[0]))
        for pattern, widths, rotation, mirrored, strict in _list_readings(choice):
            sides = _side_lengths(pattern, widths)
            if strict:
                n = pattern.n_sides
                first = sum(sides[: (rotation + mirrored) % n])
            else:
                first = (rotation + mirrored) % sum(sides)
            other, n_vertices = _expand(pattern, widths, first, mirrored)
            if n_vertices != choice.n_vertices or len(other) != len(quads):
                continue
            other_twin, fault = weld_quads(other, n_vertices, choice.perimeter)
            if fault:
                continue
            begin = np.flatnonzero((other_twin < 0) & (other.ravel() == 0))[0]
            other_code, other_edges = _read_code(other_twin, int(begin))
            if not np.array_equal(code, other_code):
                continue
            # Quads come in the order of the pattern's, and keep its edges' order.
            pattern_edge = np.empty(len(tail), np.int32)
            pattern_edge[edges] = _pattern_edges(pattern, widths, mirrored)[other_edges]
            chord = list_pattern_edges(pattern)[1][pattern_edge]
            return cls(choice, pattern, widths, first, mirrored, strict, twin, border, chord)
        raise RefusedError("the patch's quads are no expansion of a pattern; choose another fill")

    def across(self, edge: int) -> int:
        """The boundary edge at the other end of the strip through a boundary edge."""
        tail = self.choice.faces.ravel()
        half = int(self.border[edge])
        while True:
            half ^= 2
            after = int(self.twin[half])
            if after < 0:
                return int(tail[half])
            half = after

    def widen(
        self, chords: Sequence[int], edges: Sequence[int], lengths: tuple[int, ...]
    ) -> Choice:
        """With strips doubled.

        chords: the polychord of every strip. edges: all boundary edges that they cross.
        lengths: of the sides then.
        """
        wide = np.array(self.widths)
        np.add.at(wide, list(chords), 1)
        at = np.array(edges, np.int64)
        perimeter = self.choice.perimeter
        place = (self.first - at - 1 if self.mirrored else self.first + at) % perimeter
        first = self.first + int((place < self.first).sum())
        return self._made(tuple(wide.tolist()), first, lengths, self.choice.by)

    def resize(self, widths: Sequence[int]) -> Choice:
        """With other widths of the open polychords, such that the pattern's sides stay as long;
        by the user."""
        return self._made(self._all(widths), self.first, self.choice.lengths, "user")

    def quads(self, widths: Sequence[int]) -> tuple[Int32Array, int]:
        """(q, 4) int32 quads of the same, and the number of their vertices."""
        return _expand(self.pattern, self._all(widths), self.first, self.mirrored)

    def _all(self, widths: Sequence[int]) -> tuple[int, ...]:
        """Widths of all polychords, given those of the open ones."""
        n = self.pattern.n_chords
        return (*widths[:n], *self.widths[n:])

    def _made(
        self, widths: tuple[int, ...], first: int, lengths: tuple[int, ...], by: By
    ) -> Choice:
        perimeter = sum(lengths)
        first %= perimeter
        quads, n_vertices = _expand(self.pattern, widths, first, self.mirrored)
        if self.strict:
            sides = _side_lengths(self.pattern, widths)
            start = np.cumsum([0, *sides[:-1]]).tolist().index(first)
            rotation = (start - self.mirrored) % self.pattern.n_sides
        else:
            rotation = (first - self.mirrored) % perimeter
        return Choice(
            lengths=lengths,
            quads=np.ascontiguousarray(quads, "<i4").tobytes(),
            n_vertices=n_vertices,
            code=np.ascontiguousarray(self.pattern.code).tobytes(),
            widths=widths,
            rotation=rotation,
            mirrored=self.mirrored,
            origin=self.choice.origin,
            n_irregular=self.choice.n_irregular,
            by=by,
        )


def _list_readings(choice: Choice) -> Iterator[tuple[Pattern, tuple[int, ...], int, bool, bool]]:
    """Pattern, widths, rotation, mirrored and strict, as the choice may mean them."""
    code = np.frombuffer(choice.code, np.uint16)
    pattern = Pattern.from_trusted_code(code, origin=choice.origin)
    widths = choice.widths
    fits = len(widths) == pattern.n_chords + pattern.n_loops and min(widths) > 0
    sides = _side_lengths(pattern, widths) if fits else []
    if sum(sides) == choice.perimeter:
        n = pattern.n_sides
        turn = -1 if choice.mirrored else 1
        own = tuple(sides[(choice.rotation + turn * i) % n] for i in range(n)) if n else ()
        # Of a relaxed fill, places of the boundary are irregular beside the pattern's vertices.
        if own == choice.lengths and choice.n_irregular == pattern.n_irregular:
            yield pattern, widths, choice.rotation, choice.mirrored, True
        yield pattern, widths, choice.rotation, choice.mirrored, False
    try:
        found = read_fill(choice.faces, Boundary(choice.lengths), choice.origin)
    except PatternDBError as error:
        raise RefusedError(f"the patch's fill cannot be read: {error}") from error
    strict = found.strict and found.pattern.n_sides > 0
    yield found.pattern, found.widths, found.rotation, found.mirrored, strict


def _side_lengths(pattern: Pattern, widths: Sequence[int]) -> list[int]:
    """Edges of the pattern's sides, in its order."""
    return [sum(widths[chord] for chord in side) for side in pattern.label]


def _expand(
    pattern: Pattern, widths: Sequence[int], first: int, mirrored: bool
) -> tuple[Int32Array, int]:
    twin, of_edge = list_pattern_edges(pattern)
    across = np.array(widths, np.int32)[of_edge]
    perimeter = sum(_side_lengths(pattern, widths))
    return expand_quads(twin, across, perimeter, first, mirrored)


def _pattern_edges(pattern: Pattern, widths: Sequence[int], mirrored: bool) -> Int32Array:
    """(4q,) int32, the pattern's half-edge that each half-edge of the expansion is parallel to."""
    across = np.array(widths, np.int32)[list_pattern_edges(pattern)[1]].reshape(-1, 4)
    of_quad = np.repeat(np.arange(len(across)), across[:, 0] * across[:, 1])
    # Turned over, corners 1 and 3 of a quad change places: edges run from last to first.
    order = np.arange(3, -1, -1) if mirrored else np.arange(4)
    return (4 * of_quad[:, None] + order).ravel().astype(np.int32)


def _read_code(twin: Int32Array, start: int) -> tuple[Int32Array, NDArray[np.int64]]:
    """The code of a disk as read from a half-edge, and its half-edges in the order of reading."""
    q = len(twin) // 4
    # Wider than the codes of patterns, which name at most 16,383 quads.
    code = np.zeros(4 * q, np.int32)
    number, entry, order = (np.empty(q, np.int32) for _ in range(3))
    rooted_code(twin, q, start, False, code, number, entry, order, False)  # pyright: ignore[reportArgumentType]
    edges = (entry[:, None] + np.arange(4)) & 3
    return code, (4 * order.astype(np.int64)[:, None] + edges).ravel()
