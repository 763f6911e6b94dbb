"""The verb that finds and fills the holes of a mesh: holes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click
from msgspec import Meta

from patterndb.errors import InvalidMeshError, NotFoundError, PatternDBError
from patterndb.system.deadline import extend_deadline, is_late, run_until_late
from patterndb.system.documents import parse_json
from patterndb.system.files import read_lines
from patterndb.system.requests import list_changed
from patterndb_app.cli.failure import EXIT_BAD_INPUT, EXIT_NOTHING
from patterndb_app.cli.options import (
    Count,
    DatabaseChoice,
    FileName,
    FileToWrite,
    MeshName,
    Parsed,
    as_json,
    dbs_to_read,
    limit_command,
    may_overwrite,
    open_database,
    output_option,
    picture_option,
    rank_option,
    read_options,
    request_options,
    time_limit_option,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.search import describe_stop
from patterndb_app.cli.text import plural, say, table, write, write_json
from query.errors import InvalidQueryError
from query.holes.options import HoleRequest

if TYPE_CHECKING:
    from patterndb.core.polygonmesh import PolygonMesh
    from patterndb.store import Database, DatabaseUnion
    from query import Stroke
    from query.holes import Hole, HoleFill, HoleFills, MeshTopology
    from query.holes.parity import FixKind

#: A line of a batch file longer than this is no question about a hole.
LONGEST_LINE = 1_000_000

#: Fills of a hole that are listed unless told otherwise.
LISTED = 20

#: Numbers that --loop and --faces may name.
MOST_NUMBERS = 1_000_000

FIXES = ("triangle", "edge-loop", "split", "merge")


def _parse_indices(text: str) -> tuple[int, ...]:
    found: list[int] = []
    for part in text.replace(" ", "").split(","):
        match = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?", part)
        if match is None:
            raise ValueError(f"{part!r} is no number and no range; write 3,17,20-25")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise ValueError(f"the range {part} runs backwards; write {last}-{first}")
        if len(found) + last - first >= MOST_NUMBERS:
            raise ValueError(f"more than {MOST_NUMBERS:,} numbers")
        found.extend(range(first, last + 1))
    return tuple(found)


#: Whole numbers and ranges of them with commas between: 3,17,20-25.
INDICES = Parsed("n,n-n,...", _parse_indices, has_commas=True)


def _parse_corners(text: str) -> dict[int, int]:
    found: dict[int, int] = {}
    for part in text.replace(" ", "").split(","):
        match = re.fullmatch(r"([0-9]{1,9}):([1-4])", part)
        if match is None:
            raise ValueError(f"{part!r} is no vertex with 1 to 4 quads; write 17:1,23:3")
        found[int(match[1])] = int(match[2])
    return found


#: Quads at vertices, 17:1,23:3.
VERTEX_CORNERS = Parsed("v:k,...", _parse_corners, has_commas=True)


def _parse_flow(text: str) -> tuple[int, int] | str:
    match = re.fullmatch(r"([0-9]{1,9})-([0-9]{1,9})", text.strip())
    if text == "loop":
        return text
    if match is None:
        raise ValueError(
            f"{text!r} is no strand like 17-23, from the edge after vertex 17 to that after 23, "
            "and not loop"
        )
    return int(match[1]), int(match[2])


#: A strand between two edges of a loop, named by the vertices where they begin, or "loop".
VERTEX_FLOW = Parsed("v-w|loop", _parse_flow)


class HoleQuestion(HoleRequest, frozen=True, kw_only=True, forbid_unknown_fields=False):
    """A line of a batch file, with how the fill is to lie. Other entries of a line are ignored."""

    mesh: Annotated[str, Meta(extra={"missing": "the name of a mesh file"})]
    loop: list[int] | None = None
    faces: list[int] | None = None


@click.command(
    cls=SectionedCommand,
    sections={
        "Which hole": ("--loop", "--faces", "--all", "--odd", "--batch"),
        "What fills it": ("--corners", "--flow", "--no-twin", "--ngon", "--db"),
        "How it lies": ("--shape", "--tension", "--surface"),
        "What is given": (
            "--rank",
            "--limit",
            "--time-limit",
            "--output",
            "--picture",
            "--overwrite",
            "--json",
        ),
    },
)
@click.argument("mesh", type=FileName(), required=False)
@output_option(FileToWrite(".obj", ".ply", ".off"), "The whole mesh with the hole filled.")
@click.option(
    "--loop",
    "loops",
    type=INDICES,
    multiple=True,
    help="Vertices of the hole's rim, one or more, from 0. May be given again: several holes.",
)
@click.option("--faces", type=INDICES, help="Faces to replace instead, from 0.")
@click.option("--all", "every", is_flag=True, help="Fill every hole, each with its best fill.")
@rank_option("Take the K-th fill.")
@click.option(
    "--limit",
    type=Count(1),
    metavar="K",
    help=f"List at most K fills of a hole.  [default: {LISTED}]",
)
@click.option(
    "--corners",
    type=VERTEX_CORNERS,
    help="Quads inside the hole at boundary vertices: 1 for a corner, 2, 3 or 4.",
)
@click.option(
    "--flow",
    "flows",
    type=VERTEX_FLOW,
    multiple=True,
    help="A strand from the rim's edge after vertex V to that after W, or a loop of quads; may be "
    "given again.",
)
@click.option(
    "--odd",
    type=click.Choice(FIXES),
    help="How to fill holes with an odd number of edges, which quads alone cannot.",
)
@request_options(HoleRequest)
@click.option("--surface", type=MeshName(), metavar="FILE", help="Lay new vertices on this mesh.")
@picture_option("Draw the mesh before and after.")
@click.option(
    "--batch",
    type=FileName(),
    metavar="FILE",
    help='Questions, one a line: {"mesh": "a.obj", "loop": [3, 17]}, or with "faces". One JSON '
    "document a line out.",
)
@may_overwrite
@dbs_to_read
@time_limit_option
@as_json
def holes(
    mesh: Path | None,
    output: Path | None,
    loops: tuple[tuple[int, ...], ...],
    faces: tuple[int, ...] | None,
    every: bool,
    rank: int,
    limit: int | None,
    corners: dict[int, int] | None,
    flows: tuple[tuple[int, int] | str, ...],
    odd: FixKind | None,
    surface: Path | None,
    picture: Path | None,
    batch: Path | None,
    db: DatabaseChoice,
    time_limit: float | None,
    as_json: bool,
    **given: Any,
) -> int:
    """Fill holes of a mesh with quads, joined vertex for vertex, as an artist would.

    With MESH alone its holes are listed: edges, place, size, and a vertex to name each by. With a
    hole named its fills are, best first; -o writes the whole mesh with one of them. A mesh with a
    single hole needs no name; of several holes each gets its best fill, in one mesh. A list of
    faces is replaced.

    Old vertices and faces stay as they are, in their order; new ones come after. Vertices and faces
    count from 0. Where the mesh is symmetric and the other side has no hole, its mirror image
    comes first. Of several holes those that are mirror images of each other get the same fill.

    Exit code 1 where a mesh has no hole, 3 where no quads fit: an odd number of edges, an island.

    \b
    patterndb holes head.obj
    patterndb holes head.obj --loop 211
    patterndb holes head.obj --loop 211 -o filled.obj --rank 2 --picture filled.png
    patterndb holes head.obj --faces 12-40,57 -o anew.obj --json
    patterndb holes head.obj --loop 211 --loop 36 -o filled.obj
    patterndb holes torso.obj --all -o closed.obj
    patterndb holes --batch questions.jsonl --limit 5
    """
    if (mesh is None) == (batch is None):
        raise click.UsageError("name a mesh, or a file of questions with --batch")
    asked = _read_request(given)
    if batch is not None:
        others = [output, faces, corners, surface, picture, odd]
        if every or loops or flows or rank > 1 or any(value is not None for value in others):
            raise click.UsageError(
                "--batch goes with --limit, --time-limit, --no-twin, --ngon, --shape, --tension "
                "and --db alone"
            )
        with limit_command(time_limit), open_database(db) as database:
            listed = {"limit": limit or LISTED, **list_changed(asked)}
            return _answer_batch(database, batch, listed)
    assert mesh is not None
    click.get_current_context().with_resource(limit_command(time_limit))
    if sum([bool(loops), faces is not None, every]) > 1:
        raise click.UsageError("--loop, --faces and --all exclude each other")
    several = every or len(loops) > 1
    if several and (rank > 1 or corners or flows):
        raise click.UsageError(
            f"{'--all' if every else 'more than one --loop'} takes the best fill of each hole; "
            "leave --rank, --corners and --flow out"
        )
    if surface is not None and (asked.shape == "flat" or asked.tension):
        raise click.UsageError("fills lie on --surface; leave --shape flat and --tension out")
    if asked.ngon and (corners or flows or odd or surface is not None):
        raise click.UsageError(
            "an n-gon has no quads and takes an odd number of edges; leave --corners, --flow, "
            "--odd and --surface out"
        )
    # Imported here because --help need not wait for it.
    from ingest.formats import read_mesh
    from query.holes import MeshTopology, find_holes, list_mesh_flaws

    topology = run_until_late(lambda: MeshTopology.of(read_mesh(mesh)), f"{mesh} was read")
    notes = list_mesh_flaws(topology)
    named = loops or faces is not None or every
    chosen_way = asked.is_laid or asked.ngon
    if not (named or output or picture or limit or corners or flows or odd or chosen_way):
        found = run_until_late(lambda: find_holes(topology), "the holes were found")
        if as_json:
            document = {"mesh": str(mesh), "holes": [hole.to_json() for hole in found]}
            write_json(document | {"notes": notes})
        elif found:
            _list_holes(found)
        _say_flaws(mesh, notes)
        return 0 if found else EXIT_NOTHING
    writing = output is not None or picture is not None
    most = max(rank, limit or (rank if writing and not as_json else LISTED))
    options: dict[str, Any] = {
        "limit": 1 if several and not limit else most,
        **list_changed(asked),
    }
    if surface is not None:
        from patterndb.geometry.surface import Surface

        options["surface"] = Surface.from_polygons(read_mesh(surface))
    chosen, left = run_until_late(
        lambda: _choose_holes(topology, loops, faces, every, odd, asked.ngon),
        "the holes were found",
    )
    with open_database(db) as database:
        answered, open_ones = _answer(database, chosen, corners or {}, flows, options)
    left += open_ones
    if not several and not answered[0][1] and corners:
        raise NotFoundError(
            f"no fill was found that has the quads of --corners at all {len(corners)} vertices"
            f"{describe_stop(answered[0][0])}; fix fewer corners, or give other numbers"
        )
    if not several and len(answered[0][1]) < rank:
        count = plural(len(answered[0][1]), "fill")
        raise NotFoundError(
            f"no fill {rank} of the hole was found, only {count}{describe_stop(answered[0][0])}"
        )
    if not any(listed for _, listed in answered):
        raise NotFoundError("; ".join(["no hole was filled", *left]))
    fills = [listed[rank - 1] for _, listed in answered if len(listed) >= rank]
    _write(fills, output, picture)
    if as_json:
        documents = [found.to_json(listed) for found, listed in answered]
        write_json({"mesh": str(mesh), "holes": documents, "left": left, "notes": notes})
    elif not writing:
        for found, listed in answered:
            _list_fills(found, listed)
    if writing:
        for fill, (found, _) in zip(fills, answered, strict=True):
            _tell(fill, found)
    _say_flaws(mesh, notes)
    for told in left:
        say(f"left open: {told}")
    for doing, path in (("written", output), ("drawn", picture)):
        if path is not None:
            say(f"{doing}: {path}")
    return 0


def _choose_holes(
    topology: MeshTopology,
    loops: tuple[tuple[int, ...], ...],
    faces: tuple[int, ...] | None,
    every: bool,
    odd: FixKind | None,
    ngon: bool,
) -> tuple[list[Hole], list[str]]:
    """Find the holes that are meant, made even by --odd; and what --all leaves open."""
    from query.holes import choose_hole, find_holes, list_parity_fixes
    from query.holes.topology import explain_closed

    if len(loops) > 1:
        # Two names of one hole are one hole.
        named = {int(hole.loop[0]): hole for hole in (choose_hole(topology, loop=x) for x in loops)}
        rims: list[set[int]] = [set(hole.loop.tolist()) for hole in named.values()]
        if odd is None:
            return list(named.values()), []
        found = find_holes(_make_even_all(topology, odd, {v for rim in rims for v in rim}))
        # A vertex of a rim may be gone, so that each is known by what is left of it.
        return [
            max(found, key=lambda one: len(rim.intersection(one.loop.tolist()))) for rim in rims
        ], []
    if every and odd is not None:
        topology = _make_even_all(topology, odd, None)
    if not every:
        hole = choose_hole(topology, loop=loops[0] if loops else None, faces=faces)
        return [_make_even(hole, odd) if odd and len(hole) % 2 else hole], []
    chosen: list[Hole] = []
    left: list[str] = []
    holes = find_holes(topology)
    if not holes:
        raise NotFoundError(explain_closed(topology))
    for hole in holes:
        where = f"the hole of {plural(len(hole), 'edge')} at vertex {int(hole.loop[0])}"
        try:
            chosen.append(choose_hole(hole))
        except PatternDBError as error:
            left.append(f"{where}: {error}")
            continue
        if len(hole) % 2 and not ngon:
            kinds = ", ".join(fix.kind for fix in list_parity_fixes(hole)) or "none"
            left.append(f"{where}: an odd number; ways out that --odd takes: {kinds}")
            chosen.pop()
    if not chosen:
        raise NotFoundError("; ".join(["there is no hole that quads can fill", *left]))
    return chosen, left


def _make_even_all(topology: MeshTopology, kind: FixKind, among: set[int] | None) -> MeshTopology:
    """Apply parity fixes of a kind to odd loops (through these vertices), and print them."""
    from query.holes import make_loops_even

    topology, descriptions = make_loops_even(topology, kind, among)
    for description in descriptions:
        say(f"made even: {description}")
    return topology


def _make_even(hole: Hole, kind: str) -> Hole:
    """Apply the best parity fix of a kind, and print it."""
    from query.holes import list_parity_fixes

    fixes = list_parity_fixes(hole)
    for fix in fixes:
        if fix.kind == kind:
            say(f"made even: {fix.description}")
            return fix.apply()
    there = ", ".join(fix.kind for fix in fixes) or "none"
    raise NotFoundError(f"the hole has no way {kind!r}; there is: {there}")


def _answer(
    database: Database | DatabaseUnion,
    chosen: list[Hole],
    corners: dict[int, int],
    flows: tuple[tuple[int, int] | str, ...],
    options: dict[str, Any],
) -> tuple[list[tuple[HoleFills, list[HoleFill]]], list[str]]:
    """The fills of holes, with the iterators that they came from, and which holes stay open."""
    from query.holes import fill_holes

    answered: list[tuple[HoleFills, list[HoleFill]]] = []
    best: list[HoleFill] = []
    left: list[str] = []
    for hole in chosen:
        where = f"the hole of {plural(len(hole), 'edge')} at vertex {int(hole.loop[0])}"
        if answered and is_late():
            left.append(f"{where}: the time limit was over before it was searched")
            continue
        strokes = [_stroke_on(hole, flow) for flow in flows]
        found = fill_holes(database, hole, corners=corners, strokes=strokes, like=best, **options)
        listed = list(found)
        answered.append((found, listed))
        best += listed[:1]
        if not listed:
            left.append(f"{where}: no fill was found{describe_stop(found)}")
    return answered, left


def _write(fills: list[HoleFill], output: Path | None, picture: Path | None) -> None:
    """Write the mesh with the fills, and draw it, some seconds after the time limit at most."""
    with extend_deadline(WRITING_SECONDS if picture is None else DRAWING_SECONDS):
        if output is not None:
            from ingest.formats import write_mesh
            from query.holes import weld_fills

            welded = run_until_late(lambda: weld_fills(fills), "the mesh was welded")
            write_mesh(output, welded)
        if picture is not None:
            from viewer.holes import draw_holes

            run_until_late(lambda: draw_holes(picture, fills), "the picture was drawn")


#: Seconds after the time limit in which the fills that were found may be written; and drawn, which
#: begins with loading VTK.
WRITING_SECONDS, DRAWING_SECONDS = 0.25, 20.0


def _stroke_on(hole: Hole, flow: tuple[int, int] | str) -> Stroke:
    """The strand between two edges of a loop, as a stroke."""
    from query import Stroke

    if isinstance(flow, str):
        return Stroke.loop()
    place = {int(v): i for i, v in enumerate(hole.loop)}
    for v in flow:
        if v not in place:
            raise click.UsageError(f"vertex {v} of --flow is not on the loop")
    return Stroke((0, place[flow[0]]), (0, place[flow[1]]))


def _read_request(given: dict[str, Any]) -> HoleRequest:
    """Return the request; a usage error where options contradict each other."""
    try:
        return HoleRequest(**read_options(HoleRequest, given))
    except InvalidQueryError as error:
        raise click.UsageError(str(error)) from None


def _answer_batch(database: Database | DatabaseUnion, path: Path, options: dict[str, Any]) -> int:
    """Answer questions, a line each; how a line's fill is to lie replaces what is asked of all.

    Returns the exit code: that of bad input if a line could not be read, that of nothing found if a
    hole could not be filled.
    """
    from ingest.formats import read_mesh
    from query.batchline import read_id
    from query.holes import MeshTopology, fill_holes

    asked = unreadable = unanswered = 0
    last: tuple[str, MeshTopology] | None = None
    for number, line in read_lines(path, LONGEST_LINE, InvalidMeshError):
        asked += 1
        try:
            question = _read_question(line, options)
            if is_late():
                unanswered += 1
                write_json({"line": number, "mesh": question.mesh, "holes": [], **NOT_ASKED})
                continue
            if last is None or last[0] != question.mesh:
                mesh: PolygonMesh = read_mesh(_beside(path, question.mesh))
                last = question.mesh, MeshTopology.of(mesh)
            found = fill_holes(
                database,
                last[1],
                loop=question.loop,
                faces=question.faces,
                **list_changed(question),
            )
            fills = list(found)
        except (PatternDBError, OSError) as error:
            unreadable += 1
            write_json({"line": number, **read_id(line), "error": str(error)})
            continue
        unanswered += not fills
        named = {"line": number, **read_id(line), "mesh": question.mesh}
        write_json({**named, "holes": [found.to_json(fills)]})
    say(
        f"{plural(asked, 'question')}, {unanswered} without a fill, "
        f"{unreadable} that could not be answered"
    )
    if unreadable:
        return EXIT_BAD_INPUT
    return EXIT_NOTHING if unanswered else 0


#: The end of the answer to a line of a batch that comes after the time limit.
NOT_ASKED: dict[str, object] = {
    "stopped": "time limit",
    "complete": False,
    "reason": "the time limit was over before this hole was searched; allow more seconds",
}


def _read_question(line: bytes, options: dict[str, Any]) -> HoleQuestion:
    """A line of a batch file, with how the fills of all are to lie where it has no such entries."""
    document = parse_json(line, InvalidMeshError, "a question")
    if document.is_object:
        entries = {name: entry.value for name, entry in document.entries().items()}
        document = replace(document, value={**options, **entries})
    return document.read(HoleQuestion)


def _beside(batch: Path, name: str) -> Path:
    """A mesh that a batch names: beside the batch file, or as seen from here."""
    near = batch.parent / name
    return near if near.exists() else Path(name)


def _say_flaws(mesh: Path, notes: Sequence[str]) -> None:
    for note in notes:
        say(f"{mesh}: {note}")


def _list_holes(found: list[Hole]) -> None:
    rows = [
        (
            len(hole),
            # What rounding left of a zero would be different elsewhere.
            " ".join(f"{x if abs(x) > 1e-9 * hole.length else 0.0:.4g}" for x in hole.centre),
            f"{hole.length:.4g}",
            str(hole.loop[0]),  # a name, to be typed: no commas
        )
        for hole in found
    ]
    write(table(("edges", "around", "length", "--loop"), rows))


def _list_fills(found: HoleFills, fills: list[HoleFill]) -> None:
    where = f"hole of {plural(len(found.hole), 'edge')} at vertex {int(found.hole.loop[0])}"
    say(f"{where}: {plural(len(fills), 'fill')} in {found.seconds:.2f} s{describe_stop(found)}")
    if not fills:
        return
    rows = [
        (
            number,
            fill.pattern,
            fill.origin,
            fill.n_quads,
            fill.n_irregular,
            fill.flipped,
            f"{fill.score:.2f}" if isfinite(fill.score) else "",
        )
        for number, fill in enumerate(fills, 1)
    ]
    head = ("--rank", "pattern", "origin", "quads", "irregular", "flipped", "score")
    write(table(head, rows))


def _tell(fill: HoleFill, found: HoleFills) -> None:
    what = "a mirror twin" if fill.twin else f"pattern {fill.pattern} ({fill.origin})"
    what += f", {plural(fill.n_quads, 'quad')}"
    if fill.ngon is not None:
        what = f"one face of {len(fill.ngon)} corners"
    flipped = f", {plural(fill.flipped, 'flipped quad')}" if fill.flipped else ""
    flat = ", flat" if fill.flat else ""
    say(
        f"hole of {plural(len(fill.hole), 'edge')} at vertex {int(fill.hole.loop[0])}: {what}, "
        f"{plural(fill.n_irregular, 'irregular vertex', 'irregular vertices')}{flipped}{flat}, "
        f"found in {found.seconds:.2f} s"
    )
