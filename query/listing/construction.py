"""The stream of constructed fills, and the table that constructions look parts up in."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from query.boundary import Boundary
from query.cancellation import NEVER, CancelFlag
from query.construct import construct_fills
from query.construct.plan import PartFill
from query.expand import expand_marked
from query.fill import Fill
from query.listing.matches import Batch, Found, MatchSearch, PreparedQuery, Rank
from query.placing.strands import count_edges_off
from query.relaxed.bestmarked import (
    BOUNDARY_CAP,
    BestMarked,
    find_best_marked,
    load_family_index,
)
from query.request import Filter, admits
from query.stroke import Stroke

#: Sides up to which the family has marked patterns worth looking through.
MOST_SIDES = 8

#: Boundaries whose answers are kept: constructions ask for the same parts many times.
KEPT = 65_536


class FamilyLookup:
    """Best fills of boundaries with 2 to 8 sides; see :class:`query.construct.plan.Lookup`.

    What was looked up is kept for all that ask. Raises QueryCancelledError once ``cancelled`` is
    set before the family is loaded.
    """

    max_sides = MOST_SIDES

    def __init__(self, cancelled: CancelFlag = NEVER) -> None:
        self._cancelled = cancelled

    def count(self, boundary: Boundary, *, strict: bool = False) -> int | None:
        found = self._find(boundary, strict)
        return None if found is None else found.n_irregular

    def best(self, boundary: Boundary, *, strict: bool = False) -> PartFill | None:
        found = self._find(boundary, strict)
        if found is None:
            return None
        marked = load_family_index(boundary.n_sides).marked
        got = expand_marked(marked, found.row, found.strand_widths, found.orientation)
        return PartFill(got.quads, found.n_irregular)

    def _find(self, boundary: Boundary, strict: bool) -> BestMarked | None:
        load_family_index(boundary.n_sides, cancelled=self._cancelled)
        return _find_in_family(boundary, strict)


@lru_cache(maxsize=KEPT)
def _find_in_family(boundary: Boundary, strict: bool) -> BestMarked | None:
    index = load_family_index(boundary.n_sides)
    # Each reflex corner may cost one more than the marks of a convex boundary do.
    most = index.marked.most + boundary.corners.count("reflex")
    return find_best_marked(index, boundary, cap=0 if strict else BOUNDARY_CAP, most=most)


#: Constructed fills come after all others with as many irregular vertices: their boundary ones
#: count from here.
AFTER = 1000


@dataclass(frozen=True, slots=True, eq=False)
class ConstructedFill:
    """A fill that is there already."""

    made: Fill
    may_repeat: bool = True

    def fill(self) -> Fill:
        return self.made

    @property
    def pattern_id(self) -> int:
        return self.made.pattern.id


def list_constructed(
    search: MatchSearch, query: PreparedQuery, least: int, *, grid_only: bool = False
) -> Iterator[Batch]:
    """The constructed fills that pass the filters and follow the strokes, best first.

    The cap on irregular boundary vertices does not hold for them, so that none goes without.
    least: the irregular vertices of the best fill of the complete family, or 0; whatever is
    constructed of parts with as few would be in the family itself. grid_only: see
    :func:`query.construct.construct_fills`.
    """
    boundary = query.boundary
    request = query.request
    if query.ids is not None or request.min_frequency is not None:
        return
    filters = request.filters
    fewest = max(_count_least_irregular(boundary), least)
    yield Batch([], _rank(search, fewest, 0, 0, -1))
    made = construct_fills(
        boundary,
        FamilyLookup(search.cancelled),
        strict=request.strict,
        grid_only=grid_only,
        cancelled=search.cancelled,
    )
    for place, fill in enumerate(made):
        if search.cancelled[0]:
            return
        irregular = max(fewest, fill.n_irregular)
        bound = _rank(search, irregular, fill.n_irregular_boundary, 0, place)
        found: list[Found] = []
        off = _off(fill, search, request.strokes)
        if off is not None and off >= search.least_off and _passes(fill, query, filters):
            rank = _rank(search, irregular, fill.n_irregular_boundary, off, place)
            distance = float(off) if request.strokes else None
            found.append((rank, ConstructedFill(replace(fill, flow_distance=distance))))
        yield Batch(found, bound)


def _count_least_irregular(boundary: Boundary) -> int:
    """What a constructed fill counts at least in the order of lists.

    No vertex has more than two quads too many or too few, so that each irregular one makes up
    for at most two corners. Of 100,000 random convex boundaries none had one with fewer than
    N - 8 (benchmarks/answers.py); that constructions need not be tried before any fill with
    fewer is worth that such a one, if there is, should come a little late.
    """
    turn = sum(2 - count for count in boundary.corner_counts) - 4
    return max((abs(turn) + 1) // 2, boundary.n_sides - 8 if boundary.convex else 0)


def _rank(search: MatchSearch, irregular: int, boundary: int, off: int, place: int) -> Rank:
    return search.ranking.rank_constructed(irregular, AFTER + boundary, off, place)


@dataclass(frozen=True, slots=True)
class _FillColumns:
    """The numbers of one fill that filters of patterns read, see FilterColumns."""

    frequency: int
    n_quads: int
    n_loops: int
    n_corners: int
    min_valence: int
    max_valence: int


def _passes(fill: Fill, query: PreparedQuery, filters: Sequence[tuple[str, Filter, Any]]) -> bool:
    pattern = fill.pattern
    if query.only is not None and pattern.id not in query.only:
        return False
    columns = _FillColumns(
        frequency=0,
        n_quads=fill.n_quads,
        n_loops=pattern.n_loops,
        n_corners=pattern.n_sides,
        min_valence=min(pattern.valences, default=4),
        max_valence=max(pattern.valences, default=4),
    )
    return admits(filters, fill, columns)


def _off(fill: Fill, search: MatchSearch, strokes: Sequence[Stroke]) -> int | None:
    """Edges by which the fill's strands miss the strokes; None beyond the tolerance."""
    if not strokes:
        return 0
    return count_edges_off(fill, strokes, search.solver.problem.tolerance)
