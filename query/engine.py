"""Ask for the fills of a boundary: the way from a question to fills, best first.

The width problem is stated (:mod:`query.solving.problem`), tables of patterns are
searched in lanes (:mod:`query.listing.matches`), and a stream merges what the lanes find
(:mod:`query.listing.fills`). A boundary for which no table has anything is constructed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from time import perf_counter
from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from patterndb.core.patternclass import PatternClass
from patterndb.errors import NotFoundError
from patterndb.system.deadline import end_by
from patterndb.system.requests import make_request
from query.boundary import Boundary
from query.errors import InvalidQueryError
from query.fill import Fill
from query.listing.fills import Fills
from query.listing.matches import PreparedQuery
from query.listing.orders import ORDERS, FillOrder, default_order
from query.request import FillRequest

#: What is left of a time limit at least once the class is read: the list then ends at once.
LEAST_SECONDS = 1e-9

#: Hexadecimal digits of a whole name of a pattern.
NAME_DIGITS = 16


class PatternSource(Protocol):
    """What a query needs of a database."""

    def pattern_class(self, n_sides: int) -> PatternClass: ...


def fills(
    source: PatternSource | PatternClass,
    boundary: Boundary | Iterable[int],
    request: FillRequest | None = None,
    **options: Any,
) -> Fills:
    """Find the fills of a boundary, best first, as an iterator that finds them as it goes.

    source: a database, or one class of patterns. boundary: a Boundary, or the lengths of
    sides between convex corners.
    request: what is asked; see :class:`query.request.FillRequest`.
    options: entries of the request, in place of a request or of some of its entries.

    Every rotation and mirror image is tried, less those that a pattern's own symmetries
    make equal, and no fill is listed twice. With ``per_pattern=1`` every fill has another pattern,
    and :meth:`query.listing.fills.Fills.variants` lists the others of each. The time limit
    includes reading the class; a list that is still empty when it ends takes a fill that comes
    easily, if there is one. The list does not depend on the number of threads.

    Raises InvalidBoundaryError for lengths that are no boundary, InvalidQueryError for strokes
    that do not end on it, options that are not valid and those that the source cannot answer, and
    NotFoundError for names of patterns and meshes that it does not have.

    >>> square = Pattern.from_code(np.zeros(4, np.uint16))
    >>> next(fills(PatternClass.from_patterns(4, [square]), (3, 2, 3, 2))).n_quads
    6
    """
    asked = make_request(FillRequest, request, options)
    if not isinstance(boundary, Boundary):
        boundary = Boundary(boundary)
    if "full" in boundary.corners and not asked.strict:
        raise InvalidQueryError(
            "a full corner, with four quads, has strict fills only; ask strict=True"
        )
    for stroke in asked.strokes:
        stroke.refuse_unless_on(boundary)
    order = _choose_order(asked, boundary)
    limit = asked.time_limit
    begin = perf_counter()
    ids = None
    # A database's statements end with the time limit as well; then it raises TimeLimitError.
    with end_by(begin + (math.inf if limit is None else limit)):
        patterns = _class_for(source, boundary)
        if asked.meshes is not None or asked.licences is not None:
            # A relaxed fill's pattern may have another number of sides.
            ids = _ids_of(source, boundary.n_sides if asked.strict else None, asked)
        named = asked.pattern
        only = None if named is None else frozenset((_identify_pattern(source, named),))
    if limit is not None:
        limit = max(limit - (perf_counter() - begin), LEAST_SECONDS)
    if asked.strict or limit != asked.time_limit:
        most = 0 if asked.strict else asked.max_boundary_irregular
        asked = msgspec.structs.replace(asked, max_boundary_irregular=most, time_limit=limit)
    frequencies = getattr(source, "frequencies", None)
    return Fills(PreparedQuery(asked, boundary, order, patterns, frequencies, ids, only))


def _choose_order(asked: FillRequest, boundary: Boundary) -> FillOrder:
    """Return the order that is asked for, or the default; it must suit boundary and strokes."""
    points = boundary.points is not None
    drawn = points and any(s.points is not None for s in asked.strokes)
    chosen = ORDERS[asked.order or default_order(points=points, drawn=drawn)]
    if not chosen.is_usable(points=points, strokes=drawn):
        usable = [o.name for o in ORDERS.values() if o.is_usable(points=points, strokes=drawn)]
        raise InvalidQueryError(
            f'order="{chosen.name}" needs {chosen.needs}; without them there are '
            + ", ".join(usable)
        )
    return chosen


def best(
    source: PatternSource | PatternClass,
    boundary: Boundary | Iterable[int],
    request: FillRequest | None = None,
    **options: Any,
) -> Fill | None:
    """Return the first of :func:`fills`, or None; the options are the same."""
    return next(fills(source, boundary, request, **{"limit": 1, **options}), None)


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
    source: PatternSource | PatternClass, n_sides: int | None, asked: FillRequest
) -> NDArray[np.int64]:
    """Return the ids of patterns of the meshes and licences that are asked for."""
    ask = getattr(source, "pattern_ids", None)
    if ask is None:
        raise InvalidQueryError("meshes and licences are known to databases only; ask one")
    return ask(n_sides, asked.meshes, asked.licences)


def _identify_pattern(source: PatternSource | PatternClass, name: str) -> int:
    """Return the id of the pattern whose name begins so.

    A whole name may be of a pattern that the source does not hold.
    """
    if len(name) == NAME_DIGITS:
        number = int(name, 16)
        if number >= 2**63:
            raise NotFoundError(f"no pattern's name begins with {name}")
        return number
    find = getattr(source, "pattern", None)
    if find is None or isinstance(source, PatternClass):
        raise InvalidQueryError(
            f"first digits of names are known to databases only; give all {NAME_DIGITS} digits"
        )
    return find(name).id
