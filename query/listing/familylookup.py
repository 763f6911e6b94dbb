"""The complete family as the table in which constructions look up their parts."""

from __future__ import annotations

from functools import cache, lru_cache

from query.boundary import Boundary
from query.construct.lookup import PartFill
from query.marks.bestmarked import BOUNDARY_CAP, BestMarked, best_marked, family_index
from query.marks.expandmarked import expand_marked

#: Sides up to which the family has marked patterns worth looking through.
MOST_SIDES = 8

#: Boundaries whose answers are kept: constructions ask for the same parts many times.
KEPT = 65_536


class FamilyLookup:
    """Best fills of boundaries with 2 to 8 sides; see :class:`query.construct.lookup.Lookup`."""

    max_sides = MOST_SIDES

    def __init__(self) -> None:
        self._found = lru_cache(maxsize=KEPT)(self._find)

    @staticmethod
    @cache
    def shared() -> FamilyLookup:
        """The one that all queries use."""
        return FamilyLookup()

    def count(self, boundary: Boundary, *, strict: bool = False) -> int | None:
        found = self._found(boundary, strict)
        return None if found is None else found.n_irregular

    def best(self, boundary: Boundary, *, strict: bool = False) -> PartFill | None:
        found = self._found(boundary, strict)
        if found is None:
            return None
        marked = family_index(boundary.n_sides).marked
        got = expand_marked(marked, found.row, found.strand_widths, found.orientation)
        return PartFill(got.quads, found.n_irregular)

    def _find(self, boundary: Boundary, strict: bool) -> BestMarked | None:
        index = family_index(boundary.n_sides)
        # Each reflex corner may cost one more than the marks of a convex boundary do.
        most = index.marked.most + boundary.corners.count("reflex")
        return best_marked(index, boundary, cap=0 if strict else BOUNDARY_CAP, most=most)
