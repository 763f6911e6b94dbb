"""The verb that shows fills in space as they are found: explore."""

from __future__ import annotations

import contextlib
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb.system.extras import require_extra
from patterndb_app.cli.fill import record_accepted
from patterndb_app.cli.options import (
    NUMBERS,
    DatabaseChoice,
    FileName,
    MeshName,
    boundary_of,
    closed_option,
    dbs_to_read,
    is_starter,
    keys_option,
    may_overwrite,
    open_database,
    output_option,
    picture_path,
    rank_option,
    request_options,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.progressline import hushed
from patterndb_app.cli.search import CORNERS
from patterndb_app.cli.text import say
from query.request import FillRequest

if TYPE_CHECKING:
    from query import Boundary, Stroke
    from query.placing import Surface


@click.command(
    cls=SectionedCommand,
    sections={
        "Boundary": ("--surface", "--sides", "--closed", "--corners"),
        "Fills": ("--tolerance", "--rank", "--flat", "--db"),
        "Output": ("-o", "--keys", "--overwrite"),
    },
)
@click.argument("boundary", type=FileName(), required=False)
@click.option(
    "--surface",
    type=MeshName(),
    metavar="FILE",
    help="The mesh to draw and to fill on; a plane if not given.",
)
@click.option("--sides", type=NUMBERS, help="A flat boundary of these edges instead.")
@closed_option
@click.option(
    "--corners",
    type=CORNERS,
    help="With --sides: c convex, r reflex, where each side begins.",
)
@request_options(FillRequest, "tolerance")
@rank_option("Begin with the K-th fill.")
@click.option("--flat", is_flag=True, help="List every fill, not one of each pattern.")
@dbs_to_read
@output_option(picture_path(".png"), "Write one PNG instead of opening a window.")
@keys_option('Keys pressed first, with spaces: "o Right".')
@may_overwrite
def explore(
    boundary: Path | None,
    surface: Path | None,
    sides: tuple[int, ...] | None,
    closed: bool,
    corners: tuple[str, ...] | None,
    tolerance: int,
    rank: int,
    flat: bool,
    db: DatabaseChoice,
    output: Path | None,
    keys: str,
) -> int:
    """Look through the fills of a boundary on a surface; F1 lists commands and keys.

    BOUNDARY is a JSON file as of 'patterndb fill'; without one, a boundary is drawn in the
    window, corner by corner. Fills are shown as they are found. Change the boundary or draw
    strokes, and the search begins again.

    \b
    patterndb explore --surface head.obj
    patterndb explore cheek.json --surface head.obj --rank 3 -o cheek.png
    patterndb explore --sides 3,5,4,6
    """
    if boundary is not None and sides is not None:
        raise click.UsageError("give either a boundary's file or --sides")
    if sides is not None and surface is not None:
        raise click.UsageError("--sides has no place on a surface; give a boundary's file")
    if sides is None and (closed or corners):
        raise click.UsageError("--closed and --corners go with --sides")
    if output is not None and boundary is None and sides is None:
        raise click.UsageError("nothing to fill: give a boundary's file or --sides")
    if output is None:
        # Imported here because no verb without a window needs it.
        from viewer.shell.probe import check_display

        check_display()
    else:
        require_extra("viewer", "-o, a picture,", ("vtkmodules", "pyvista", "matplotlib"))
    # Imported here because --help need not wait for it.
    from viewer.explore import explore as open_explorer
    from viewer.explorer_commands import KEYS

    try:
        KEYS.check(keys)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--keys") from error
    asked, strokes = _asked(boundary, sides, closed, corners)
    base = None if surface is None else _read_surface(surface)
    from patterndb_app.cli.obj import write_placed_fill

    window = hushed() if output is None else contextlib.nullcontext()
    with open_database(db) as database, window:
        open_explorer(
            database,
            asked,
            surface=base,
            strokes=strokes,
            tolerance=tolerance,
            rank=rank,
            folded=not flat,
            write_obj=write_placed_fill,
            # Nothing is counted in the starter: it is never written to.
            accept=None if is_starter(db) else partial(record_accepted, db),
            open_file=_open_question,
            off_screen=output,
            keys=keys,
        )
    if output is not None:
        say(f"drawn: {output}")
    return 0


def _read_surface(path: Path) -> Surface:
    """The surface of a mesh's file."""
    from ingest.formats import read_mesh
    from query.placing import Surface

    return Surface.from_polygons(read_mesh(path))


def _open_question(path: Path) -> tuple[Boundary | None, list[Stroke], Surface | None]:
    """What a file that is opened in the window asks: a boundary's JSON, or a mesh to draw on."""
    if path.suffix.lower() == ".json":
        from query.boundaryfile import read_boundary

        boundary, strokes = read_boundary(path)
        return boundary, strokes, None
    return None, [], _read_surface(path)


def _asked(
    path: Path | None,
    sides: tuple[int, ...] | None,
    closed: bool,
    corners: tuple[str, ...] | None,
) -> tuple[Boundary | None, list[Stroke]]:
    """The boundary and strokes that were asked for, if any were."""
    if path is not None:
        from query.boundaryfile import read_boundary

        return read_boundary(path)
    if sides is None:
        return None, []
    from query.contour import make_flat_boundary

    named = boundary_of(sides, closed, corners)
    return make_flat_boundary(named.lengths, named.corners), []
