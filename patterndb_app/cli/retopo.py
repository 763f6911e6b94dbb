"""The verb that retopologises a surface: retopo."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from patterndb.system.extras import require_extra
from patterndb.system.files import open_regular
from patterndb.system.knownfiles import KnownFiles
from patterndb.system.requests import list_changed
from patterndb_app.cli.options import (
    OBJ,
    DatabaseChoice,
    FileName,
    FileToWrite,
    MeshName,
    as_json,
    dbs_to_read,
    is_given,
    list_flags,
    may_overwrite,
    open_database,
    output_option,
    picture_option,
    read_options,
    refuse_input,
    request_options,
    view_option,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.progressline import hushed
from patterndb_app.cli.text import plural, say, table, write, write_json
from patterndb_sketch.retopo.draft.task import DraftRequest

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from patterndb.store import Database, DatabaseUnion
    from patterndb_sketch.retopo.editor import Outcome, Retopology
    from patterndb_sketch.retopo.filling import FilledNetwork, RetopoMesh
    from patterndb_sketch.retopo.filling.report import Report
    from patterndb_sketch.retopo.script import Script, ScriptLine
    from patterndb_sketch.retopo.session import RetopoSession


class RetopoCommand(SectionedCommand):
    """The verb, whose help lists the tools of a script."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the tools and what they do; docs/retopo.md has their arguments."""
        # Imported here because the table imports every tool.
        from patterndb_sketch.retopo.table import TOOLS

        with formatter.section("Tools (docs/retopo.md has their arguments)"):
            formatter.write_dl([(name, tool.help) for name, tool in TOOLS.items()])


@click.command(
    cls=RetopoCommand,
    sections={
        "Input": ("--script", "--lenient", "--session", "--from-quads", "--db"),
        "Draft": ("--draft", *list_flags(DraftRequest, "draft")),
        "Output": (
            "-o",
            "--record",
            "--picture",
            "--overwrite",
            "--sides",
            "--view",
            "--exports-anywhere",
            "--json",
        ),
    },
)
@click.argument("surface", type=MeshName(), required=False)
@click.option("--script", type=FileName(), metavar="FILE", help="The script to play, JSON lines.")
@click.option(
    "--session",
    type=FileToWrite(".retopo", reads=True),
    metavar="FILE",
    help="Go on from this session if it is there, and save to it at the end; .retopo.",
)
@output_option(OBJ, "The mesh at the end, OBJ.")
@picture_option("Draw curves and quads into a PNG, without a window.")
@click.option(
    "--sides",
    metavar="SIDES",
    help="Sides that the picture shows, next to each other, such as front,left,top: home (over the "
    "left front), front, back, left, right, top, bottom.  [default: home]",
)
@click.option(
    "--from-quads",
    is_flag=True,
    help="SURFACE is a mesh of quads: begin from its regular grids. A few triangles and larger "
    "faces may be among them, and stay as they are.",
)
@click.option(
    "--draft",
    is_flag=True,
    help="Begin with a network proposed by the machine, on all of SURFACE that has no patches yet.",
)
@request_options(DraftRequest)
@view_option("Open the window at the end; so does a SURFACE with nothing else to do.")
@click.option(
    "--record",
    type=FileToWrite(".jsonl"),
    metavar="FILE",
    help="Write what was done, in the script and in the window, as a script.",
)
@click.option(
    "--lenient", is_flag=True, help="Go on after a call that is refused, and say what was."
)
@click.option(
    "--exports-anywhere",
    is_flag=True,
    help="Let the script write outside its own folder; for scripts that you trust.",
)
@dbs_to_read
@may_overwrite
@as_json
def retopo(
    surface: Path | None,
    script: Path | None,
    session: Path | None,
    output: Path | None,
    picture: Path | None,
    sides: str | None,
    from_quads: bool,
    draft: bool,
    view: bool,
    record: Path | None,
    lenient: bool,
    exports_anywhere: bool,
    db: DatabaseChoice,
    as_json: bool,
    **given: Any,
) -> int:
    """Make a clean quad mesh on a surface, from curves drawn on it.

    SURFACE is a mesh of triangles, or of polygons, which are cut into triangles; left out, it
    is the one that the script names. Alone, it opens in a window; F1 lists commands and keys. A
    script is a line of JSON for each tool that is used:

    \b
    {"tool": "open", "surface": "spot.obj"}
    {"tool": "loop", "at": [0, 0.1, 0.3], "normal": [0, 0, 1]}
    {"tool": "stroke", "points": [[0, 0.1, 0.3], [0.1, 0.2, 0.3]]}
    {"tool": "export", "mesh": "quads.obj"}

    Loops of curves become patches, which are filled from the database; counts of edges are
    chosen so that all can be. The same script gives the same mesh.

    A session holds the surface and all that was drawn. Where it is there already it is opened:
    SURFACE may be left out then, or is the same. A script that goes on from one names the same
    surface, and its calls come after what is there. What is refused stops the script, and
    the session stays as it was.

    With --json, open_loops tells where no patch is yet: of each loop the number of corners, a
    point on it, and one further on, with the empty side on the left.

    Exit code 1 where there is no quad at the end, 3 for a script that is not what it must be,
    or a call that is refused.

    \b
    patterndb retopo spot.obj --draft -o spot-draft.obj
    patterndb retopo part.obj --draft --quads 1500 -o part-draft.obj
    patterndb retopo spot.obj --session spot.retopo
    patterndb retopo --script spot.jsonl -o spot-quads.obj
    patterndb retopo --script legs.jsonl --session spot.retopo --picture legs.png
    patterndb retopo --session spot.retopo --picture spot.png --sides front,back,left,top
    patterndb retopo --session spot.retopo -o spot-quads.obj
    patterndb retopo cage.obj --from-quads --record edits.jsonl
    """
    asked = RetopoRequest(surface, script, session, from_quads)
    asked.check()
    wanted_draft = read_draft(given) if draft else refuse_draft(given)
    if draft and from_quads:
        raise click.UsageError("--from-quads gives patches all over; leave --draft out")
    nothing_else = script is None and output is None and picture is None and not as_json
    nothing_else = nothing_else and not (draft and session is not None)
    view = view or nothing_else
    for path in (surface, script):
        if path is not None:
            # A file that is not there is the first thing to report.
            open_regular(path).close()
    require_extra("sketch", "retopology")
    if view:
        # Imported here because no verb without a window needs it.
        from viewer.shell.probe import check_display

        check_display()
    if view and as_json:
        raise click.UsageError("--json tells what a script made; leave it or --view out")
    shown = _read_sides(sides, picture)
    if lenient and script is None:
        raise click.UsageError("--lenient is about a script's calls; give a --script")
    if record is not None and asked.goes_on:
        raise click.UsageError(
            f"a script tells all from the beginning, and {session} is from before; leave "
            "--record out, or begin another session"
        )
    # Imported here because --help need not wait for it.
    from patterndb_sketch.recovery import find_recoveries
    from patterndb_sketch.retopo.quadimport import refuse_losses
    from patterndb_sketch.retopo.script import Script, read_script, write_script
    from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession

    known = KnownFiles()
    if session is not None:
        known.note(session)
    wanted = None if script is None else read_script(script)
    refused: list[tuple[ScriptLine, Outcome]] = []
    done: list[ScriptLine] = []
    with open_database(db) as database:
        start = begin_retopo(asked, wanted, database)
        editor, name = start.editor, Path(start.name).name
        for one in find_recoveries(session):
            say(
                f"a crash left work on this session: {one.path}; rename it to end in .retopo to "
                "read it, or press R in the window"
            )
        say(f"{name}: {plural(len(start.surface.triangles), 'triangle')}")
        if start.surface.repairs.turned:
            turned = plural(start.surface.repairs.turned, "triangle")
            say(f"{turned} turned over, to face as all others do")
        began = perf_counter()
        drafted = [_make_draft(editor, wanted_draft)] if wanted_draft else []
        if wanted is not None and script is not None:
            done, refused = _play_script(wanted, editor, script, lenient, exports_anywhere)
        found = editor.fill()
        seconds = perf_counter() - began
        said = Script(start.name, (*drafted, *done), start.quads)
        if view:
            _look(editor, name, session, record, said, known)
            found = editor.fill()
        mesh = editor.mesh(found)
        if session is not None and (wanted is not None or draft) and not view:
            made_session = RetopoSession(start.surface, editor.state, name)
            known.save(session, lambda: RETOPO_SESSION.write(session, made_session))
            say(f"written: {session}")
        if record is not None and not view:
            write_script(record, said)
            say(f"written: {record}")
        if output is not None:
            refuse_losses(found)
            _write(output, mesh)
            say(f"written: {output}")
        if picture is not None:
            from viewer.retopo import draw

            draw(editor, picture, title=name, sides=shown)
            say(f"drawn: {picture}")
    for note in found.notes:
        say(note)
    if nothing_else:
        return 0
    from patterndb_sketch.retopo.filling.report import find_open_loops, report_mesh

    made = report_mesh(found, start.surface, mesh)
    if as_json:
        document: dict[str, object] = {
            "surface": start.name,
            "triangles": len(start.surface.triangles),
            "calls": 0 if wanted is None else len(wanted.lines),
            "refused": [
                {"line": line.number, "tool": line.call.tool, "why": outcome.refused}
                for line, outcome in refused
            ],
            **asdict(made),
            "open_loops": [asdict(loop) for loop in find_open_loops(found.network)],
            "seconds": round(seconds, 6),
            "notes": list(found.notes),
            "output": None if output is None else str(output),
            "session": None if session is None else str(session),
        }
        write_json(document)
    else:
        write(table(("what", "value"), _rows(made, seconds)))
    return 0 if made.quads else 1


def _read_sides(sides: str | None, picture: Path | None) -> tuple[str, ...]:
    """The sides of a picture by name; UsageError for one there is not."""
    if sides is None:
        return ()
    if picture is None:
        raise click.UsageError("--sides are those of a picture; give --picture, too")
    # Imported here because --help need not wait for it.
    from viewer.retopo.pointing import find_side

    found = tuple(side.strip() for side in sides.split(","))
    for side in found:
        try:
            find_side("z", side)
        except ValueError as error:
            raise click.UsageError(f"--sides: {error}") from error
    return found


def _make_draft(editor: Retopology, wanted: DraftRequest) -> ScriptLine:
    """Call the tool; write its notes to stderr, and return the script's line that does the same."""
    from patterndb_sketch.retopo.editor import Call
    from patterndb_sketch.retopo.errors import RefusedError
    from patterndb_sketch.retopo.script import ScriptLine

    call = Call("draft", list_changed(wanted))
    outcome = editor.do(call)
    if outcome.refused is not None:
        raise RefusedError(f"--draft: {outcome.refused}")
    for note in outcome.notes:
        say(f"draft: {note}")
    return ScriptLine(0, call)


def _play_script(
    wanted: Script, editor: Retopology, script: Path, lenient: bool, anywhere: bool
) -> tuple[list[ScriptLine], list[tuple[ScriptLine, Outcome]]]:
    """Play a script; the lines that did something, and those that were refused."""
    from patterndb_sketch.retopo.quadimport import refuse_losses
    from patterndb_sketch.retopo.script import EXPORT, export_path, locate_export, play_script

    for line in wanted.lines:
        if line.call.tool == EXPORT:
            # Refused before anything is done, not in the middle.
            locate_export(script, export_path(line.call), anywhere=anywhere)

    def export(name: str, found: FilledNetwork) -> None:
        path = locate_export(script, name, anywhere=anywhere)
        refuse_losses(found)
        _write(path, editor.mesh(found))
        say(f"written: {path}")

    done: list[ScriptLine] = []
    refused: list[tuple[ScriptLine, Outcome]] = []
    for line, outcome in play_script(wanted, editor, export, lenient=lenient):
        for note in outcome.notes:
            say(f"line {line.number}: {note}")
        if outcome.refused is None:
            done.append(line)
        else:
            say(f"line {line.number}: {line.call.tool}: {outcome.refused}")
            refused.append((line, outcome))
    return done, refused


def _look(
    editor: Retopology,
    title: str,
    session: Path | None,
    record: Path | None,
    said: Script,
    known: KnownFiles,
) -> None:
    """Open the window, until it is closed."""
    from viewer.retopo import show

    with hushed():
        show(
            editor,
            title=title,
            session=session,
            script=record,
            begun=said,
            write_mesh=_write,
            known=known,
        )


def _write(path: Path, mesh: RetopoMesh) -> None:
    from patterndb_app.cli.obj import write_faces

    groups = [f"patch_{number}" for number in mesh.patch.tolist()]
    patches = len(set(groups))
    title = f"quad mesh: {len(mesh.quads)} quads in {plural(patches, 'patch', 'patches')}"
    if mesh.kept:
        title += f", and {plural(len(mesh.kept), 'face')} as given"
        groups += ["given"] * len(mesh.kept)
    write_faces(path, mesh.vertices, [*mesh.quads.tolist(), *mesh.kept], title, groups)


def _say_kept(kept: dict[int, int]) -> str:
    """How many faces were given and stay, by their edges."""
    names = {3: "triangle"}
    return ", ".join(plural(k, names.get(n, f"face of {n}")) for n, k in kept.items())


def _rows(made: Report, seconds: float) -> list[tuple[str, object]]:
    return [
        ("patches", ", ".join(f"{n} with {k}" for k, n in made.patches.items()) or "none"),
        ("quads", made.quads),
        *([("patches without quads", made.unfilled)] if made.unfilled else []),
        *([("faces as given", _say_kept(made.kept))] if made.kept else []),
        ("irregular", ", ".join(f"{n} of {k}" for k, n in made.irregular.items()) or "none"),
        ("flipped", made.flipped),
        ("open edges", made.open_edges),
        ("Euler", made.euler),
        ("to the surface", f"{100 * made.to_surface:.2f} %"),
        ("from the surface", f"{100 * made.from_surface:.2f} %"),
        ("seconds", f"{seconds:.1f}"),
    ]


@dataclass(frozen=True, slots=True)
class RetopoRequest:
    """What the command line says of the beginning."""

    surface: Path | None
    script: Path | None
    session: Path | None
    quads: bool

    @property
    def goes_on(self) -> bool:
        """Is there a session to go on from?"""
        return self.session is not None and self.session.exists()

    def check(self) -> None:
        """UsageError for what does not go together, or is nothing to begin from."""
        if self.goes_on and self.quads and self.surface is None:
            raise click.UsageError(f"{self.session} has begun already; leave --from-quads out")
        if self.surface is None and self.script is None and not self.goes_on:
            there = "no session is given" if self.session is None else f"there is no {self.session}"
            raise click.UsageError(f"nothing to draw on: give a SURFACE or a --script; {there}")


def read_draft(given: Mapping[str, Any]) -> DraftRequest:
    """Return how the surface is to be drafted; a usage error where options contradict others."""
    from patterndb_sketch.retopo.errors import RefusedError

    try:
        return DraftRequest(**read_options(DraftRequest, given))
    except RefusedError:
        raise click.UsageError(
            "--edge and --quads both say how fine a draft is; give one of them"
        ) from None


def refuse_draft(given: Mapping[str, Any]) -> None:
    """Raise UsageError where options of drafts are given without --draft."""
    for name in given:
        if is_given(name):
            raise click.UsageError(f"--{name} is an option of drafts; give --draft, too")


@dataclass(frozen=True, slots=True)
class RetopoBeginning:
    """name: what it is called, in reports and scripts. quads: was it begun from quads?"""

    name: str
    surface: Surface
    editor: Retopology
    quads: bool


def begin_retopo(
    asked: RetopoRequest, script: Script | None, database: Database | DatabaseUnion
) -> RetopoBeginning:
    """An editor as it is before anything is done."""
    from patterndb_sketch.retopo.editor import Retopology
    from patterndb_sketch.retopo.session import RETOPO_SESSION

    if asked.session is not None and asked.goes_on:
        kept = RETOPO_SESSION.read(asked.session)
        if asked.surface is not None:
            _refuse_other_surface(kept, asked, database)
        if script is not None and asked.script is not None:
            _refuse_another(kept, script, asked.script)
        editor = Retopology(kept.surface, database)
        editor.restore(kept.state)
        return RetopoBeginning(kept.name, kept.surface, editor, False)
    path = _path(asked, script)
    quads = asked.quads or (script is not None and script.quads)
    editor = _from_quads(path, database) if quads else Retopology(_read_surface(path), database)
    return RetopoBeginning(str(path), editor.surface, editor, quads)


def _path(asked: RetopoRequest, script: Script | None) -> Path:
    from patterndb_sketch.retopo.script import surface_path

    if asked.surface is not None:
        return asked.surface
    assert script is not None
    assert asked.script is not None
    path = surface_path(script, asked.script)
    refuse_input(path, "the surface of the script")
    return path


def _read_surface(path: Path) -> Surface:
    from ingest.formats import read_mesh
    from patterndb.errors import InvalidMeshError
    from patterndb.geometry.surface import Surface

    mesh = read_mesh(path)
    try:
        return Surface.from_polygons(mesh).orient()
    except InvalidMeshError as error:
        raise InvalidMeshError(f"{path}: {error}") from error


def _from_quads(path: Path, database: Database | DatabaseUnion) -> Retopology:
    from ingest.formats import read_mesh
    from patterndb_sketch.retopo.editor import Retopology
    from patterndb_sketch.retopo.errors import InvalidRetopoError
    from patterndb_sketch.retopo.quadimport import import_quads

    mesh = read_mesh(path)
    quads, places = mesh.quads()
    taken = set(places.tolist())
    others = [face for k, face in enumerate(mesh.faces()) if k not in taken]
    if len(others) > len(quads):
        raise InvalidRetopoError(
            f"{path}: {len(others)} of {mesh.n_faces} faces are not quads; begin from a mesh that "
            "is mostly quads, or leave --from-quads out and draw on it"
        )
    try:
        return Retopology.of_quads(import_quads(mesh.points, quads, others=others), database)
    except InvalidRetopoError as error:
        raise InvalidRetopoError(f"{path}: {error}") from error


def _refuse_other_surface(
    kept: RetopoSession, asked: RetopoRequest, database: Database | DatabaseUnion
) -> None:
    """InvalidRetopoError if the command names another surface than the session has."""
    from patterndb_sketch.retopo.errors import InvalidRetopoError

    path = asked.surface
    assert path is not None
    surface = _from_quads(path, database).surface if asked.quads else _read_surface(path)
    if not kept.surface.is_same(surface):
        raise InvalidRetopoError(
            f"{path} is not the surface of {asked.session}, which was begun on "
            f"{kept.name or 'an unnamed one'}; leave SURFACE out to go on, or name another session"
        )


def _refuse_another(kept: RetopoSession, script: Script, beside: Path) -> None:
    """InvalidRetopoError if a script names another surface than the session has, where it is
    there to be looked at."""
    from patterndb_sketch.retopo.errors import InvalidRetopoError
    from patterndb_sketch.retopo.script import surface_path

    path = surface_path(script, beside)
    if not kept.surface.is_same(_read_surface(path)):
        raise InvalidRetopoError(
            f"{beside}: its surface, {path}, is not the session's, {kept.name or 'unnamed'}; "
            "name the surface that the session was begun on, or another session"
        )
