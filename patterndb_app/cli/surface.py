"""The verb that surfaces a curve network: surface."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from patterndb.errors import NotFoundError
from patterndb.system.extras import EXTRAS, require_extra
from patterndb_app.cli.options import (
    FileName,
    MeshToWrite,
    Parsed,
    as_json,
    db_to_read,
    is_given,
    list_flags,
    may_overwrite,
    open_database,
    output_option,
    picture_option,
    read_options,
    request_options,
    view_option,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.progressline import hushed
from patterndb_app.cli.text import plural, say, shorten, table, write, write_json
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.methods import DEFAULT_METHOD, METHODS, SurfaceRequest

if TYPE_CHECKING:
    from patterndb.geometry.points import Points
    from patterndb_sketch.curvenetwork.drawing import Drawing
    from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
    from patterndb_sketch.retopo.symmetry.half import Plane
    from patterndb_sketch.surfacing import FoundCycles, SurfacePatch, Surfacing
    from patterndb_sketch.surfacing.openings import Openings

#: The plane of --mirror where none is given.
FOUND = "found"

#: What may be upright in pictures, as the viewer has it: that is not imported for --help.
UPRIGHT_NAMES = ("x", "y", "z", "-x", "-y", "-z")

#: Columns that a table leaves for the curves of a cycle.
CURVES_WIDTH = 24

#: Columns that a sentence leaves for the names of curves.
NAMES_WIDTH = 60

#: Pairs of patches that pass through each other, open rims, joins and loose ends, named one by one.
MOST_CROSSINGS = 5
MOST_RIMS = 5
MOST_JOINS = 5


def _parse_curves(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if not all(names):
        raise ValueError(f"{text!r} is not a list of curve ids like 4,7,12")
    return names


#: A cycle by the names of its curves in order: 4,7,12.
CURVE_NAMES = Parsed("id,id,...", _parse_curves)


@click.command(
    cls=SectionedCommand,
    sections={
        "Cycles": ("--find-cycles", "--ban", "--keep", "--cycles-only", "--tolerance", "--mirror"),
        "Surface": (*list_flags(SurfaceRequest, "surface"), "--db"),
        "Output": ("-o", "--thickness", "--picture", "--up", "--overwrite", "--view", "--json"),
    },
)
@click.argument("network", type=FileName())
@output_option(
    MeshToWrite(),
    "The surface, OBJ with a group for each patch; by the suffix also PLY, OFF, STL or 3MF.",
)
@click.option(
    "--thickness",
    type=click.FloatRange(0, min_open=True),
    help="Write the closed solid of this thickness, half of it on each side of the surface.",
)
@request_options(SurfaceRequest)
@click.option(
    "--tolerance",
    type=click.FloatRange(0),
    show_default="what follows from the drawing",
    help="How far apart curves may pass and still meet, in the network's unit. Curves that meet "
    "exactly do in any case, and those drawn exactly meet each other nowhere else.",
)
@click.option(
    "--mirror",
    is_flag=False,
    flag_value=FOUND,
    metavar="[PLANE]",
    help="The network is half of a symmetric one: add its mirror image. PLANE is x, y or z through "
    "the origin, x=1.5, or a,b,c,d for ax + by + cz = d; found where it is left out.",
)
@click.option(
    "--up",
    type=click.Choice(UPRIGHT_NAMES),
    default="y",
    show_default=True,
    help="What is upright in the picture and the window; z for most models that are built.",
)
@picture_option("Draw the surface into a PNG, without a window.")
@view_option("Look at the surface in a window; F1 lists commands and keys.")
@click.option("--cycles-only", is_flag=True, help="Print the cycles only.")
@click.option(
    "--find-cycles", is_flag=True, help="Find the cycles afresh even if the file has some."
)
@click.option(
    "--ban",
    type=CURVE_NAMES,
    multiple=True,
    metavar="CYCLE",
    help="No patch for this cycle, the ids of its curves: 4,7,12. May be repeated.",
)
@click.option(
    "--keep",
    type=CURVE_NAMES,
    multiple=True,
    metavar="CYCLE",
    help="Always make a patch for this cycle. May be repeated.",
)
@db_to_read
@may_overwrite
@as_json
def surface(
    network: Path,
    output: Path | None,
    tolerance: float | None,
    mirror: str | None,
    thickness: float | None,
    up: str,
    picture: Path | None,
    view: bool,
    cycles_only: bool,
    find_cycles: bool,
    ban: tuple[tuple[str, ...], ...],
    keep: tuple[tuple[str, ...], ...],
    db: Path | None,
    as_json: bool,
    **given: Any,
) -> int:
    """Surface a network of curves in space: a patch for each of its cycles.

    NETWORK is a JSON file, a stroke graph of the CASSIE data set, a file of loops (.lop, .sdm,
    .curves), or an OBJ file with lines (l). Curves meet where they end or cross.

    \b
    {"curves": [{"id": "rim", "points": [[0,0,0],[1,0,0.2],[2,0,0]]}, ...],
     "cycles": [["rim", 4, 7], ...]}        the patches; may be left out

    Cycles that the file has are used; else, or with --find-cycles, they are found. Patches
    share the vertices of the curves. A table tells for each patch which method answered, how
    many chords were candidates and were chosen, how many sub-problems the search had and how
    long all took, pieces, area, and pairs of faces that pass through each other. What stays
    open is listed: curves without a patch (--json: bound_nothing) and the rims of the surface
    (open_rims), the shortest first; a picture marks them, dashed and orange.

    --alpha and --any-chord say how loops are cut: with them the method is chords if --method does
    not name another.

    Exit code 1 where there is no cycle, 3 for a file that is not what it must be.

    \b
    patterndb surface sketch.json -o surface.obj
    patterndb surface sketch.json --find-cycles --ban 4,7,12 -o surface.obj --json
    patterndb surface sketch.json --cycles-only --json
    patterndb surface sketch.json --fair -o surface.obj
    patterndb surface sketch.json --method quads --spacing 0.2 -o quads.obj
    """
    for name, wanted in (
        ("-o", output),
        ("--thickness", thickness),
        ("--picture", picture),
        ("--view", view),
    ):
        if cycles_only and wanted:
            raise click.UsageError(f"--cycles-only makes no surface; leave {name} out")
    request = _read_request(given)
    if thickness is not None and output is None:
        raise click.UsageError("--thickness is of the solid that -o writes; give -o FILE, too")
    # Imported here because --help need not wait for it.
    from patterndb_sketch.surfacing import find_openings
    from patterndb_sketch.surfacing import surface as surface_of

    patterns = METHODS[request.method].needs_database
    if patterns and not cycles_only:
        require_extra("sketch", f"--method {request.method}")
    drawing = _read(network, tolerance, mirror)
    if not EXTRAS["sketch"].is_there() and (find_cycles or not drawing.network.cycles):
        require_extra("sketch", "finding the cycles of a network")
    for note in drawing.notes:
        say(note)
    _say_joins(drawing)
    drawn = drawing.network
    started = perf_counter()
    cycles, found = _cycles(drawn, find_cycles, ban, keep)
    seconds_finding = perf_counter() - started
    if not cycles:
        raise NotFoundError(f"{network}: {_explain_nothing(drawn, found)}")
    notes = [*drawing.notes, *(() if found is None else found.notes)]
    document: dict[str, object] = {
        "network": str(network),
        "curves": len(drawn.curves),
        "nodes": len(drawn.nodes),
        "cycles": [drawn.names(cycle) for cycle in cycles],
        "cycles_found": found is not None,
        "seconds_finding": round(seconds_finding, 6),
        **({} if found is None else _summarise_cycles(drawn, found)),
        **_list_joins(drawing),
        "notes": notes,
    }
    if found is not None:
        _say_found(found, seconds_finding)
    if cycles_only:
        openings = find_openings(drawn, cycles)
        if as_json:
            write_json(document | _list_openings(drawn, openings))
        else:
            for cycle in cycles:
                write(",".join(str(name) for name in drawn.names(cycle)))
        _say_openings(drawn, openings)
        return 0
    with open_database(db) if patterns else nullcontext() as database:
        started = perf_counter()
        made = surface_of(drawn, cycles, request, db=database)
        seconds = perf_counter() - started
    openings = find_openings(drawn, made.list_surfaced_cycles())
    solid = None if output is None else _write_output(output, made, thickness)
    if solid is not None:
        notes += solid.notes
    if as_json:
        document |= {
            "method": request.method,
            "fair": request.fair,
            "alpha": request.alpha,
            "spacing": made.sampling.spacing,
            "patches": [_patch(made, patch) for patch in made.patches],
            "area": made.area,
            "intersections_between_patches": made.intersections,
            "crossings": [
                {"patches": [i + 1, j + 1], "pairs": pairs} for i, j, pairs in made.crossings
            ],
            **_list_openings(drawn, openings),
            "seconds": round(seconds, 6),
            "notes": [*notes, *made.notes],
            "thickness": thickness,
            "quads": None if not made.has_quads else _count_quads(made),
            "closed": None if solid is None else solid.closed,
            "output": None if output is None else str(output),
        }
        write_json(document)
    else:
        write(table(HEADS, [_row(drawn, i, p) for i, p in enumerate(made.patches, 1)]))
    _say_made(made, seconds)
    _say_openings(drawn, openings)
    if solid is not None:
        for note in solid.notes:
            say(note)
        say(f"written: {output}")
    if picture is not None or view:
        open_file = partial(_read, tolerance=tolerance, mirror=mirror) if view else None
        _look(drawing, request, db, find_cycles, (ban, keep), picture, open_file, up)
    return 0


def _read_request(given: Mapping[str, Any]) -> SurfaceRequest:
    """Return how the network is to be surfaced: cut along chords where an option says how."""
    request = SurfaceRequest(**read_options(SurfaceRequest, given))
    cuts = is_given("alpha", "area_price")
    if cuts and not is_given("method"):
        request = request.having(method="chords")
    if request.fair and (cuts or request.method != DEFAULT_METHOD):
        raise click.UsageError(
            f"--fair moves grids of the method {DEFAULT_METHOD}, and chords make none; leave it "
            "out, or --method, --alpha and --any-chord"
        )
    return request


def _read(path: Path, tolerance: float | None, mirror: str | None) -> Drawing:
    """Read the drawing in a file, with its mirror image if that is asked for."""
    from patterndb_sketch.surfacing import read_drawing

    plane = None
    if mirror is not None and mirror != FOUND:
        plane = parse_mirror(mirror)
    drawing = read_drawing(path, tolerance=tolerance)
    if mirror is None:
        return drawing
    from patterndb_sketch.surfacing.mirroring import find_mirror_plane, mirror_drawing

    try:
        return mirror_drawing(drawing, plane or find_mirror_plane(drawing.network))
    except InvalidNetworkError as error:
        raise InvalidNetworkError(f"{path}: --mirror: {error}") from None


def parse_mirror(text: str) -> Plane:
    """The plane of --mirror; what is none is refused as a usage error."""
    from patterndb_sketch.surfacing.mirroring import parse_plane

    try:
        return parse_plane(text)
    except InvalidNetworkError as error:
        raise click.BadParameter(
            f"{error}. Put the network before --mirror if the plane is to be found",
            param_hint="--mirror",
        ) from None


@dataclass(frozen=True, slots=True)
class _Written:
    """What was written: is it closed, and what a user should know of it."""

    closed: bool
    notes: tuple[str, ...]


def _write_output(path: Path, made: Surfacing, thickness: float | None) -> _Written:
    """Write the surface, or the solid of a thickness, in the format of the suffix."""
    import numpy as np

    from ingest.formats import PRINTED, write_mesh
    from patterndb_app.cli.obj import write_surface
    from patterndb_sketch.surfacing.tessellation import find_self_intersections
    from patterndb_sketch.surfacing.thickening import is_closed, thicken, turn_outward

    printed = any(path.suffix.lower() in form.suffixes for form in PRINTED)
    if thickness is not None:
        points, triangles = thicken(made.points, made.triangles, thickness)
        write_mesh(path, (points, triangles))
        crossed = len(find_self_intersections(points, triangles))
        notes = [f"a closed solid of {plural(len(triangles), 'triangle')}, {thickness:g} thick"]
        if crossed:
            notes.append(
                f"faces of the solid pass through each other: {plural(crossed, 'pair')}; a smaller "
                "--thickness may mend it"
            )
        return _Written(True, tuple(notes))
    closed = is_closed(made.triangles)
    if path.suffix.lower() == ".obj":
        write_surface(path, made)
        return _Written(closed, ())
    pieces = turn_outward(made.points, [face for patch in made.patches for face in patch.faces])
    used, name = np.unique(np.concatenate([piece.ravel() for piece in pieces]), return_inverse=True)
    corners = name.reshape(-1).tolist()
    faces: list[list[int]] = []
    at = 0
    for piece in pieces:
        for _ in piece:
            faces.append(corners[at : at + piece.shape[1]])
            at += piece.shape[1]
    write_mesh(path, (made.points[used], faces))
    if printed and not closed:
        return _Written(closed, ("the surface is open; --thickness makes a closed solid of it",))
    return _Written(closed, ())


def _count_quads(made: Surfacing) -> dict[str, int]:
    return {
        "irregular": made.count_irregular(),
        "turned_corners": sum(patch.surface.turned for patch in made.patches if patch.surface),
    }


def _explain_nothing(given: CurveNetwork, found: FoundCycles | None) -> str:
    """Why a network has no cycle, and what would mend it."""
    from patterndb_sketch.curvenetwork.drawing import find_loose_ends, round_up

    if found is not None and found.nearest_miss is not None:
        return found.nearest_miss.tell(given)
    if not given.curves:
        return "the network has no curves; give some, each with its points"
    dangling = 0 if found is None else len(found.dangling)
    loose = f", {dangling} of which end where nothing goes on" if dangling else ""
    short = find_loose_ends(given)
    mend = f"try --tolerance {round_up(short[0].gap)}" if short else "try a greater --tolerance"
    return (
        f"no closed cycle among {plural(len(given.curves), 'curve')}{loose}; curves that should "
        f"meet may pass each other: {mend}"
    )


def _look(
    drawing: Drawing,
    request: SurfaceRequest,
    db: Path | None,
    afresh: bool,
    named: tuple[tuple[tuple[str, ...], ...], tuple[tuple[str, ...], ...]],
    picture: Path | None,
    open_file: Callable[[Path], Drawing] | None,
    up: str,
) -> None:
    """Draw the surface, or open its window; named: the cycles to ban and to keep. open_file: reads
    other networks in the window; None for no window. up: what is upright."""
    from patterndb_app.cli.obj import write_surface
    from patterndb_sketch.curvenetwork.naming import named_cycle
    from viewer.surfacing import SurfacingState, draw, look_from, show

    toward, upright = look_from(up)
    banned, added = ([named_cycle(drawing.network, names) for names in group] for group in named)
    # The window can go on to other methods; a picture has the one that was asked for.
    patterns = open_file is not None or METHODS[request.method].needs_database
    with open_database(db) if patterns else nullcontext() as database:
        make_state = partial(
            SurfacingState,
            settings=request,
            spacing=request.spacing,
            db=database,
            afresh=afresh,
            toward=toward,
            up=upright,
        )
        if picture is not None:
            draw(make_state(drawing, added=added, banned=banned), picture)
            say(f"drawn: {picture}")
        if open_file is not None:
            with hushed():
                show(
                    make_state(drawing, added=added, banned=banned),
                    write_obj=write_surface,
                    open_file=lambda path: make_state(open_file(path)),
                )


HEADS = (
    "patch",
    "method",
    "candidates",
    "chosen",
    "sub-problems",
    "ms",
    "pieces",
    "area",
    "intersections",
    "curves",
)


def _cycles(
    network: CurveNetwork,
    afresh: bool,
    ban: tuple[tuple[str, ...], ...],
    keep: tuple[tuple[str, ...], ...],
) -> tuple[tuple[Cycle, ...], FoundCycles | None]:
    """The cycles to surface, and how they were found if the file does not give them."""
    from patterndb_sketch.curvenetwork.naming import named_cycle
    from patterndb_sketch.surfacing import find_cycles

    banned = [named_cycle(network, names) for names in ban]
    kept = [named_cycle(network, names) for names in keep]
    if afresh or not network.cycles:
        found = find_cycles(network, added=kept, banned=banned)
        return found.cycles, found
    keys = {cycle.key for cycle in network.cycles}
    for cycle in banned:
        if cycle.key not in keys:
            say(f"--ban {_named(network, cycle)}: the file has no such cycle")
    refused = {cycle.key for cycle in banned}
    cycles = [cycle for cycle in network.cycles if cycle.key not in refused]
    cycles += [cycle for cycle in kept if cycle.key not in keys]
    return tuple(cycles), None


def _summarise_cycles(network: CurveNetwork, found: FoundCycles) -> dict[str, object]:
    """What the search for cycles has to say, curves by their ids."""

    def ids(curves: Sequence[int]) -> list[object]:
        return list(dict.fromkeys(network.curves[curve].id for curve in curves))

    return {
        "candidate_cycles": found.candidates,
        "dangling": ids(found.dangling),
        "unused": ids(found.unused),
        "once": ids(found.once),
        "proven": found.proven,
        "orientable": found.orientable,
    }


def _list_joins(drawing: Drawing) -> dict[str, object]:
    """Joins of curves that do not meet exactly, and loose ends, by curves, places and gaps."""
    return {
        "joins": [
            {"curves": list(join.curves), "place": join.place.tolist(), "gap": join.gap}
            for join in drawing.joins
        ],
        "loose_ends": [
            {
                "curve": end.curve,
                "place": end.place.tolist(),
                "nearest": end.other,
                "gap": end.gap,
            }
            for end in drawing.loose
        ],
    }


def _say_joins(drawing: Drawing) -> None:
    """Report the widest joins and the loose ends that are farthest off, one a line."""
    joins = [
        f"joined: {join.curves[0]} and {join.curves[1]}, {join.gap:.3g} apart at "
        f"{_place(join.place)}"
        for join in drawing.joins
    ]
    loose = [
        f"loose end: {end.curve} at {_place(end.place)}, {end.gap:.3g} from {end.other}"
        for end in drawing.loose
    ]
    for lines, more in ((joins, "narrower join"), (loose, "nearer loose end")):
        for line in lines[:MOST_JOINS]:
            say(line)
        if len(lines) > MOST_JOINS:
            say(f"{plural(len(lines) - MOST_JOINS, more)}; --json lists all")


def _place(place: Points) -> str:
    return ", ".join(f"{x:.4g}" for x in place.tolist())


def _say_found(found: FoundCycles, seconds: float) -> None:
    say(
        f"{plural(len(found.cycles), 'cycle')} found among "
        f"{plural(found.candidates, 'candidate')} in {seconds:.2f} s; "
        f"{plural(len(found.once), 'curve')} with a patch on one side, "
        f"{len(found.unused) + len(found.dangling):,} with none"
    )
    for note in found.notes:
        say(note)


def _list_openings(network: CurveNetwork, openings: Openings) -> dict[str, object]:
    """What is open: curves that bound no patch, and rims, by their ids and places."""

    def ends(curve: int) -> list[list[float]]:
        return network.curves[curve].points[[0, -1]].tolist()

    return {
        "bound_nothing": [
            {"curve": network.curves[curve].id, "from": start, "to": end}
            for curve in openings.idle
            for start, end in [ends(curve)]
        ],
        "open_rims": [
            {
                "curves": rim.list_names(network),
                "closed": rim.closed,
                "length": rim.length,
                "nodes": [network.nodes[network.ends(step)[0]].tolist() for step in rim.steps],
            }
            for rim in openings.rims
        ],
    }


def _say_openings(network: CurveNetwork, openings: Openings) -> None:
    if openings.idle:
        names = ",".join(map(str, openings.name_idle(network)))
        say(f"{plural(len(openings.idle), 'curve')} without a patch: {shorten(names, NAMES_WIDTH)}")
    # A hole that was meant to be closed is a short rim, the outline a long one.
    for rim in openings.rims[:MOST_RIMS]:
        names = ",".join(map(str, rim.list_names(network)))
        say(
            f"open rim of {plural(len(rim.steps), 'curve')}, {rim.length:.4g} long: "
            f"{shorten(names, NAMES_WIDTH)}"
        )
    if len(openings.rims) > MOST_RIMS:
        more = len(openings.rims) - MOST_RIMS
        say(f"{plural(more, 'longer open rim')}; --json lists all, --picture marks them")


def _named(network: CurveNetwork, cycle: Cycle) -> str:
    return ",".join(str(name) for name in network.names(cycle))


def _patch(made: Surfacing, patch: SurfacePatch) -> dict[str, object]:
    document: dict[str, object] = {
        "cycle": made.network.names(patch.cycle),
        "method": patch.method,
        "note": patch.note,
    }
    result = patch.surface
    if result is None:
        return document
    return document | {
        "candidates": result.candidates,
        "costly": result.costly,
        "unmatched": result.unmatched,
        "chosen": len(result.chords),
        "chords": made.points[patch.chords].tolist(),
        "subproblems": result.n_subproblems,
        "cost": None if result.cost != result.cost else result.cost,
        "seconds": round(result.seconds, 6),
        "pieces": len(patch.faces),
        "faces": sum(map(len, patch.faces)),
        "area": result.area,
        "turned_corners": result.turned,
        "self_intersections": result.self_intersections,
    }


def _row(network: CurveNetwork, number: int, patch: SurfacePatch) -> tuple[object, ...]:
    names = shorten(_named(network, patch.cycle), CURVES_WIDTH)
    result = patch.surface
    if result is None:
        return number, "none", 0, 0, 0, "", 0, "", 0, names
    return (
        number,
        result.method,
        result.candidates,
        len(result.chords),
        result.n_subproblems,
        f"{1e3 * result.seconds:.2f}",
        len(patch.faces),
        f"{result.area:.4g}",
        result.self_intersections,
        names,
    )


def _say_made(made: Surfacing, seconds: float) -> None:
    for number, patch in enumerate(made.patches, 1):
        if patch.note:
            say(f"patch {number}: {patch.note}")
    for note in made.notes:
        say(note)
    faces = sum(len(piece) for patch in made.patches for piece in patch.faces)
    say(
        f"{plural(len(made.patches), 'patch', 'patches')}, {plural(faces, 'face')}, area "
        f"{made.area:.6g}, in {seconds:.2f} s"
    )
    if made.has_quads:
        counts = _count_quads(made)
        say(
            f"{plural(counts['irregular'], 'irregular vertex', 'irregular vertices')} inside, "
            f"{plural(counts['turned_corners'], 'quad')} with a turned corner"
        )
    within = sum(patch.surface.self_intersections for patch in made.patches if patch.surface)
    if within or made.intersections:
        say(
            f"faces that pass through each other: {plural(within, 'pair')} within patches, "
            f"{made.intersections:,} between patches; the method does not exclude them"
        )
    for i, j, pairs in made.crossings[:MOST_CROSSINGS]:
        say(
            f"patches {i + 1} and {j + 1} pass through each other: {plural(pairs, 'pair')} of faces"
        )
    if len(made.crossings) > MOST_CROSSINGS:
        more = len(made.crossings) - MOST_CROSSINGS
        say(f"{plural(more, 'more pair')} of patches pass through each other; --json lists all")
