"""Requests for fills and for patterns: one list of options, and of filters among them.

:class:`FillRequest` is everything that :func:`query.fills` can be asked about a boundary. The
command line, batch files, the service, its description, the client and the documentation read it.

One more filter is one more field whose annotation has a :class:`Filter`. It needs only columns that
:class:`FilterColumns` names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, Protocol

from msgspec import Meta

from patterndb.system.numbers import MOST_EDGES, TOLERANCE
from patterndb.system.requests import (
    Count,
    Positive,
    Range,
    Request,
    Seconds,
    Texts,
    Threads,
    list_options,
    option,
)
from query.errors import InvalidQueryError
from query.listing.orders import ORDERS, describe_orders

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from patterndb.core.patternclass import PatternClass
    from query.boundary import Boundary
    from query.fill import Fill
    from query.stroke import Stroke

    OrderName = str
else:
    # What the checks of a request see of a stroke; these need not wait for numpy.
    Stroke = Any
    OrderName = Literal[tuple(ORDERS)]

#: Where the patterns of fills come from.
Origin = Literal["learned", "imported", "family", "constructed"]

SolverName = Literal["kernel", "cp-sat"]

#: A valence range without vertices of two quads, which make poor meshes.
NO_DOUBLETS = (3, 10_000)

#: Irregular vertices on the boundary that a fill may have by default. With this many the complete
#: family loses no optimum.
BOUNDARY_IRREGULAR = 3

#: Fits that the orders which need geometry choose from by default.
POOL = 400

#: Fills that are listed by default.
LIMIT = 20


class FilterColumns(Protocol):
    """Columns that filters read: (r,) arrays over patterns, or the numbers of one fill."""

    @property
    def frequency(self) -> Any: ...
    @property
    def n_quads(self) -> Any: ...
    @property
    def n_loops(self) -> Any: ...
    @property
    def n_corners(self) -> Any: ...
    @property
    def min_valence(self) -> Any: ...
    @property
    def max_valence(self) -> Any: ...


#: (columns, value of the option) -> which rows pass, (r,) bool.
Test = Callable[[Any, Any], Any]


@dataclass(frozen=True, slots=True)
class Filter:
    """What an option lets pass, at each stage of a search. None lets everything pass.

    pattern: test of patterns, on :class:`FilterColumns`.
    fit: test of a pattern at a boundary, on ``n_irregular`` and ``n_irregular_boundary``.
    fill: test of a fill.
    constructed: does ``fit`` hold for constructed fills?
    without: what can be had without the filter, for the reason of an empty list; ``fill`` and
        ``value`` may be in braces. Empty: nothing is said about this filter.
    """

    pattern: Test | None = None
    fit: Test | None = None
    fill: Test | None = None
    constructed: bool = True
    without: str = ""


def _has_valences(columns: FilterColumns, valence: tuple[int, int]) -> Any:
    """Test whether all irregular vertices have a valence in the range."""
    within = (columns.min_valence >= valence[0]) & (columns.max_valence <= valence[1])
    # Without irregular vertices both bounds are 4.
    return within | ((columns.min_valence == 4) & (columns.max_valence == 4))


def _has_corners(columns: FilterColumns, corners: tuple[int, int]) -> Any:
    return (columns.n_corners >= corners[0]) & (columns.n_corners <= corners[1])


ValenceOption = Annotated[
    Annotated[tuple[Positive, Count], Meta(description="two numbers, [least, greatest]")] | None,
    option(
        "Only irregular vertices of these valences.",
        hint="write (least, greatest), such as (3, 5)",
        section="filter",
        rule=Filter(_has_valences, without="there are fills without the range of valences"),
    ),
]


class PatternFilter(Request, frozen=True, kw_only=True):
    """Options that choose patterns."""

    error = InvalidQueryError

    max_irregular: Annotated[
        Count | None,
        option(
            "Only patterns with at most K irregular vertices.",
            metavar="K",
            hint="0 asks for regular fills only",
            section="filter",
            rule=Filter(
                fit=lambda columns, most: columns.n_irregular <= most,
                without="the fewest irregular vertices that any fill has are {fill.n_irregular}, "
                "but max_irregular is {value}",
            ),
        ),
    ] = None
    max_quads: Annotated[
        Positive | None,
        option(
            "At most N quads.",
            metavar="N",
            section="filter",
            rule=Filter(
                pattern=lambda columns, most: columns.n_quads <= most,
                fill=lambda fill, most: fill.n_quads <= most,
                without="there is one of {fill.n_quads} quads, but max_quads is {value}",
            ),
        ),
    ] = None
    valence: ValenceOption = None
    pattern_corners: Annotated[
        Range | None,
        option(
            "Only patterns whose number of corners is in this range.",
            hint="write (least, greatest), such as (4, 6)",
            section="filter",
            rule=Filter(_has_corners, without="there are fills without the range of corners"),
        ),
    ] = None
    has_loop: Annotated[
        bool | None,
        option(
            "Only patterns with a loop of quads inside, or without.",
            flag="--has-loop/--no-loop",
            hint="give True, False, or None for either",
            section="filter",
            rule=Filter(
                lambda columns, wanted: (columns.n_loops > 0) == wanted,
                without="there are fills without what was asked about loops",
            ),
        ),
    ] = None
    min_frequency: Annotated[
        Positive | None,
        option(
            "Only patterns seen in at least N patches.",
            metavar="N",
            section="filter",
            rule=Filter(
                lambda columns, least: columns.frequency >= least,
                without="there are fills without the fewest patches",
            ),
        ),
    ] = None
    meshes: Annotated[
        Texts | None,
        option(
            "Only patterns that this mesh has; may be given again.",
            flag="--from-mesh",
            metavar="NAME",
            hint="give names of meshes, or None for all",
            section="filter",
        ),
    ] = None
    licences: Annotated[
        Texts | None,
        option(
            "Only patterns of meshes under this licence, * for anything; may be given again.",
            flag="--from-licence",
            metavar="LICENCE",
            hint="give licences, or None for all",
            section="filter",
        ),
    ] = None

    @property
    def filters(self) -> list[tuple[str, Filter, Any]]:
        """The filters that are in use: the option's name, the filter, the option's value."""
        return [
            (name, one.rule, value)
            for name, one in list_options(type(self)).items()
            if isinstance(one.rule, Filter) and (value := getattr(self, name)) is not None
        ]

    def admit_patterns(self, columns: FilterColumns) -> NDArray[np.bool_]:
        """(r,) bool: which patterns pass, regardless of the irregular vertices of their fills."""
        import numpy as np

        passes = np.ones(len(columns.frequency), np.bool_)
        for _, rule, value in self.filters:
            if rule.pattern is not None:
                passes &= rule.pattern(columns, value)
        return passes

    def admit_fits(self, columns: Any) -> NDArray[np.bool_]:
        """(r,) bool: which rows pass by their ``n_irregular`` and ``n_irregular_boundary``."""
        import numpy as np

        passes = np.ones(len(columns), np.bool_)
        for _, rule, value in self.filters:
            if rule.fit is not None:
                passes &= rule.fit(columns, value)
        return passes

    def choose_rows(self, patterns: PatternClass, boundary: Boundary) -> NDArray[np.int64]:
        """(r,) int64 rows, ascending, of the patterns that pass as strict fills of a boundary."""
        import numpy as np

        same_kinds = patterns.n_reflex == boundary.n_reflex
        return np.flatnonzero(
            same_kinds & self.admit_patterns(patterns) & self.admit_fits(patterns)
        )


class PatternRequest(PatternFilter, frozen=True, kw_only=True):
    """Everything that lists of patterns can be asked for."""

    n_sides: Annotated[
        Count | None,
        option("Only patterns of N sides.", flag="--class", metavar="N", section="filter"),
    ] = None
    convex: Annotated[
        bool | None,
        option(
            "Only patterns without reflex corner.",
            hint="give True, False, or None for either",
            section="filter",
            rule=Filter(lambda columns, wanted: (columns.n_reflex == 0) == wanted),
        ),
    ] = None


class ClassSource(Protocol):
    """What listing patterns needs of a database."""

    def sides_histogram(self) -> dict[int, int]: ...
    def pattern_class(self, n_sides: int) -> PatternClass: ...
    def pattern_ids(
        self,
        n_sides: int | None,
        meshes: Sequence[str] | None = None,
        licences: Sequence[str] | None = None,
    ) -> NDArray[np.int64]: ...


def choose_patterns(
    source: ClassSource, request: PatternRequest
) -> Iterator[tuple[PatternClass, NDArray[np.int64]]]:
    """Yield the classes of a database, each with the rows (r,) int64 of the patterns that pass.

    Raises NotFoundError for a mesh or a licence that the database does not have.
    """
    import numpy as np

    ids = None
    if request.meshes or request.licences:
        ids = source.pattern_ids(request.n_sides, request.meshes, request.licences)
    chosen = request.n_sides
    for n in source.sides_histogram() if chosen is None else (chosen,):
        held = source.pattern_class(n)
        passes = request.admit_patterns(held) & request.admit_fits(held)
        if ids is not None:
            passes &= np.isin(held.ids, ids)
        yield held, np.flatnonzero(passes)


class FillRequest(PatternFilter, frozen=True, kw_only=True):
    """Everything that :func:`query.fills` can be asked about a boundary."""

    strokes: Annotated[
        tuple[Stroke, ...], option("Strands that every fill has, each another one.")
    ] = ()
    tolerance: Annotated[
        Annotated[int, Meta(ge=0, le=MOST_EDGES, description="a whole number from 0")],
        option(
            "Edges by which strands may miss the strokes' ends.",
            metavar="K",
            hint="0 asks for exact strokes",
            section="filter",
        ),
    ] = TOLERANCE
    strict: Annotated[
        bool,
        option(
            "Only fills with corners exactly where the boundary's are, or others too (default).",
            flag="--strict/--relaxed",
            hint="give True or False",
            section="filter",
        ),
    ] = False
    max_boundary_irregular: Annotated[
        Count,
        option(
            "At most K irregular vertices on the boundary; constructed fills may have more.",
            metavar="K",
            hint="0 asks for strict fills only",
            section="filter",
            rule=Filter(
                fit=lambda columns, most: columns.n_irregular_boundary <= most, constructed=False
            ),
        ),
    ] = BOUNDARY_IRREGULAR
    valence: ValenceOption = NO_DOUBLETS
    origins: Annotated[
        tuple[Origin, ...] | None,
        option(
            "No fills but of patterns that the database holds.",
            flag="--learned-only",
            constant=("learned", "imported"),
            hint="choose of learned, imported, family, constructed",
            section="filter",
            rule=Filter(
                fill=lambda fill, origins: fill.origin in origins,
                without="there are fills of patterns that the database does not hold",
            ),
        ),
    ] = None
    order: Annotated[
        OrderName | None,
        option(describe_orders(), section="order"),
    ] = None
    use_counts: Annotated[
        bool,
        option(
            "Let recorded uses count like patches of meshes.",
            hint="give True or False",
            section="order",
        ),
    ] = False
    pattern: Annotated[
        Annotated[str, Meta(pattern="^[0-9a-fA-F]{2,16}$")] | None,
        option(
            "Only fills of this pattern, by the first digits of its name: all its variants.",
            metavar="NAME",
            hint="give 2 to 16 hexadecimal digits",
            section="order",
        ),
    ] = None
    per_pattern: Annotated[
        Positive | None,
        option("List at most N fills of one pattern.", metavar="N", section="order"),
    ] = None
    limit: Annotated[Positive | None, option("List at most N fills.", metavar="N")] = LIMIT
    time_limit: Annotated[
        Seconds | None,
        option(
            "Stop after this many seconds, with what was found.",
            metavar="SECONDS",
            hint="give seconds above 0, at most 1,000,000",
        ),
    ] = None
    pool: Annotated[
        Positive, option("Fits that the orders which need geometry choose from.", metavar="N")
    ] = POOL
    solver: Annotated[
        SolverName,
        option(
            "What finds the widths.",
            hint='there are "kernel" and "cp-sat"',
            section="search",
        ),
    ] = "kernel"
    threads: Annotated[
        Threads | None,
        option("Threads; one a core.", flag="--jobs", metavar="N", section="search"),
    ] = None

    def wants(self, origin: Origin) -> bool:
        """May fills have this origin?"""
        return self.origins is None or origin in self.origins


def admits(
    filters: Iterable[tuple[str, Filter, Any]],
    fill: Fill,
    columns: FilterColumns | None = None,
) -> bool:
    """Return whether a fill passes filters.

    filters: those in use, :attr:`PatternFilter.filters`.
    columns: those of a constructed fill, which has passed no earlier test.
    """
    for _, rule, value in filters:
        if rule.fill is not None and not rule.fill(fill, value):
            return False
        if columns is None:
            continue
        if rule.pattern is not None and not rule.pattern(columns, value):
            return False
        if rule.fit is not None and rule.constructed and not rule.fit(fill, value):
            return False
    return True
