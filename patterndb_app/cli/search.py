"""The options of verbs that search for fills, and the search that they ask for."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, overload

import click

from patterndb.system.extras import require_extra
from patterndb_app.cli.options import (
    ParamType,
    Range,
    max_irregular_option,
    provenance_options,
    valence_option,
)

if TYPE_CHECKING:
    from patterndb.store import Database, DatabaseUnion, PatternHolder
    from patterndb_app.client.remote import RemoteDatabase, RemoteFills
    from query import Boundary, Fill, Fills, Stroke
    from query.stroke import BoundaryEdge

F = TypeVar("F", bound=Callable[..., Any])

#: What --corners takes for each kind.
KINDS = {"c": "convex", "convex": "convex", "r": "reflex", "reflex": "reflex"}


class Corners(ParamType):
    """Kinds of corners with commas between: c,c,r,c."""

    name = "c,c,r,..."
    has_commas = True

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        words = [word.strip().lower() for word in str(value).split(",")]
        for word in words:
            if word not in KINDS:
                self.fail(f"{word!r} is no corner; write c for convex or r for reflex", param, ctx)
        return tuple(KINDS[word] for word in words)


class FlowParam(ParamType):
    """A stroke from edge i of side a to edge j of side b: a:i-b:j."""

    name = "a:i-b:j"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[BoundaryEdge, BoundaryEdge]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        match = re.fullmatch(
            r"([0-9]{1,6}):([0-9]{1,6})-([0-9]{1,6}):([0-9]{1,6})", str(value).strip()
        )
        if not match:
            self.fail(
                f"{value!r} is no stroke like 0:2-3:1, from edge 2 of side 0 to edge 1 of side 3",
                param,
                ctx,
            )
        a, i, b, j = map(int, match.groups())
        return (a, i), (b, j)


class OrderChoice(click.Choice[str]):
    """The names of the orders that there are, loaded when they are asked for."""

    def __init__(self) -> None:
        self.case_sensitive = True

    @property
    def choices(self) -> tuple[str, ...]:  # pyright: ignore[reportIncompatibleVariableOverride]
        from query.listing.orders import ORDERS

        return tuple(ORDERS)


class OrderOption(click.Option):
    """The option --order, whose help says what comes first in every order."""

    @property
    def help(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        from query.listing.orders import describe_orders

        return describe_orders()

    @help.setter
    def help(self, value: Any) -> None:  # pyright: ignore[reportIncompatibleVariableOverride]
        # click sets what the option was given, which is nothing.
        pass


folded_option = click.option(
    "--folded/--flat",
    default=None,
    help="One fill of each pattern, its variants counted, or every fill in its place.  [default: "
    "folded; flat with --pattern and --per-pattern]",
)

_OPTIONS = (
    click.option(
        "--tolerance",
        type=click.IntRange(0),
        default=1,
        show_default=True,
        metavar="K",
        help="Edges by which strands may miss the strokes' ends.",
    ),
    click.option(
        "--strict/--relaxed",
        default=False,
        help="Only fills with corners exactly where the boundary's are, or others too (default).",
    ),
    click.option(
        "--max-boundary-irregular",
        type=click.IntRange(0),
        default=3,
        show_default=True,
        metavar="K",
        help="At most K irregular vertices on the boundary, but for constructed fills.",
    ),
    max_irregular_option,
    valence_option,
    click.option("--max-quads", type=click.IntRange(1), metavar="N", help="At most N quads."),
    click.option(
        "--pattern-corners",
        type=Range(least=0),
        help="Only patterns with so many corners.",
    ),
    click.option(
        "--has-loop/--no-loop",
        default=None,
        help="Only patterns with a loop of quads inside, or without.",
    ),
    *provenance_options,
    click.option(
        "--learned-only",
        is_flag=True,
        help="No fills but of patterns that the database holds.",
    ),
    click.option(
        "--use-counts",
        is_flag=True,
        help="Let recorded uses count like patches of meshes.",
    ),
    click.option(
        "--order",
        type=OrderChoice(),
        cls=OrderOption,
    ),
    folded_option,
    click.option(
        "--pattern",
        metavar="NAME",
        help="Only fills of this pattern, by the first digits of its name: all its variants.",
    ),
    click.option(
        "--per-pattern",
        type=click.IntRange(0),
        default=0,
        metavar="N",
        help="List at most N fills of one pattern, with --flat; 0 for all.  [default: 0]",
    ),
    click.option(
        "--time-limit",
        type=click.FloatRange(0, 1e6, min_open=True),
        metavar="SECONDS",
        help="End the list after so long.",
    ),
    click.option(
        "--solver",
        type=click.Choice(["kernel", "cp-sat"]),
        default="kernel",
        show_default=True,
        help="What finds the widths.",
    ),
    click.option("--jobs", type=click.IntRange(1, 1024), metavar="N", help="Threads; one a core."),
)


#: The sections of the help that these options are in.
FILTER_OPTIONS = (
    "--tolerance",
    "--strict",
    "--max-boundary-irregular",
    "--max-irregular",
    "--valence",
    "--max-quads",
    "--pattern-corners",
    "--has-loop",
    "--min-frequency",
    "--from-mesh",
    "--from-licence",
    "--learned-only",
)
ORDER_OPTIONS = ("--order", "--use-counts", "--folded", "--pattern", "--per-pattern")
SEARCH_OPTIONS = ("--time-limit", "--solver", "--jobs")


def search_options(verb: F) -> F:
    """Give a verb the options that :func:`search_arguments` understands."""
    for option in reversed(_OPTIONS):
        verb = option(verb)
    return verb


def search_arguments(given: dict[str, Any], server: str | None) -> dict[str, Any]:
    """The keywords of :func:`find_fills` that the options of :func:`search_options` mean.

    server: the service that is asked; None where the search is made here. Raises
    MissingExtraError where what searches is not installed.
    """
    if given["solver"] == "cp-sat" and server is None:
        require_extra("sketch", "--solver cp-sat")
    arguments = {
        name: given[name]
        for name in (
            "tolerance",
            "strict",
            "max_boundary_irregular",
            "max_irregular",
            "max_quads",
            "has_loop",
            "min_frequency",
            "use_counts",
            "order",
            "time_limit",
            "solver",
            "pattern",
        )
    }
    arguments["corners"] = given["pattern_corners"]
    arguments["meshes"] = given["from_mesh"] or None
    arguments["licences"] = given["from_licence"] or None
    arguments["origins"] = ("learned", "imported") if given["learned_only"] else None
    some = bool(given["per_pattern"]) or given["pattern"] is not None
    if given["folded"] and some:
        raise click.UsageError(
            "--folded lists one fill of each pattern; leave --pattern and --per-pattern out"
        )
    arguments["folded"] = not some if given["folded"] is None else given["folded"]
    arguments["per_pattern"] = given["per_pattern"] or None
    arguments["threads"] = given["jobs"]
    if given["valence"] is not None:
        arguments["valence"] = given["valence"]
    return arguments


@overload
def find_fills(
    source: Database | DatabaseUnion, boundary: Boundary, *, folded: bool, **arguments: Any
) -> Fills: ...
@overload
def find_fills(
    source: Database | DatabaseUnion | RemoteDatabase,
    boundary: Boundary,
    *,
    folded: bool,
    **arguments: Any,
) -> Fills | RemoteFills: ...
def find_fills(
    source: Database | DatabaseUnion | RemoteDatabase,
    boundary: Boundary,
    *,
    folded: bool,
    **arguments: Any,
) -> Fills | RemoteFills:
    """As :func:`query.fills`, but that the pattern goes by the first digits of its name.

    source: a database, several as one, or one that a service answers for. folded: one fill of
    each pattern.
    """
    from patterndb.store import Database, DatabaseUnion
    from query import fills

    if folded:
        arguments["per_pattern"] = 1
    if not isinstance(source, Database | DatabaseUnion):
        return source.fills(boundary, **arguments)
    name = arguments.get("pattern")
    if name is not None:
        arguments["pattern"] = _identify_pattern(source, name)
    return fills(source, boundary, **arguments)


def find_holders(
    source: Database | DatabaseUnion | RemoteDatabase, fills: Sequence[Fill]
) -> list[list[PatternHolder]] | None:
    """Find which of several databases hold the pattern of each fill; None where one is asked."""
    from patterndb.store import DatabaseUnion

    if not isinstance(source, DatabaseUnion):
        return None
    return [source.find_holders(fill.pattern) for fill in fills]


def describe_fills(
    fills: Sequence[Fill], holders: Sequence[Sequence[PatternHolder]] | None
) -> Iterator[dict[str, object]]:
    """The fills as JSON takes them, with the databases that hold their patterns where several
    were asked (:func:`find_holders`)."""
    for at, fill in enumerate(fills):
        told = {} if holders is None else {"databases": [one.to_json() for one in holders[at]]}
        yield {**fill.to_json(), **told}


def _identify_pattern(database: Database | DatabaseUnion, name: str) -> int:
    """The id of a pattern, which no mesh need have shown if its name is given whole."""
    if re.fullmatch(r"[0-9a-fA-F]{16}", name):
        return int(name, 16)
    return database.pattern(name).id


def format_variants(count: int) -> str:
    """How many more fills a pattern has, as :meth:`Fills.count_variants` counts them: "+7"; ""
    for none."""
    from query.listing.stream import MOST_COUNTED

    if count == 0:
        return ""
    return f"+{count} or more" if count == MOST_COUNTED else f"+{count}"


def strokes_of(flows: tuple[tuple[BoundaryEdge, BoundaryEdge], ...], loops: int) -> list[Stroke]:
    """The strokes that --flow and --loop ask for."""
    from query import Stroke

    return [Stroke(start, end) for start, end in flows] + [Stroke.loop() for _ in range(loops)]
