"""Ask for the fills of a boundary.

Patterns come in the class's order, fewest irregular vertices first, then most frequent,
then smallest id (Marcias et al. 2015, section 5, "Sorting criteria"); the fills of one
pattern in the order of :mod:`query.fit`. Only the fills that are listed are expanded.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, overload

import numpy as np
from numpy.typing import NDArray

from patterndb.pattern import Pattern
from patterndb.patternclass import PatternClass
from query import feasibility, solve
from query.boundary import Boundary
from query.errors import InvalidQueryError
from query.fill import Fill
from query.filters import Filters
from query.fit import Fit, fits
from query.identity import fill_key, is_mesh
from query.reason import why_empty
from query.solve import Solver

SolverName = Literal["kernel", "cp-sat"]


class PatternSource(Protocol):
    """What a query needs of a database."""

    def pattern_class(self, n_sides: int) -> PatternClass: ...


@dataclass(frozen=True, slots=True)
class FillList(Sequence[Fill]):
    """The answer to a query: a sequence of fills, best first.

    fills:     the fills, as many as were asked for.
    boundary:  the boundary they fill.
    feasible_patterns: how many patterns pass the filters and can meet the lengths.
    truncated: are there more fills than are listed, by either limit?
    seconds:   how long the query took.
    reason:    why there is none, where there is none.
    """

    fills: tuple[Fill, ...]
    boundary: Boundary
    feasible_patterns: int
    truncated: bool
    seconds: float
    reason: str | None

    def __len__(self) -> int:
        return len(self.fills)

    @overload
    def __getitem__(self, index: int) -> Fill: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Fill, ...]: ...
    def __getitem__(self, index: int | slice) -> Fill | tuple[Fill, ...]:
        return self.fills[index]


def fills(
    source: PatternSource | PatternClass,
    boundary: Boundary | Iterable[int],
    *,
    limit: int | None = 20,
    max_irregular: int | None = None,
    valence: tuple[int, int] | None = None,
    per_pattern: int | None = 4,
    solver: SolverName = "kernel",
    threads: int | None = None,
) -> FillList:
    """All strict fills of a boundary that the patterns hold, best first.

    source: a database, or one class of patterns. boundary: a Boundary, or the lengths of
    sides between convex corners. limit: the most fills; per_pattern: the most of one
    pattern; None is no limit (the fills of long sides run into millions).
    max_irregular, valence: see :class:`query.filters.Filters`. solver: "kernel", or
    "cp-sat" for the same answer, slowly, from OR-Tools. threads: at most so many (default:
    one a processor); the answer does not depend on it.

    Every rotation and mirror image is tried, less those that a pattern's own symmetries
    make equal, and no fill is listed twice. Raises InvalidBoundaryError for lengths that
    are no boundary and InvalidQueryError for options that ask for nothing.

    >>> square = Pattern.from_code(np.zeros(4, np.uint16))
    >>> fills(PatternClass.from_patterns(4, [square]), (3, 2, 3, 2))[0].n_quads
    6
    """
    begin = time.perf_counter()
    for name, value in (("limit", limit), ("per_pattern", per_pattern), ("threads", threads)):
        if value is not None and value < 1:
            raise InvalidQueryError(f"{name} is {value}; the least is 1, None leaves it open")
    if not isinstance(boundary, Boundary):
        boundary = Boundary(boundary)
    filters = Filters(max_irregular, valence)
    patterns = _class_for(source, boundary)
    feasible_rows, widths = _solver(solver)
    candidates = filters.rows(patterns, boundary)
    rows = feasible_rows(patterns, boundary, candidates, threads=threads)
    listed, truncated = _take(patterns, rows, boundary, limit, per_pattern, widths)
    return FillList(
        fills=tuple(listed),
        boundary=boundary,
        feasible_patterns=len(rows),
        truncated=truncated,
        seconds=time.perf_counter() - begin,
        reason=None if listed else why_empty(patterns, boundary, filters, len(candidates)),
    )


def best(
    source: PatternSource | PatternClass,
    boundary: Boundary | Iterable[int],
    *,
    max_irregular: int | None = None,
    valence: tuple[int, int] | None = None,
    solver: SolverName = "kernel",
    threads: int | None = None,
) -> Fill | None:
    """The first of :func:`fills`, or None."""
    found = fills(
        source,
        boundary,
        limit=1,
        per_pattern=1,
        max_irregular=max_irregular,
        valence=valence,
        solver=solver,
        threads=threads,
    )
    return found[0] if found else None


def _class_for(source: PatternSource | PatternClass, boundary: Boundary) -> PatternClass:
    if not isinstance(source, PatternClass):
        return source.pattern_class(boundary.n_sides)
    if source.n_sides != boundary.n_sides:
        raise InvalidQueryError(
            f"these are patterns of {source.n_sides} sides, but the boundary has "
            f"{boundary.n_sides}; pass the class of {boundary.n_sides} sides, or a database"
        )
    return source


def _solver(name: SolverName) -> tuple[Callable[..., NDArray[np.int64]], Solver]:
    """(which rows of a class fit, solutions of one system) of the solver of that name."""
    if name == "kernel":
        return feasibility.feasible_rows, solve.solutions
    if name == "cp-sat":
        from query import cpsat

        return cpsat.feasible_rows, cpsat.solutions
    raise InvalidQueryError(f'solver is {name!r}; there are "kernel" and "cp-sat"')


def _take(
    patterns: PatternClass,
    rows: NDArray[np.int64],
    boundary: Boundary,
    limit: int | None,
    per_pattern: int | None,
    widths: Solver,
) -> tuple[list[Fill], bool]:
    """The fills to list, and whether there are more."""
    listed: list[Fill] = []
    seen: set[bytes] = set()
    truncated = False
    for row in rows.tolist():
        pattern = patterns.pattern(row)
        room = None if limit is None else limit - len(listed)
        if room == 0:
            # A fill beyond the last one listed, if it is no copy of one, is one too many.
            if _new_fills(pattern, boundary, 1, widths, seen)[0]:
                return listed, True
            continue
        most = min((n for n in (room, per_pattern) if n is not None), default=None)
        new, more = _new_fills(pattern, boundary, most, widths, seen)
        listed += new
        truncated = truncated or more
    return listed, truncated


def _new_fills(
    pattern: Pattern, boundary: Boundary, most: int | None, widths: Solver, seen: set[bytes]
) -> tuple[list[Fill], bool]:
    """At most that many fills of a pattern that are not listed yet, and whether it has more."""
    if not pattern.self_crossing and is_mesh(pattern.disk().quads):
        found, more = fits(pattern, boundary, most, widths)
        return [fit.fill(pattern) for fit in found], more
    ask = None if most is None else most + 1
    while True:
        found, more = fits(pattern, boundary, ask, widths)
        new = dict(_unseen(pattern, found, seen))
        if ask is None or most is None or len(new) > most or not more:
            break
        ask *= 2
    kept = list(new.items())[:most]
    seen.update(key for key, _ in kept)
    return [fill for _, fill in kept], len(new) > len(kept)


def _unseen(pattern: Pattern, found: list[Fit], seen: set[bytes]) -> Iterator[tuple[bytes, Fill]]:
    """The fits whose fills are meshes and new, under their keys, once each."""
    mine: set[bytes] = set()
    for fit in found:
        fill = fit.fill(pattern)
        if not is_mesh(fill.quads):
            continue
        key = fill_key(fill)
        if key not in seen and key not in mine:
            mine.add(key)
            yield key, fill
