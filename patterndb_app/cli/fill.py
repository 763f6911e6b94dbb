"""The verb that fills a boundary in space: fill."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from patterndb.errors import InvalidBoundaryError
from patterndb.system.deadline import run_until_late
from patterndb_app.cli.options import (
    OBJ,
    DatabaseChoice,
    FileName,
    MeshName,
    as_json,
    dbs_to_read,
    limit_command,
    may_overwrite,
    open_database,
    open_source,
    output_option,
    rank_option,
    server_to_ask,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.search import (
    FILTER_OPTIONS,
    ORDER_OPTIONS,
    SEARCH_OPTIONS,
    FillListing,
    ListedFill,
    find_ranked,
    read_search,
    search_options,
)
from patterndb_app.cli.text import plural, say, write_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from patterndb_app.client.remote import RemoteFills
    from query import Fill, Fills
    from query.placing import Placement, Region

#: A boundary that encloses more of its surface than this may well run the wrong way round.
MOST_OF_SURFACE = 0.5


@click.command(
    cls=SectionedCommand,
    sections={
        "Place": ("--surface", "--strokes"),
        "Which fills": ("--rank", *FILTER_OPTIONS),
        "Order": ORDER_OPTIONS,
        "Search": ("--db", "--server", *SEARCH_OPTIONS),
        "Output": ("-o", "--overwrite", "--json", "--record"),
    },
)
@click.argument("boundary", type=FileName())
@click.option(
    "--surface",
    type=MeshName(),
    metavar="FILE",
    help="The mesh that the fill and its boundary lie on.",
)
@click.option(
    "--strokes",
    type=FileName(),
    metavar="FILE",
    help="Strokes in a JSON file of their own, added to the boundary's.",
)
@rank_option("Place the K-th fill: of different patterns, or with --flat of all.")
@dbs_to_read
@server_to_ask
@click.option(
    "--record",
    is_flag=True,
    help="Record in --db that the fill was accepted, for --use-counts; of several in the first "
    "that may be written.",
)
@search_options
@output_option(OBJ, "The placed fill, OBJ.", required=True)
@may_overwrite
@as_json
def fill(
    boundary: Path,
    surface: Path | None,
    strokes: Path | None,
    rank: int,
    db: DatabaseChoice,
    server: str | None,
    record: bool,
    output: Path,
    as_json: bool,
    time_limit: float | None,
    **given: Any,
) -> int:
    """Fill a boundary in space: place its best fill, or the K-th, and write it as OBJ.

    BOUNDARY is a JSON file: a polyline per side, counter-clockwise, and edge counts.

    \b
    {"sides": [[[0,0,0],[4,0,0]], [[4,0,0],[4,3,1]], [[4,3,1],[0,0,0]]],
     "edge_length": 1.0,                    or "lengths": [4, 3, 5], or "vertices": true
     "corners": ["convex", "c", "r"],       convex or reflex; may be left out
     "strokes": [[[2,0,0],[4,1,0.3]], {"points": [...], "loop": true}]}

    The boundary's vertices, at equal distances along each side, stay where they are; with
    "vertices": true they are the points themselves. The fill has a strand
    for each stroke, pulled onto it.

    Exit code 1 where there is no such fill, 3 for a file that is not what it must be.

    \b
    patterndb fill boundary.json -o fill.obj
    patterndb fill cheek.json --surface head.obj --rank 2 -o cheek.obj --json
    patterndb fill cheek.json --db my.db --record -o cheek.obj
    patterndb fill cheek.json --server http://127.0.0.1:8017 -o cheek.obj
    """
    if record and db is None:
        raise click.UsageError("--record needs --db: the starter database cannot be changed")
    search = read_search(given, server)
    # Imported here because --help need not wait for it.
    from query.boundaryfile import read_boundary, read_strokes
    from query.placing import Surface, enclose_region, place
    from query.placing.region import find_void

    asked, drawn = read_boundary(boundary)
    assert asked.points is not None
    if strokes is not None:
        drawn += read_strokes(strokes, asked)
    region: Region | None = None
    void: NDArray[np.float64] | None = None
    if surface is not None:
        from ingest.formats import read_mesh

        base = Surface.from_polygons(read_mesh(surface))
        # Before the search: a boundary that is nowhere near its surface is refused.
        try:
            region = enclose_region(base, asked.points)
        except InvalidBoundaryError as error:
            raise InvalidBoundaryError(f"{boundary}, on {surface}: {error}") from error
        void = find_void(region, base, base.border_sides, asked.points)
    tolerance = search.request.tolerance
    see = f"see 'patterndb query --sides {','.join(map(str, asked.lengths))}'"
    from patterndb_app.cli.obj import write_placed_fill

    with limit_command(time_limit), open_source(db, server) as source:
        started = perf_counter()
        found = search.find(source, asked, limit=rank, strokes=drawn)
        what = "pattern" if search.folded else "fill"
        hint = f"{'; --flat counts every fill' if search.folded else ''}; {see}"
        chosen = find_ranked(FillListing(source, found), rank, what, hint)
        found_at = perf_counter()
        placement = run_until_late(
            partial(place, chosen.fill, asked.points, region, drawn, tolerance=tolerance),
            "the fill was placed",
        )
    seconds = found_at - started, perf_counter() - found_at
    write_placed_fill(output, chosen.fill, placement.vertices)
    if record:
        say(record_accepted(db, chosen.fill))
    if as_json:
        write_json(_document(chosen, found, placement, output, seconds))
    _tell(chosen.fill, placement, region, seconds)
    if void is not None:
        at = ", ".join(f"{x:.4g}" for x in void)
        say(
            f"a border of the surface lies within the boundary, at {at}: where the surface is "
            "open, the quads lie on nothing"
        )
    say(f"written: {output}")
    return 0


def record_accepted(db: DatabaseChoice, fill: Fill) -> str:
    """Record that the fill was accepted, of several databases in the first that may be written;
    return what is to be said of it."""
    from patterndb.store import DatabaseUnion

    with open_database(db, "write") as database:
        uses = database.record_use(fill.pattern)
        where = ""
        if isinstance(database, DatabaseUnion):
            where = f" in {database.find_writable().name}"
    return f"recorded{where}: {plural(uses, 'use')} of pattern {fill.pattern.name}"


def _document(
    chosen: ListedFill,
    found: Fills | RemoteFills,
    placement: Placement,
    output: Path,
    seconds: tuple[float, float],
) -> dict[str, object]:
    return {
        "output": str(output),
        "rank": chosen.rank,
        "fill": chosen.to_json(),
        "stopped": found.stopped,
        "complete": found.stopped is None,
        "irregular": chosen.fill.disk().irregular().tolist(),
        **placement.to_json(),
        "seconds_query": round(seconds[0], 4),
        "seconds_place": round(seconds[1], 4),
    }


def _tell(
    fill: Fill, placement: Placement, region: Region | None, seconds: tuple[float, float]
) -> None:
    irregular = fill.n_irregular
    say(
        f"pattern {fill.pattern.name}: {plural(fill.n_quads, 'quad')}, "
        f"{plural(irregular, 'irregular vertex', 'irregular vertices')}, "
        f"found in {seconds[0]:.2f} s, placed in {seconds[1]:.2f} s"
    )
    if region is not None:
        enclosed = (
            f"the boundary encloses {region.share:.1%} of it"
            if region.separates
            else "the boundary leaves it, or goes round a handle, so that all of it was looked at"
        )
        say(
            f"on the surface after {plural(placement.rounds, 'round')} of smoothing and "
            f"projection{'' if placement.at_rest else ', not at rest'}; {enclosed}"
        )
        if region.separates and region.share > MOST_OF_SURFACE:
            say(
                "that is more than half of it: if it is not meant, list sides and points the "
                "other way round, counter-clockwise seen from outside"
            )
    for number, (before, after) in enumerate(_stroke_rows(placement), 1):
        if math.isnan(before[0]):
            say(f"stroke {number}: no strand of this fill ends near both its ends")
        else:
            say(
                f"stroke {number}: mean distance {before[0]:.4g} before its strand was pulled, "
                f"{after[0]:.4g} after; greatest {before[1]:.4g}, {after[1]:.4g}"
            )
    flipped = placement.flipped.tolist()
    if flipped:
        shown = ", ".join(str(q + 1) for q in flipped[:8]) + ("…" if len(flipped) > 8 else "")
        say(
            f"{plural(len(flipped), 'flipped quad')}: face {shown}; another --rank, or a boundary "
            "that bends less, may have none"
        )


def _stroke_rows(
    placement: Placement,
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    return list(zip(placement.strokes_before, placement.strokes_after, strict=True))
