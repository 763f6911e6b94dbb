"""Expansion: a pattern and the widths of its polychords become a quad mesh.

Each pattern quad becomes a grid, as many quads along an edge as the polychord that
crosses the edge is wide; grids are glued along the pattern's edges (Marcias et al. 2015,
section 4). A quad that one polychord passes twice becomes a square grid. Of a marked pattern
(:mod:`query.relaxed.corner_placement`) the widths of the strands make the polychords wide.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from patterndb._native.query.expand import expand_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from query.errors import InvalidQueryError
from query.fill import Fill
from query.orientation import Orientation
from query.relaxed.corner_placement import MarkedClass


def expand_pattern(
    pattern: Pattern, widths: Sequence[int], *, rotation: int = 0, mirrored: bool = False
) -> Fill:
    """Expand a pattern and turn it as :class:`Fill` says.

    widths: one >= 1 for every open polychord, in label order, then one for every loop;
    loops may be left out, they are 1 wide then. Raises InvalidQueryError for another
    number of widths or a width below 1.
    """
    given = tuple(operator.index(w) for w in widths)
    if len(given) == pattern.n_chords:
        given += (1,) * pattern.n_loops
    if len(given) != pattern.n_chords + pattern.n_loops:
        raise InvalidQueryError(
            f"{len(given)} widths for the {pattern.n_chords} open polychords and "
            f"{pattern.n_loops} loops of pattern {pattern.name}; give one for each"
        )
    if min(given) < 1:
        raise InvalidQueryError(
            f"width {min(given)} of polychord {given.index(min(given))}: the least is 1"
        )
    sides = [sum(given[chord] for chord in side) for side in pattern.label]
    start = [0, *accumulate(sides)]
    perimeter = start[-1]
    n = pattern.n_sides
    if n == 0:
        rotation %= perimeter
        first = rotation + mirrored
        lengths = sides
    else:
        rotation %= n
        first = start[(rotation + mirrored) % n]
        lengths = [sides[(rotation - i if mirrored else rotation + i) % n] for i in range(n)]
    twin, of_edge = list_pattern_edges(pattern)
    across = np.array(given, np.int32)[of_edge]
    quads, n_vertices = expand_quads(twin, across, perimeter, first, mirrored)
    return Fill(
        quads=quads,
        n_vertices=n_vertices,
        lengths=tuple(lengths),
        pattern=pattern,
        widths=given,
        rotation=rotation,
        mirrored=mirrored,
        n_irregular=pattern.n_irregular,
        origin=pattern.origin,
    )


@lru_cache(maxsize=8192)
def list_pattern_edges(pattern: Pattern) -> tuple[Int32Array, Int32Array]:
    """(4q,) int32 half-edges of a pattern, and the polychord that crosses each; kept, for a
    pattern is expanded many times."""
    return pattern.twin(), pattern.polychords().of_edge


class ExpandedPattern(NamedTuple):
    """A marked pattern, expanded and turned.

    pattern:    the pattern.
    quads:      (q, 4) int32, counter-clockwise; boundary vertices are 0..P-1 in the order of
                the boundary, 0 where its side 0 begins; interior ones follow.
    n_vertices: number of vertices.
    lengths:    edges of every side of the boundary.
    widths:     width of each polychord, open ones in label order, then loops.
    first:      the boundary vertex of the expanded pattern, counted from its corner 0, that
                is vertex 0. Edge i of the boundary is edge first + i of the expanded
                pattern, or, mirrored, edge first - i - 1.
    """

    pattern: Pattern
    quads: Int32Array
    n_vertices: int
    lengths: tuple[int, ...]
    widths: tuple[int, ...]
    first: int


def expand_marked(
    marked: MarkedClass,
    row: int,
    strand_widths: Sequence[int],
    orientation: Orientation,
    loops: Sequence[int] = (),
) -> ExpandedPattern:
    """Expand the pattern of a row of the table.

    strand_widths: one >= 1 for each strand. orientation: side i of the boundary is the
    marked pattern's side rotation + i, or, mirrored, its side rotation - i read backwards.
    loops: widths of the loop polychords, 1 where not given.
    Raises InvalidQueryError for another number of widths or a width below 1.
    """
    chords = marked.chords(row)
    strands = np.asarray(strand_widths, np.int64)
    if len(strands) != len(chords) or strands.min() < 1:
        raise InvalidQueryError(
            f"row {row} has {len(chords)} strands, each at least 1 wide; "
            f"the widths given are {strands.tolist()}"
        )
    pattern = marked.patterns.pattern(int(marked.pattern[row]))
    widths = np.ones(pattern.n_chords + pattern.n_loops, np.int64)
    widths[: pattern.n_chords] = 0
    if loops:
        widths[pattern.n_chords :] = loops
    np.add.at(widths, chords, strands)
    sides = marked.sides(row)
    lengths = [int(strands[side].sum()) for side in sides]
    start = np.r_[0, np.cumsum(lengths)]
    perimeter = int(start[-1])
    # The strands before mark 0 on its edge are the last ones of the last side.
    edges = [chord for side in pattern.label for chord in side]
    ends = [strand for side in sides for strand in side]
    before = int(marked.start_strand[row])
    zero = widths[edges[: int(marked.start_edge[row])]].sum()
    zero += strands[ends[len(ends) - before :]].sum()
    n = marked.n_sides
    rotation, mirrored = orientation.rotation % n, orientation.mirrored
    first = int(zero + start[(rotation + mirrored) % n]) % perimeter
    twin, of_edge = list_pattern_edges(pattern)
    across = widths.astype(np.int32)[of_edge]
    quads, n_vertices = expand_quads(twin, across, perimeter, first, mirrored)
    return ExpandedPattern(
        pattern=pattern,
        quads=quads,
        n_vertices=n_vertices,
        lengths=tuple(lengths[(rotation - i if mirrored else rotation + i) % n] for i in range(n)),
        widths=tuple(widths.tolist()),
        first=first,
    )
