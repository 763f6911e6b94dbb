"""Ask for the fills of a boundary: the way from a question to fills, best first.

The question is put in the patterns' terms (:mod:`query.solving.batch`), tables of patterns are
searched in lanes (:mod:`query.listing.lane`), and a stream merges what the lanes find
(:mod:`query.listing.stream`). A boundary for which no table has anything is constructed.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from time import perf_counter
from typing import Literal, Protocol

import numpy as np

from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.system.deadline import end_by
from patterndb.system.numbers import MOST_EDGES
from query.boundary import Boundary
from query.errors import InvalidQueryError, refuse_large
from query.fill import Fill
from query.listing.filters import NO_DOUBLETS, Filters, Range
from query.listing.orders import ORDERS, default_order
from query.listing.stream import Fills, Query
from query.stroke import TOLERANCE, Stroke

SolverName = Literal["kernel", "cp-sat"]

#: Where the patterns of fills come from.
Origin = Literal["learned", "imported", "family", "constructed"]

#: Irregular vertices on the boundary that a fill may have unless told otherwise. With this many
#: the complete family loses no optimum.
BOUNDARY_IRREGULAR = 3

#: Fits that the orders which need geometry, or the whole list, choose from.
POOL = 400

#: What is left of a time limit at least once the class is read: the list then ends at once.
LEAST_SECONDS = 1e-9


class PatternSource(Protocol):
    """What a query needs of a database."""

    def pattern_class(self, n_sides: int) -> PatternClass: ...


def fills(
    source: PatternSource | PatternClass,
    boundary: Boundary | Iterable[int],
    *,
    strokes: Sequence[Stroke] = (),
    tolerance: int = TOLERANCE,
    limit: int | None = 20,
    per_pattern: int | None = None,
    order: str | None = None,
    strict: bool = False,
    max_boundary_irregular: int = BOUNDARY_IRREGULAR,
    max_irregular: int | None = None,
    valence: Range | None = NO_DOUBLETS,
    max_quads: int | None = None,
    corners: Range | None = None,
    has_loop: bool | None = None,
    min_frequency: int | None = None,
    meshes: Sequence[str] | None = None,
    licences: Sequence[str] | None = None,
    origins: Collection[Origin] | None = None,
    pattern: Pattern | int | None = None,
    use_counts: bool = False,
    time_limit: float | None = None,
    pool: int = POOL,
    solver: SolverName = "kernel",
    threads: int | None = None,
) -> Fills:
    """Find the fills of a boundary, best first, as an iterator that finds them as it goes.

    source: a database, or one class of patterns. boundary: a Boundary, or the lengths of
    sides between convex corners.

    strokes: strands that every fill shall have, each its own; see :class:`query.stroke.Stroke`.
    tolerance: edges that a strand's end may be off its stroke's.
    limit: the most fills; per_pattern: the most of one pattern; None is no limit (the fills of
    long sides run into millions). With per_pattern=1 every fill is another idea, and
    :meth:`query.listing.stream.Fills.variants` lists what was left out under it.
    time_limit: seconds after which the list ends, those for reading the class included, and all
    that is asked of it afterwards. A list that is still empty then takes a fill that comes
    easily, if there is one.
    pool: orders that measure fills, all but "artist" and "regular", sort the first so many fills
    of "artist".
    order: the name of one of :data:`query.listing.orders.ORDERS`, see docs; None is "flow" where
    boundary and strokes have points, and "artist" elsewhere.
    strict: only fills whose corners are where the boundary's are. Else corners may lie
    elsewhere (relaxed matching), each such place counting as an irregular vertex of the
    boundary, of which a fill has at most max_boundary_irregular, unless it is constructed.
    max_irregular, valence, max_quads, corners, has_loop, min_frequency: see
    :class:`query.listing.filters.Filters`; by default interior vertices have at least 3 quads.
    meshes, licences: only patterns that were learned from such meshes, see
    :meth:`patterndb.store.Database.pattern_ids`; source must be a database.
    origins: only fills of these origins. pattern: only fills of this pattern, or of the one
    with this id. use_counts: let recorded uses of a pattern count
    like patches that were seen. solver: "kernel", or "cp-sat" for the same fills, slowly, from
    OR-Tools. threads: at most so many (default: one a processor); the list does not depend
    on it.

    Every rotation and mirror image is tried, less those that a pattern's own symmetries
    make equal, and no fill is listed twice. Raises InvalidBoundaryError for lengths that
    are no boundary and InvalidQueryError for strokes that do not end on it and options that
    ask for nothing.

    >>> square = Pattern.from_code(np.zeros(4, np.uint16))
    >>> next(fills(PatternClass.from_patterns(4, [square]), (3, 2, 3, 2))).n_quads
    6
    """
    for name, value in (
        ("limit", limit),
        ("per_pattern", per_pattern),
        ("threads", threads),
        ("pool", pool),
    ):
        if value is not None and value < 1:
            raise InvalidQueryError(f"{name} is {value}; the least is 1, None leaves it open")
        if value is not None:
            refuse_large(name, value)
    if time_limit is not None and not time_limit > 0:
        raise InvalidQueryError(f"time_limit is {time_limit}; give seconds above 0")
    if tolerance < 0:
        raise InvalidQueryError(f"tolerance is {tolerance}; 0 asks for exact strokes")
    refuse_large("tolerance", tolerance, MOST_EDGES)
    if order is not None and order not in ORDERS:
        raise InvalidQueryError(f"order is {order!r}; there are {', '.join(ORDERS)}")
    if solver not in ("kernel", "cp-sat"):
        raise InvalidQueryError(f'solver is {solver!r}; there are "kernel" and "cp-sat"')
    if not isinstance(boundary, Boundary):
        boundary = Boundary(boundary)
    if "full" in boundary.corners and not strict:
        raise InvalidQueryError(
            "a full corner, with four quads, has strict fills only; ask strict=True"
        )
    for stroke in strokes:
        stroke.refuse_unless_on(boundary)
    points = boundary.points is not None
    drawn = points and any(s.points is not None for s in strokes)
    chosen = ORDERS[order or default_order(points=points, drawn=drawn)]
    if not chosen.is_usable(points=points, strokes=drawn):
        usable = [o.name for o in ORDERS.values() if o.is_usable(points=points, strokes=drawn)]
        raise InvalidQueryError(
            f'order="{chosen.name}" needs {chosen.needs}; without them there are '
            + ", ".join(usable)
        )
    begin = perf_counter()
    ids = None
    # A database's statements end with the time limit as well; then it raises TimeLimitError.
    with end_by(begin + (math.inf if time_limit is None else time_limit)):
        patterns = _class_for(source, boundary)
        if meshes is not None or licences is not None:
            # A relaxed fill's pattern may have another number of sides.
            ids = _ids_of(source, boundary.n_sides if strict else None, meshes, licences)
    if time_limit is not None:
        time_limit = max(time_limit - (perf_counter() - begin), LEAST_SECONDS)
    return Fills(
        Query(
            patterns=patterns,
            frequencies=getattr(source, "frequencies", None),
            boundary=boundary,
            strokes=tuple(strokes),
            tolerance=tolerance,
            limit=limit,
            per_pattern=per_pattern,
            order=chosen,
            filters=Filters(
                max_irregular=max_irregular,
                valence=valence,
                max_quads=max_quads,
                corners=corners,
                has_loop=has_loop,
                min_frequency=min_frequency,
                max_boundary_irregular=0 if strict else max_boundary_irregular,
                ids=ids,
                only=None if pattern is None else frozenset((_id_of(pattern),)),
            ),
            strict=strict,
            origins=None if origins is None else frozenset(origins),
            use_counts=use_counts,
            time_limit=time_limit,
            pool=pool,
            by_cpsat=solver == "cp-sat",
            threads=threads,
        )
    )


def best(
    source: PatternSource | PatternClass,
    boundary: Boundary | Iterable[int],
    **options: object,
) -> Fill | None:
    """The first of :func:`fills`, or None; the options are the same."""
    options = {"limit": 1, **options}
    return next(fills(source, boundary, **options), None)  # pyright: ignore[reportArgumentType]


def _id_of(pattern: Pattern | int) -> int:
    return pattern.id if isinstance(pattern, Pattern) else pattern


def _class_for(source: PatternSource | PatternClass, boundary: Boundary) -> PatternClass:
    if not isinstance(source, PatternClass):
        return source.pattern_class(boundary.n_sides)
    if source.n_sides != boundary.n_sides:
        raise InvalidQueryError(
            f"these are patterns of {source.n_sides} sides, but the boundary has "
            f"{boundary.n_sides}; pass the class of {boundary.n_sides} sides, or a database"
        )
    return source


def _ids_of(
    source: PatternSource | PatternClass,
    n_sides: int | None,
    meshes: Sequence[str] | None,
    licences: Sequence[str] | None,
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    ask = getattr(source, "pattern_ids", None)
    if ask is None:
        raise InvalidQueryError("meshes and licences are known to databases only; ask one")
    return ask(n_sides, meshes, licences)
