"""The verb that asks for fills: query, of one boundary or of many in a batch file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from patterndb.errors import InvalidBoundaryError, NotFoundError, TimeLimitError
from patterndb.system.deadline import is_late, refuse_if_late
from patterndb.system.files import read_lines
from patterndb_app.cli.failure import EXIT_BAD_INPUT, EXIT_NOTHING
from patterndb_app.cli.options import (
    NUMBERS,
    DatabaseChoice,
    FileName,
    as_json,
    boundary_of,
    dbs_to_read,
    limit_command,
    may_overwrite,
    open_source,
    picture_path,
    request_options,
    server_to_ask,
)
from patterndb_app.cli.program import SectionedCommand, name_options
from patterndb_app.cli.search import (
    CORNERS,
    FILTER_OPTIONS,
    FLOW,
    ORDER_OPTIONS,
    SEARCH_OPTIONS,
    TIME_LIMIT,
    AskedFills,
    FillListing,
    ListedFill,
    describe_stop,
    format_variants,
    read_search,
    search_options,
    strokes_of,
)
from patterndb_app.cli.text import (
    plural,
    printable,
    say,
    table,
    tell_left_over,
    write,
    write_json,
    write_json_with,
)
from query.request import FillRequest

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from patterndb.store import Database, DatabaseUnion
    from patterndb_app.cli.pictures import FillSheet
    from patterndb_app.client.remote import RemoteDatabase
    from query import Boundary, Stroke


#: Bytes of a line of a batch file; as many as a boundary's own file may have.
LONGEST_LINE = 32_000_000


@click.command(
    cls=SectionedCommand,
    sections={
        "Boundary": ("--sides", "--closed", "--corners", "--flow", "--loop", "--batch"),
        "Which fills": FILTER_OPTIONS,
        "Order and length": (*ORDER_OPTIONS, "--limit"),
        "Search": ("--db", "--server", *SEARCH_OPTIONS),
        "Output": ("--json", "--obj", "--image", "--overwrite"),
    },
)
@click.option("--sides", type=NUMBERS, help="Edges of every side, counter-clockwise.")
@click.option("--closed", is_flag=True, help="One closed side without a corner: --sides 12.")
@click.option(
    "--corners",
    type=CORNERS,
    help="The corner where each side begins: c convex, r reflex.  [default: all convex]",
)
@click.option(
    "--flow",
    "flows",
    type=FLOW,
    multiple=True,
    help="A strand from edge i of side a to edge j of side b, from 0; may be given again.",
)
@click.option("--loop", "loops", count=True, help="A loop of quads inside; may be given again.")
@click.option(
    "--batch",
    type=FileName(),
    metavar="FILE",
    help='Boundaries, one a line: 3,5,4,6 or {"sides": [...], "corners": [...], '
    '"strokes": [[[a, i], [b, j]], ...], "loops": n}, maybe with options, "max_quads": 40. One '
    "JSON document a line out.",
)
@dbs_to_read
@server_to_ask
@request_options(FillRequest, "limit")
@search_options
@as_json
@click.option(
    "--obj",
    type=FileName(),
    metavar="DIR",
    help="Write every fill as DIR/fill-001.obj, flat; those of a batch into DIR/line-001.",
)
@click.option(
    "--image",
    type=picture_path(".png", ".svg"),
    metavar="FILE",
    help="Draw the fills as one sheet, PNG or SVG; a batch's line 3 as FILE with -line-3.",
)
@may_overwrite
def query(
    sides: tuple[int, ...] | None,
    closed: bool,
    corners: tuple[str, ...] | None,
    flows: tuple[Any, ...],
    loops: int,
    batch: Path | None,
    db: DatabaseChoice,
    server: str | None,
    as_json: bool,
    obj: Path | None,
    image: Path | None,
    time_limit: float | None,
    **given: Any,
) -> int:
    """Find the fills of a boundary, best first.

    The first is the most regular; after it come those that artists have made most. Every fill
    has another pattern: the other fills of it are counted, and listed with --pattern; --flat lists
    all fills. Exit code 1 where there is no fill, as strokes and filters may have it.

    \b
    patterndb query --sides 3,5,4,6
    patterndb query --sides 3,5,4,6 --pattern 0492c47448381e23
    patterndb query --sides 8,8,8,8,8,8 --limit 100 --json
    patterndb query --sides 5,4,6,5 --flow 0:2-2:3 --loop --image fills.png
    patterndb query --sides 6,2,4,4,2,4 --corners c,c,c,r,c,c --order regular
    patterndb query --batch boundaries.jsonl --limit 5 --obj fills
    patterndb query --sides 3,5,4,6 --db :starter: --db own.db=3
    patterndb query --sides 3,5,4,6 --server http://127.0.0.1:8017
    """
    if (sides is None) == (batch is None):
        raise click.UsageError("give --sides or --batch, one of them")
    if batch is not None and (closed or corners or flows or loops):
        raise click.UsageError("with --batch every line has its own corners, strokes and loops")
    if obj is not None and obj.exists() and not obj.is_dir():
        raise click.BadParameter(f"{obj} is a file; name a folder", param_hint="'--obj'")
    search = read_search(given, server)
    with limit_command(time_limit), open_source(db, server) as database:
        if batch is not None:
            return run_batch(batch, database, search, obj, image)
        assert sides is not None
        boundary = boundary_of(sides, closed, corners)
        strokes = strokes_of(flows, loops)
        return _one(database, boundary, strokes, search, as_json, obj, image)


def _one(
    source: Database | DatabaseUnion | RemoteDatabase,
    boundary: Boundary,
    strokes: list[Stroke],
    search: AskedFills,
    as_json: bool,
    obj: Path | None,
    image: Path | None,
) -> int:
    started = perf_counter()
    from query import Fills

    folded = search.folded
    found = search.find(source, boundary, strokes=strokes)
    listing = FillListing(source, found, counts_variants=folded)
    kept = KeptFills(boundary, strokes, search.request.tolerance, obj, image)

    def count_feasible() -> int | None:
        # One more search, which a service is not asked for.
        return found.feasible_patterns if isinstance(found, Fills) else None

    def end() -> dict[str, object]:
        feasible = count_feasible()
        known = listing.to_json()
        seconds = round(perf_counter() - started, 4)
        return {"feasible_patterns": feasible, **known, "seconds": seconds}

    if as_json:
        head = {"sides": list(boundary.lengths), "corners": list(boundary.corners)}
        write_json_with(head, "fills", kept.describe(listing), end)
    else:
        rows = [_FillRow.of(one) for one in kept.keep(listing)]
        feasible, seconds = count_feasible(), perf_counter() - started
        if rows:
            write(_fill_table(rows))
            fit = "pattern fits" if feasible == 1 else "patterns fit"
            told = (
                plural(len(rows), "fill")
                if feasible is None
                else f"{feasible:,} learned {fit} strictly"
            )
            short = found.cut_short if folded and isinstance(found, Fills) else found.truncated
            more = f"; there are more {'patterns' if folded else 'fills'} than these"
            more = more if short and found.complete else describe_stop(found)
            limit = " (--limit)" if short and len(rows) == search.request.limit else ""
            say(f"{told} ({seconds:.2f} s){more}{limit}")
            if any(row.variants for row in rows):
                say("+: more fills of the pattern, listed by --pattern NAME; all fills by --flat")
    whole = kept.close()
    if not listing.count:
        say(f"no fill: {name_options(found.reason or '')}")
    return 0 if listing.count and whole else EXIT_NOTHING


@dataclass(frozen=True, slots=True)
class _FillRow:
    """The cells of a fill in the table."""

    rank: int
    pattern: str
    variants: str
    irregular: str | int
    off: float | None
    quads: int
    origin: str
    seen: int
    holders: str | None
    turned: str
    widths: str

    @classmethod
    def of(cls, one: ListedFill) -> _FillRow:
        fill = one.fill
        boundary = fill.n_irregular_boundary
        held = None
        if one.holders is not None:
            held = ", ".join(printable(holder.database) for holder in one.holders) or "-"
        return cls(
            one.rank,
            fill.pattern.name,
            format_variants(one.variants or 0),
            f"{fill.n_irregular} ({boundary} on boundary)" if boundary else fill.n_irregular,
            fill.flow_distance,
            len(fill.quads),
            fill.origin,
            fill.pattern.frequency,
            held,
            f"{fill.rotation} mirrored" if fill.mirrored else str(fill.rotation),
            " ".join(map(str, fill.widths)),
        )


def _fill_table(fills: Sequence[_FillRow]) -> str:
    """The table of fills, without the columns that none of them has."""
    variants = any(row.variants for row in fills)
    strokes = any(row.off is not None for row in fills)
    holders = fills[0].holders is not None
    heads: tuple[str, ...] = ("rank", "pattern")
    heads += ("variants",) if variants else ()
    heads += ("irregular",)
    heads += ("off",) if strokes else ()
    heads += ("quads", "origin", "seen")
    heads += ("in",) if holders else ()
    heads += ("turned", "widths")
    rows: list[tuple[object, ...]] = []
    for row in fills:
        cells: tuple[object, ...] = (row.rank, row.pattern)
        cells += (row.variants,) if variants else ()
        cells += (row.irregular,)
        cells += (f"{row.off or 0:g}",) if strokes else ()
        cells += (row.quads, row.origin, row.seen)
        cells += (row.holders,) if holders else ()
        rows.append((*cells, row.turned, row.widths))
    return table(heads, rows)


class KeptFills:
    """Writes fills as OBJ files, and draws them, where that was asked, each as it is listed."""

    def __init__(
        self,
        boundary: Boundary,
        strokes: Sequence[Stroke],
        tolerance: int,
        obj: Path | None,
        image: Path | None,
    ) -> None:
        self._boundary = boundary
        self._strokes, self._tolerance = strokes, tolerance
        self._obj, self._image = obj, image
        self._sheet: FillSheet | None = None
        self._paths: list[Path] = []
        self._listed = 0
        self._late = False

    def keep(self, listing: Iterable[ListedFill]) -> Iterator[ListedFill]:
        """Yield the fills, each once it is kept."""
        for one in listing:
            self._keep(one)
            yield one

    def describe(self, listing: FillListing) -> Iterator[dict[str, object]]:
        """Yield the fills as JSON takes them, each once it is kept."""
        return listing.describe(self._keep)

    def _keep(self, one: ListedFill) -> None:
        self._listed += 1
        if self._late:
            return
        try:
            if self._obj is not None:
                self._write(self._obj, one)
            if self._image is not None:
                if self._sheet is None:
                    # What draws takes a while to load.
                    refuse_if_late("a picture was drawn")
                    from patterndb_app.cli.pictures import FillSheet

                    self._sheet = FillSheet(
                        self._image, self._boundary, self._strokes, self._tolerance
                    )
                self._sheet.add(one)
        except TimeLimitError:
            # The list goes on: it is cheap, and what could not be kept is reported.
            self._late = True

    def _write(self, folder: Path, one: ListedFill) -> None:
        from patterndb_app.cli.obj import write_flat_fill

        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"fill-{one.rank:03}.obj"
        write_flat_fill(path, one.fill, self._boundary)
        self._paths.append(path)

    def close(self) -> bool:
        """Write what remains, and report all; return False where nothing could be kept in time."""
        whole = True
        if self._obj is not None and self._listed:
            digits = len(str(len(self._paths)))
            if digits > len("001"):
                # So that their names sort by rank.
                self._paths = [
                    path.rename(self._obj / f"fill-{rank:0{digits}}.obj")
                    for rank, path in enumerate(self._paths, 1)
                ]
            say(f"written: {plural(len(self._paths), 'file')} in {self._obj}")
            tell_left_over(self._obj, "fill-*.obj", self._paths)
            whole = self._tell_late(len(self._paths), "written")
        if self._image is not None and self._listed:
            drawn = 0
            if self._sheet is not None:
                try:
                    self._sheet.close()
                except TimeLimitError:
                    self._late = True
                drawn = self._sheet.count
            whole = self._tell_late(drawn, "drawn") and whole
        return whole

    def _tell_late(self, kept: int, doing: str) -> bool:
        """Report how many fills were kept in time; return whether there were any."""
        if kept < self._listed:
            say(
                f"{kept:,} of {plural(self._listed, 'fill')} {doing}: the time limit was over; "
                "allow more seconds, or ask for fewer fills (--limit)"
            )
        return kept > 0


def run_batch(
    path: Path,
    database: Database | DatabaseUnion | RemoteDatabase,
    search: AskedFills,
    obj: Path | None = None,
    image: Path | None = None,
) -> int:
    """Answer every line that is not empty with one line of JSON, in order.

    A line that cannot be read gets a document with "error" instead of "fills", one that is not
    asked any more when the time limit is over a document without fills; an entry "id" of a line is
    in its document, too. Options of a line replace those of the command. obj: the folder
    for a folder of OBJ files for each line. image: the name of a sheet, to which each line adds
    its number. Returns the exit code: that of bad input if there was such a line, that of nothing
    found if a boundary has no fill.
    """
    from query.batchline import parse_line, read_id, read_options
    from query.errors import InvalidQueryError

    asked = unreadable = unanswered = 0
    for number, line in read_lines(path, LONGEST_LINE, InvalidQueryError):
        asked += 1
        options = read_options(line)
        try:
            boundary, strokes = parse_line(_text(line))
            head = {
                "line": number,
                **read_id(line),
                "sides": list(boundary.lengths),
                "corners": list(boundary.corners),
            }
            if is_late():
                unanswered += 1
                write_json({**head, "fills": [], **NOT_ASKED})
                continue
            found = search.find(database, boundary, strokes=strokes, **options)
        except TimeLimitError:
            unanswered += 1
            write_json({"line": number, **read_id(line), "fills": [], **NOT_ASKED})
            continue
        except (InvalidBoundaryError, InvalidQueryError, NotFoundError) as error:
            if isinstance(error, NotFoundError) and not options:
                # The command asks for it, so that no line can mend it.
                raise
            unreadable += 1
            told = name_options(str(error))
            write_json({"line": number, **read_id(line), "error": told})
            continue
        listing = FillListing(database, found)
        folder = None if obj is None else obj / f"line-{number:03}"
        sheet = image and image.with_name(f"{image.stem}-line-{number}{image.suffix}")
        tolerance = options.get("tolerance", search.request.tolerance)
        kept = KeptFills(boundary, strokes, tolerance, folder, sheet)

        def end(listing: FillListing = listing) -> dict[str, object]:
            return {**listing.to_json(), "seconds": round(listing.found.seconds, 4)}

        write_json_with(head, "fills", kept.describe(listing), end)
        whole = kept.close()
        unanswered += not (listing.count and whole)
    say(
        f"{plural(asked, 'boundary', 'boundaries')}, {unanswered} without a fill, "
        f"{unreadable} that could not be read"
    )
    if unreadable:
        return EXIT_BAD_INPUT
    return EXIT_NOTHING if unanswered else 0


#: The end of the answer to a line of a batch that comes after the time limit.
NOT_ASKED: dict[str, object] = {
    "truncated": True,
    "stopped": TIME_LIMIT,
    "complete": False,
    "reason": "the time limit was over before this boundary was asked; allow more seconds",
    "seconds": 0.0,
}


def _text(line: bytes) -> str:
    try:
        return line.decode()
    except UnicodeDecodeError as error:
        raise InvalidBoundaryError(f"the line is no UTF-8: {error}") from None
