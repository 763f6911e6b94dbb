"""The verb that asks for fills: query, of one boundary or of many in a batch file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from patterndb.errors import InvalidBoundaryError
from patterndb.system.compiling import read_work_clock
from patterndb.system.files import read_lines
from patterndb_app.cli.failure import EXIT_BAD_INPUT, EXIT_NOTHING
from patterndb_app.cli.options import (
    DatabaseChoice,
    FileName,
    Numbers,
    as_json,
    boundary_of,
    dbs_to_read,
    may_overwrite,
    open_source,
    picture_path,
    server_to_ask,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.search import (
    FILTER_OPTIONS,
    ORDER_OPTIONS,
    SEARCH_OPTIONS,
    Corners,
    FlowParam,
    describe_fills,
    find_fills,
    find_holders,
    format_variants,
    search_arguments,
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

if TYPE_CHECKING:
    from collections.abc import Sequence

    from patterndb.store import Database, DatabaseUnion, PatternHolder
    from patterndb_app.client.remote import RemoteDatabase
    from query import Boundary, Fill, Stroke


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
@click.option("--sides", type=Numbers(), help="Edges of every side, counter-clockwise.")
@click.option("--closed", is_flag=True, help="One closed side without a corner: --sides 12.")
@click.option(
    "--corners",
    type=Corners(),
    help="The corner where each side begins: c convex, r reflex.  [default: all convex]",
)
@click.option(
    "--flow",
    "flows",
    type=FlowParam(),
    multiple=True,
    help="A strand from edge i of side a to edge j of side b, from 0; may be given again.",
)
@click.option("--loop", "loops", count=True, help="A loop of quads inside; may be given again.")
@click.option(
    "--batch",
    type=FileName(),
    metavar="FILE",
    help='Boundaries, one a line: 3,5,4,6 or {"sides": [...], "corners": [...], '
    '"strokes": [[[a, i], [b, j]], ...], "loops": n}. One JSON document a line out.',
)
@dbs_to_read
@server_to_ask
@click.option(
    "--limit",
    type=click.IntRange(1),
    default=20,
    show_default=True,
    metavar="N",
    help="List at most N fills.",
)
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
    limit: int,
    as_json: bool,
    obj: Path | None,
    image: Path | None,
    **search: Any,
) -> int:
    """Find the fills of a boundary, best first.

    The first is the most regular; after it come those that artists have made most. Every fill
    has another pattern: the other fills of it are counted, and listed with --pattern. Programs
    get the flat list of all fills. Exit code 1 where there is no fill, as strokes and filters
    may have it.

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
    program = as_json or batch is not None
    arguments = {"limit": limit, **search_arguments(search, program=program)}
    if batch is not None:
        with open_source(db, server) as database:
            return run_batch(batch, database, arguments, obj, image)
    assert sides is not None
    return _one(
        db,
        server,
        boundary_of(sides, closed, corners),
        flows,
        loops,
        arguments,
        as_json,
        obj,
        image,
    )


def _one(
    db: DatabaseChoice,
    server: str | None,
    boundary: Boundary,
    flows: tuple[Any, ...],
    loops: int,
    arguments: dict[str, Any],
    as_json: bool,
    obj: Path | None,
    image: Path | None,
) -> int:
    started = read_work_clock()
    from query import Fills

    folded = arguments["folded"]
    with open_source(db, server) as source:
        strokes = strokes_of(flows, loops)
        found = find_fills(source, boundary, strokes=strokes, **arguments)
        listed = list(found)
        variants = feasible = None
        if isinstance(found, Fills):
            # Two more searches, which a service is not asked for.
            variants = found.count_variants(listed) if folded and found.stopped is None else None
            feasible = found.feasible_patterns
        reason = found.reason
        holders = find_holders(source, listed)
    seconds = read_work_clock() - started
    if as_json:
        document = {
            "sides": list(boundary.lengths),
            "corners": list(boundary.corners),
            "feasible_patterns": feasible,
            "truncated": found.truncated,
            "stopped": found.stopped,
            "reason": reason,
            "seconds": round(seconds, 4),
        }
        fills = describe_fills(listed, holders)
        if variants is not None:
            counted = zip(fills, variants, strict=True)
            fills = ({**fill, "variants": count} for fill, count in counted)
        write_json_with(document, "fills", fills)
    elif listed:
        write(_fill_table(listed, variants, holders))
        fit = "pattern fits" if feasible == 1 else "patterns fit"
        told = (
            plural(len(listed), "fill")
            if feasible is None
            else f"{feasible:,} learned {fit} strictly"
        )
        short = found.cut_short if folded and isinstance(found, Fills) else found.truncated
        more = f"; there are more {'patterns' if folded else 'fills'} than these" if short else ""
        limit = " (--limit)" if short and len(listed) == arguments["limit"] else ""
        say(f"{told} ({seconds:.2f} s){more}{limit}")
        if variants is not None and any(variants):
            say("+: more fills of the pattern, listed by --pattern NAME; all fills by --flat")
    _keep(listed, boundary, strokes, arguments["tolerance"], variants, obj, image)
    if not listed:
        say(f"no fill: {reason}")
        return EXIT_NOTHING
    return 0


def _fill_table(
    fills: Sequence[Fill],
    variants: Sequence[int] | None,
    holders: Sequence[Sequence[PatternHolder]] | None,
) -> str:
    """variants: how many more fills each pattern has, in a folded list. holders: which databases
    hold it, where several were asked."""
    strokes = any(fill.flow_distance is not None for fill in fills)
    heads: tuple[str, ...] = ("rank", "pattern")
    heads += ("variants",) if variants is not None and any(variants) else ()
    heads += ("irregular",)
    heads += ("off",) if strokes else ()
    heads += ("quads", "origin", "seen")
    heads += ("in",) if holders is not None else ()
    heads += ("turned", "widths")
    rows: list[tuple[object, ...]] = []
    for rank, fill in enumerate(fills, 1):
        boundary = fill.n_irregular_boundary
        irregular = f"{fill.n_irregular} ({boundary} on boundary)" if boundary else fill.n_irregular
        row: tuple[object, ...] = (rank, fill.pattern.name)
        if variants is not None and any(variants):
            row += (format_variants(variants[rank - 1]),)
        row += (irregular,)
        if strokes:
            row += (f"{fill.flow_distance or 0:g}",)
        row += (len(fill.quads), fill.origin, fill.pattern.frequency)
        if holders is not None:
            row += (", ".join(printable(one.database) for one in holders[rank - 1]) or "-",)
        rows.append(
            (
                *row,
                f"{fill.rotation} mirrored" if fill.mirrored else str(fill.rotation),
                " ".join(map(str, fill.widths)),
            )
        )
    return table(heads, rows)


def _keep(
    fills: Sequence[Fill],
    boundary: Boundary,
    strokes: Sequence[Stroke],
    tolerance: int,
    variants: Sequence[int] | None,
    obj: Path | None,
    image: Path | None,
) -> None:
    """Write the fills as OBJ files, and draw them, where that was asked.

    variants: how many more fills each pattern has, in a folded list.
    """
    if obj is not None and fills:
        _write_objs(obj, fills, boundary)
    if image is not None and fills:
        from patterndb_app.cli.pictures import fill_sheet, make_fill_cards, tell_drawn

        cards = make_fill_cards(fills, boundary, variants, strokes=strokes, tolerance=tolerance)
        tell_drawn(image, fill_sheet(image, cards, boundary))


def _write_objs(folder: Path, fills: Sequence[Fill], boundary: Boundary) -> None:
    from patterndb_app.cli.obj import write_flat_fill

    folder.mkdir(parents=True, exist_ok=True)
    digits = max(3, len(str(len(fills))))
    paths = [folder / f"fill-{rank:0{digits}}.obj" for rank in range(1, len(fills) + 1)]
    for path, fill in zip(paths, fills, strict=True):
        write_flat_fill(path, fill, boundary)
    say(f"written: {plural(len(fills), 'file')} in {folder}")
    tell_left_over(folder, "fill-*.obj", paths)


def run_batch(
    path: Path,
    database: Database | DatabaseUnion | RemoteDatabase,
    arguments: dict[str, Any],
    obj: Path | None = None,
    image: Path | None = None,
) -> int:
    """Answer every line that is not empty with one line of JSON, in order.

    A line that cannot be read gets a document with "error" instead of "fills". obj: the folder
    for a folder of OBJ files for each line. image: the name of a sheet, to which each line adds
    its number. Returns the exit code: that of bad input if there was such a line, that of nothing
    found if a boundary has no fill.
    """
    from query.batchline import parse_line
    from query.errors import InvalidQueryError

    asked = unreadable = unanswered = 0
    for number, line in read_lines(path, LONGEST_LINE, InvalidQueryError):
        asked += 1
        try:
            boundary, strokes = parse_line(_text(line))
            found = find_fills(database, boundary, strokes=strokes, **arguments)
            listed = list(found)
        except (InvalidBoundaryError, InvalidQueryError) as error:
            unreadable += 1
            write_json({"line": number, "error": str(error)})
            continue
        unanswered += not listed
        document = {
            "line": number,
            "sides": list(boundary.lengths),
            "corners": list(boundary.corners),
            "truncated": found.truncated,
            "stopped": found.stopped,
            "reason": found.reason,
            "seconds": round(found.seconds, 4),
        }
        described = describe_fills(listed, find_holders(database, listed))
        write_json_with(document, "fills", described)
        folder = None if obj is None else obj / f"line-{number:03}"
        sheet = image and image.with_name(f"{image.stem}-line-{number}{image.suffix}")
        _keep(listed, boundary, strokes, arguments["tolerance"], None, folder, sheet)
    say(
        f"{plural(asked, 'boundary', 'boundaries')}, {unanswered} without a fill, "
        f"{unreadable} that could not be read"
    )
    if unreadable:
        return EXIT_BAD_INPUT
    return EXIT_NOTHING if unanswered else 0


def _text(line: bytes) -> str:
    try:
        return line.decode()
    except UnicodeDecodeError as error:
        raise InvalidBoundaryError(f"the line is no UTF-8: {error}") from None
