"""Why a list of fills is empty: what no database could fill, and what this one does not hold."""

from __future__ import annotations

from collections.abc import Sequence

from patterndb.core.patternclass import PatternClass
from query.boundary import Boundary
from query.request import PatternFilter

#: Quads around an interior vertex are at least two: with one, it would meet itself.
LEAST_VALENCE = 2


def explain_empty(
    patterns: PatternClass,
    boundary: Boundary,
    filters: PatternFilter,
    n_candidates: int,
    *,
    strict: bool,
    strokes: int,
    together: Sequence[tuple[int, ...]] | None = (),
    relaxed: Sequence[str] = (),
) -> str:
    """Return one sentence. n_candidates: patterns of the class that pass the filters. strokes: how
    many were asked for. together: those, by their numbers from 0, that some fill has together; None
    where time was up before that was known. relaxed: the fills that exist without one of the
    filters, a part of a sentence each."""
    impossible = explain_impossible(boundary, filters) if strict else None
    if impossible:
        return impossible
    sides = _sides(boundary)
    if strokes:
        return (
            f"no fill has strands on all the strokes{_list_groups(together, strokes)}; allow a "
            "greater tolerance, leave a stroke out, or split the boundary along one"
        )
    if not strict:
        return f"no fill passes the filters; {' and '.join(relaxed) or 'relax them'}"
    if len(patterns) == 0:
        return (
            f"the database has no pattern with {sides}; learn from more meshes, or let corners "
            "fall elsewhere (relaxed matching)"
        )
    if n_candidates == 0:
        mend = " and ".join(relaxed) or "relax the filters or learn from more meshes"
        return (
            f"none of the {len(patterns)} patterns with {sides} has these corners and passes the "
            f"filters; {mend}"
        )
    lengths = ", ".join(map(str, boundary.lengths))
    return (
        f"none of the {n_candidates} patterns with {sides} that pass fits the lengths {lengths}; "
        + (" and ".join(relaxed) or "change the lengths, or learn from more meshes")
    )


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
