"""Why a list of fills is empty: what no database could fill, and what this one does not hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations, islice

from patterndb.system.requests import list_options
from query.boundary import Boundary
from query.fill import Fill
from query.listing.matches import PreparedQuery, Ranking, list_rows
from query.listing.table import get_strict_table
from query.request import FillRequest, PatternFilter

#: Quads around an interior vertex are at least two: with one, it would meet itself.
LEAST_VALENCE = 2


#: Groups of as many strokes that are tried where no fill has all.
MOST_GROUPS = 10

#: Finds the most regular fill of a query; returns it, and whether it is known that there is none.
FindFill = Callable[[PreparedQuery], tuple[Fill | None, bool]]


def explain_empty(query: PreparedQuery, find_fill: FindFill) -> str:
    """Return one sentence: why a query has no fill.

    find_fill: searches for fills of less strict queries, until time is up.
    """
    request, boundary, patterns = query.request, query.boundary, query.patterns
    strict = request.strict or request.max_boundary_irregular == 0
    impossible = explain_impossible(boundary, request) if strict else None
    if impossible:
        return impossible
    sides = _sides(boundary)
    if request.strokes:
        n_strokes = len(request.strokes)
        together = _find_compatible_strokes(query, find_fill) if n_strokes > 1 else []
        return (
            f"no fill has strands on all the strokes{_list_groups(together, n_strokes)}; allow a "
            "greater tolerance, leave a stroke out, or split the boundary along one"
        )
    relaxed = " and ".join(_list_relaxed(query, find_fill))
    if not strict:
        return f"no fill passes the filters; {relaxed or 'relax them'}"
    if len(patterns) == 0:
        return (
            f"the database has no pattern with {sides}; learn from more meshes, or let corners "
            "fall elsewhere (relaxed matching)"
        )
    n_candidates = len(list_rows(query, get_strict_table(patterns), Ranking(False, False)))
    if n_candidates == 0:
        return (
            f"none of the {len(patterns)} patterns with {sides} has these corners and passes the "
            f"filters; {relaxed or 'relax the filters or learn from more meshes'}"
        )
    lengths = ", ".join(map(str, boundary.lengths))
    return (
        f"none of the {n_candidates} patterns with {sides} that pass fits the lengths {lengths}; "
        f"{relaxed or 'change the lengths, or learn from more meshes'}"
    )


def _find_compatible_strokes(
    query: PreparedQuery, find_fill: FindFill
) -> list[tuple[int, ...]] | None:
    """Find large groups of strokes, by their numbers from 0, that a fill has; all as large.

    Empty where no stroke alone has a fill; None where that is not known when time is up.
    """
    strokes = query.request.strokes

    def find_with(group: tuple[int, ...]) -> tuple[Fill | None, bool]:
        return find_fill(query.change(strokes=tuple(strokes[number] for number in group)))

    alone = [find_with((number,)) for number in range(len(strokes))]
    usable = [number for number, (fill, _) in enumerate(alone) if fill is not None]
    # A fill of several strokes is one of each of them.
    for size in range(min(len(usable), len(strokes) - 1), 1, -1):
        groups = islice(combinations(usable, size), MOST_GROUPS)
        found = [group for group in groups if find_with(group)[0] is not None]
        if found:
            return found
    if not usable and not all(is_known for _, is_known in alone):
        return None
    return [(number,) for number in usable]


def _list_relaxed(query: PreparedQuery, find_fill: FindFill) -> list[str]:
    """List the fills that exist without one of the filters, for each that alone excludes them."""
    found: list[str] = []
    for name, rule, value in query.request.filters:
        free = list_options(FillRequest)[name].default
        if not rule.without or value == free:
            continue
        fill, _ = find_fill(query.change(**{name: free}))
        if fill is not None:
            found.append(rule.without.format(fill=fill, value=value))
    if query.ids is not None and find_fill(replace(query, ids=None))[0] is not None:
        found.append("there are fills without the choice of meshes and licences")
    return found


def _list_groups(together: Sequence[tuple[int, ...]] | None, strokes: int) -> str:
    """What of the strokes goes together, as the part of a sentence."""
    if together is None:
        return " (time was up before it was known which of them go together)"
    if not together:
        return ", nor on any one of them" if strokes > 1 else ""
    groups = ", and with ".join(
        " and ".join(str(number + 1) for number in group) for group in together
    )
    alone = " alone" if len(together[0]) == 1 else ""
    return f", but there are fills with {groups}{alone}, counted as they were given"


def explain_impossible(boundary: Boundary, filters: PatternFilter) -> str | None:
    """Why no strict fill exists at all, or None where nothing forbids one.

    Only what can be proved of every quad mesh is said. None is no promise of a fill.
    """
    return _short_side(boundary) or _too_few_irregular(boundary, filters)


def _short_side(boundary: Boundary) -> str | None:
    # At both ends of such a side lies the same quad. Peeled off, it leaves a side of
    # length 1 between neighbours one shorter, until one of them is used up: the quad at its
    # corner then has only boundary edges, so that all was a 1 by n rectangle.
    if not boundary.convex or boundary.n_sides in (0, 4) or 1 not in boundary.lengths:
        return None
    side = boundary.lengths.index(1)
    return (
        f"side {side} has length 1: between convex corners that has a strict fill only where "
        f"there are 4 sides, not {boundary.n_sides}; give it length 2"
    )


def _too_few_irregular(boundary: Boundary, filters: PatternFilter) -> str | None:
    """Gauss-Bonnet: convex corners - reflex corners + sum over interior (4 - valence) = 4."""
    missing = 4 - sum(2 - count for count in boundary.corner_counts)
    if missing == 0:
        return None
    least, greatest = filters.valence or (LEAST_VALENCE, boundary.perimeter)
    each = 4 - max(least, LEAST_VALENCE) if missing > 0 else greatest - 4
    kind = "below" if missing > 0 else "above"
    turn = (
        f"{_sides(boundary)} ask for irregular vertices whose valences are {abs(missing)} "
        f"{kind} 4 in sum"
    )
    if each <= 0:
        return f"{turn}, and the valences allowed are {least} to {greatest}; widen the range"
    needed = -(-abs(missing) // each)
    if filters.valence is None and missing < 0:
        # Nothing bounds one valence from above: one vertex may do it all.
        needed = 1
    if filters.max_irregular is not None and needed > filters.max_irregular:
        return f"{turn}: at least {needed}, but max_irregular is {filters.max_irregular}"
    return None


def _sides(boundary: Boundary) -> str:
    if boundary.n_sides == 0:
        return "one closed side"
    reflex = boundary.n_reflex
    sides = "1 side" if boundary.n_sides == 1 else f"{boundary.n_sides} sides"
    return f"{sides}, {reflex} of their corners reflex," if reflex else sides
