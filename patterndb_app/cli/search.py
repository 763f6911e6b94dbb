"""The options of verbs that search for fills, and the search that they ask for."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol

import click

from patterndb.errors import NotFoundError
from patterndb.system.deadline import get_deadline, is_late
from patterndb.system.extras import require_extra
from patterndb.system.requests import list_options
from patterndb_app.cli.options import (
    Count,
    F,
    Parsed,
    list_flags,
    read_options,
    request_options,
    time_limit_option,
)
from patterndb_app.cli.program import name_options
from patterndb_app.cli.text import plural
from query.request import FillRequest

if TYPE_CHECKING:
    from patterndb.store import Database, DatabaseUnion, MemberOccurrence
    from patterndb_app.client.remote import RemoteDatabase, RemoteFills
    from query import Boundary, Fill, Fills, Stroke
    from query.stroke import BoundaryEdge

#: What --corners takes for each kind.
KINDS = {"c": "convex", "convex": "convex", "r": "reflex", "reflex": "reflex"}


def _parse_corners(text: str) -> tuple[str, ...]:
    words = [word.strip().lower() for word in text.split(",")]
    for word in words:
        if word not in KINDS:
            raise ValueError(f"{word!r} is no corner; write c for convex or r for reflex")
    return tuple(KINDS[word] for word in words)


#: Kinds of corners with commas between: c,c,r,c.
CORNERS = Parsed("c,c,r,...", _parse_corners, has_commas=True)


def _parse_flow(text: str) -> tuple[BoundaryEdge, BoundaryEdge]:
    match = re.fullmatch(r"([0-9]{1,6}):([0-9]{1,6})-([0-9]{1,6}):([0-9]{1,6})", text.strip())
    if not match:
        raise ValueError(
            f"{text!r} is no stroke like 0:2-3:1, from edge 2 of side 0 to edge 1 of side 3"
        )
    a, i, b, j = map(int, match.groups())
    return (a, i), (b, j)


#: A stroke from edge i of side a to edge j of side b: a:i-b:j.
FLOW = Parsed("a:i-b:j", _parse_flow)


folded_option = click.option(
    "--folded/--flat",
    default=None,
    help="One fill of each pattern, its variants counted, or every fill in its place.  [default: "
    "folded; flat with --pattern and --per-pattern]",
)

_per_pattern_option = click.option(
    "--per-pattern",
    type=Count(),
    default=0,
    metavar="N",
    help="List at most N fills of one pattern, with --flat; 0 for all.  [default: 0]",
)

#: The options of a request that the command line has in other forms.
_OWN = ("per_pattern",)

#: The sections of the help that these options are in.
FILTER_OPTIONS = list_flags(FillRequest, "filter")
ORDER_OPTIONS = ("--folded", *list_flags(FillRequest, "order"))
SEARCH_OPTIONS = ("--time-limit", *list_flags(FillRequest, "search"))


def search_options(verb: F) -> F:
    """Give a verb the options that :func:`read_search` understands."""
    every = list_options(FillRequest)
    names = [name for name, one in every.items() if one.text.section and name not in _OWN]
    for add in (time_limit_option, _per_pattern_option, folded_option):
        verb = add(verb)
    return request_options(FillRequest, *names)(verb)


@dataclass(frozen=True, slots=True)
class AskedFills:
    """A request of the command line. folded: is one fill of each pattern listed?"""

    request: FillRequest
    folded: bool = True

    def find(
        self, source: Database | DatabaseUnion | RemoteDatabase, boundary: Boundary, **options: Any
    ) -> Fills | RemoteFills:
        """Find fills as :func:`query.fills`; the time limit is the thread's deadline.

        source: a database, several as one, or one of a service. options: in place of those of the
        request.
        """
        from patterndb.store import Database, DatabaseUnion
        from query import fills

        if self.folded and not options.keys() & {"pattern", "per_pattern"}:
            options["per_pattern"] = 1
        if isinstance(source, Database | DatabaseUnion):
            return fills(source, boundary, self.request, **options)
        seconds = get_deadline() - perf_counter()
        if seconds < math.inf:
            options["time_limit"] = max(seconds, LEAST_SECONDS)
        return source.fills(boundary, self.request, **options)


def read_search(given: dict[str, Any], server: str | None) -> AskedFills:
    """Return the search that the options of :func:`search_options` ask for.

    server: the service that is asked; None where the search is made here. Raises
    MissingExtraError where the solver is not installed.
    """
    if given["solver"] == "cp-sat" and server is None:
        require_extra("sketch", "--solver cp-sat")
    some = bool(given["per_pattern"]) or given["pattern"] is not None
    if given["folded"] and some:
        raise click.UsageError(
            "--folded lists one fill of each pattern; leave --pattern and --per-pattern out"
        )
    options = read_options(FillRequest, {**given, "per_pattern": given["per_pattern"] or None})
    return AskedFills(
        FillRequest(**options), not some if given["folded"] is None else given["folded"]
    )


#: What remains of a time limit at least when a service is asked.
LEAST_SECONDS = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class ListedFill:
    """A fill of a list. rank: from 1. variants: how many more fills its pattern has, in a folded
    list. holders: which databases hold its pattern, where several were asked."""

    fill: Fill
    rank: int
    variants: int | None = None
    holders: Sequence[MemberOccurrence] | None = None

    def to_json(self) -> dict[str, object]:
        """The fill as JSON takes it."""
        if self.holders is None:
            return {**self.fill.to_json()}
        return {**self.fill.to_json(), "databases": [one.to_json() for one in self.holders]}


#: Fills whose variants are counted together.
COUNTED_TOGETHER = 60


class FillListing:
    """The fills that a search finds, one after another, so that none need be kept.

    count: how many there were so far. counts_variants: are the other fills of each pattern counted?
    found: the search.
    """

    def __init__(
        self,
        source: Database | DatabaseUnion | RemoteDatabase,
        found: Fills | RemoteFills,
        *,
        counts_variants: bool = False,
    ) -> None:
        from query import Fills

        self.count = 0
        self.found = found
        self.counts_variants = counts_variants and isinstance(found, Fills)
        self._source = source

    def __iter__(self) -> Iterator[ListedFill]:
        """Yield the fills."""
        from patterndb.store import DatabaseUnion
        from query import Fills

        while some := list(islice(self.found, COUNTED_TOGETHER if self.counts_variants else 1)):
            variants: list[int | None] = [None] * len(some)
            if self.counts_variants and isinstance(self.found, Fills):
                variants = self.found.count_variants(some)
            for fill, more in zip(some, variants, strict=True):
                self.count += 1
                holders = None
                if isinstance(self._source, DatabaseUnion):
                    holders = self._source.find_occurrences(fill.pattern)
                yield ListedFill(fill, self.count, more, holders)

    def describe(
        self, keep: Callable[[ListedFill], None] | None = None
    ) -> Iterator[dict[str, object]]:
        """Yield the fills as JSON takes them; where the time limit passes meanwhile, no more than
        the first. keep: called with each before."""
        for one in self:
            if one.rank > 1 and is_late():
                self.count -= 1
                self.found.cancel(TIME_LIMIT)
                return
            if keep is not None:
                keep(one)
            document = one.to_json()
            if self.counts_variants:
                document["variants"] = one.variants
            yield document

    def to_json(self) -> dict[str, object]:
        """What is known at the end of the list."""
        reason = None if self.count else self.found.reason
        reason = reason and name_options(reason)
        stopped = self.found.stopped
        return {
            "truncated": self.found.truncated or stopped is not None,
            "stopped": stopped,
            "complete": stopped is None,
            "reason": reason,
        }


def find_ranked(listing: FillListing, rank: int, what: str, hint: str = "") -> ListedFill:
    """Return the ``rank``-th fill of a list, of which no other is kept.

    what: the word for what is counted. hint: the end of the message where there are fewer. Raises
    NotFoundError there, which also reports whether the search was complete.
    """
    for one in listing:
        if one.rank == rank:
            return one
    found, count = listing.found, listing.count
    if not count:
        raise NotFoundError(f"no fill: {name_options(found.reason or '')}{hint}")
    missing = f"there is no fill {rank}" if found.complete else f"no fill {rank} was found"
    raise NotFoundError(f"{missing}, only {plural(count, what)}{describe_stop(found)}{hint}")


#: Why a list ends at its time limit.
TIME_LIMIT = "time limit"


class EndedEarly(Protocol):
    """A list that may be ended early."""

    @property
    def stopped(self) -> str | None: ...


def describe_stop(found: EndedEarly) -> str:
    """Say in a part of a sentence that the search was not complete; "" where it was."""
    if found.stopped is None:
        return ""
    return f"; the search was not complete ({found.stopped}), so that there may be more"


def format_variants(count: int | None) -> str:
    """How many more fills a pattern has, as :meth:`Fills.count_variants` counts them: "+7"; ""
    for none, "+?" where time was up before they were counted."""
    from query.listing.fills import MOST_COUNTED

    if count is None:
        return "+?"
    if count == 0:
        return ""
    return f"+{count} or more" if count == MOST_COUNTED else f"+{count}"


def strokes_of(flows: tuple[tuple[BoundaryEdge, BoundaryEdge], ...], loops: int) -> list[Stroke]:
    """The strokes that --flow and --loop ask for."""
    from query import Stroke

    return [Stroke(start, end) for start, end in flows] + [Stroke.loop() for _ in range(loops)]
