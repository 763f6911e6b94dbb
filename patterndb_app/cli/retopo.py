"""The verb that retopologises a surface: retopo."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb_app.cli.options import (
    OBJ,
    FileName,
    FileToWrite,
    as_json,
    db_to_read,
    open_database,
    picture_path,
)
from patterndb_app.cli.retopobegin import Asked, begun
from patterndb_app.cli.text import plural, say, table, write, write_json

if TYPE_CHECKING:
    from patterndb_sketch.retopo.editor import Editor, Outcome
    from patterndb_sketch.retopo.filling import FilledNetwork, RetopoMesh
    from patterndb_sketch.retopo.filling.report import Report
    from patterndb_sketch.retopo.script import Script, ScriptLine


@click.command()
@click.argument("surface", type=FileName(), required=False)
@click.option("--script", type=FileName(), metavar="FILE", help="The script to play, JSON lines.")
@click.option(
    "--session",
    type=FileToWrite(".retopo"),
    metavar="FILE",
    help="Go on from this session if it is there, and save to it at the end; .retopo.",
)
@click.option("-o", "--output", type=OBJ, metavar="FILE", help="The mesh at the end, OBJ.")
@click.option(
    "--picture",
    type=picture_path(".png"),
    metavar="FILE",
    help="Draw curves and quads into a PNG, without a window.",
)
@click.option(
    "--quads", is_flag=True, help="SURFACE is a mesh of quads: begin from its regular grids."
)
@click.option(
    "--view",
    is_flag=True,
    help="Open the window at the end; so does a SURFACE with nothing else to do.",
)
@click.option(
    "--record",
    type=FileToWrite(".jsonl"),
    metavar="FILE",
    help="Write what was done, in the script and in the window, as a script.",
)
@click.option(
    "--lenient", is_flag=True, help="Go on after a call that is refused, and say what was."
)
@db_to_read
@as_json
def retopo(
    surface: Path | None,
    script: Path | None,
    session: Path | None,
    output: Path | None,
    picture: Path | None,
    quads: bool,
    view: bool,
    record: Path | None,
    lenient: bool,
    db: Path | None,
    as_json: bool,
) -> int:
    """Make a clean quad mesh on a surface, from curves drawn on it.

    SURFACE is a mesh of triangles, or of polygons, which are cut into triangles; left out, it
    is the one that the script names. Alone, it opens in a window; the key h lists the keys. A
    script is a line of JSON for each tool that is used:

    \b
    {"tool": "open", "surface": "spot.obj"}
    {"tool": "loop", "at": [0, 0.1, 0.3], "normal": [0, 0, 1]}
    {"tool": "stroke", "points": [[0, 0.1, 0.3], [0.1, 0.2, 0.3]]}
    {"tool": "export", "mesh": "quads.obj"}

    Loops of curves become patches, which are filled from the database; counts of edges are
    chosen so that all can be. The same script gives the same mesh.

    A session holds the surface and all that was drawn. A script that goes on from one names the
    same surface, and its calls come after what is there. What is refused stops the script, and
    the session stays as it was.

    With --json, open_loops tells where no patch is yet: of each loop the number of corners, a
    point on it, and one further on, with the empty side on the left.

    Exit code 1 where there is no quad at the end, 3 for a script that is not what it must be,
    or a call that is refused.

    \b
    patterndb retopo spot.obj --session spot.retopo
    patterndb retopo --script spot.jsonl -o spot-quads.obj
    patterndb retopo --script legs.jsonl --session spot.retopo --picture legs.png
    patterndb retopo --session spot.retopo -o spot-quads.obj
    patterndb retopo cage.obj --quads --record edits.jsonl
    """
    asked = Asked(surface, script, session, quads)
    asked.check()
    nothing_else = script is None and output is None and picture is None and not as_json
    view = view or nothing_else
    if view and as_json:
        raise click.UsageError("--json tells what a script made; leave it or --view out")
    if lenient and script is None:
        raise click.UsageError("--lenient is about a script's calls; give a --script")
    if record is not None and asked.goes_on:
        raise click.UsageError(
            f"a script tells all from the beginning, and {session} is from before; leave "
            "--record out, or begin another session"
        )
    # Imported here because compiled kernels take a moment that --help need not wait for.
    from patterndb_sketch.retopo.autosave import find_recoveries
    from patterndb_sketch.retopo.script import Script, read_script, write_script
    from patterndb_sketch.retopo.sessionfile import RetopoSession, write_session

    wanted = None if script is None else read_script(script)
    refused: list[tuple[ScriptLine, Outcome]] = []
    done: list[ScriptLine] = []
    with open_database(db) as database:
        start = begun(asked, wanted, database)
        editor, name = start.editor, Path(start.surface).name
        for one in find_recoveries(session):
            say(
                f"a crash left work on this session: {one.path}; rename it to end in .retopo to "
                "read it, or press R in the window"
            )
        say(f"{name}: {plural(len(start.ground.triangles), 'triangle')}")
        began = time.perf_counter()
        if wanted is not None and script is not None:
            done, refused = _played(wanted, editor, script, lenient)
        found = editor.fill()
        seconds = time.perf_counter() - began
        said = Script(start.surface, tuple(done), start.quads)
        if view:
            _look(editor, name, session, record, said)
            found = editor.fill()
        mesh = editor.mesh(found)
        if session is not None and wanted is not None and not view:
            write_session(session, RetopoSession(start.ground, editor.state, name))
            say(f"written: {session}")
        if record is not None and not view:
            write_script(record, said)
            say(f"written: {record}")
        if output is not None:
            _write(output, mesh)
            say(f"written: {output}")
        if picture is not None:
            from viewer.retopo import draw

            draw(editor, picture, title=name)
            say(f"drawn: {picture}")
    for note in found.notes:
        say(note)
    if nothing_else:
        return 0
    from patterndb_sketch.retopo.filling.report import find_open_loops, report_mesh

    made = report_mesh(found, start.ground, mesh)
    if as_json:
        document: dict[str, object] = {
            "surface": start.surface,
            "triangles": len(start.ground.triangles),
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


def _played(
    wanted: Script, editor: Editor, script: Path, lenient: bool
) -> tuple[list[ScriptLine], list[tuple[ScriptLine, Outcome]]]:
    """Play a script; the lines that did something, and those that were refused."""
    from patterndb_sketch.retopo.script import play_script

    def export(name: str, found: FilledNetwork) -> None:
        _write(script.parent / name, editor.mesh(found))

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
    editor: Editor, title: str, session: Path | None, record: Path | None, said: Script
) -> None:
    """Open the window, until it is closed."""
    from viewer.retopo import show

    show(editor, title=title, session=session, script=record, begun=said, write_mesh=_write)


def _write(path: Path, mesh: RetopoMesh) -> None:
    from patterndb_app.cli.obj import write_quads

    groups = [f"patch_{number}" for number in mesh.patch.tolist()]
    patches = len(set(groups))
    title = f"quad mesh: {len(mesh.quads)} quads in {plural(patches, 'patch', 'patches')}"
    write_quads(path, mesh.vertices, mesh.quads, title, groups)


def _rows(made: Report, seconds: float) -> list[tuple[str, object]]:
    return [
        ("patches", ", ".join(f"{n} with {k}" for k, n in made.patches.items()) or "none"),
        ("quads", made.quads),
        ("irregular", ", ".join(f"{n} of {k}" for k, n in made.irregular.items()) or "none"),
        ("flipped", made.flipped),
        ("open edges", made.open_edges),
        ("Euler", made.euler),
        ("to the surface", f"{100 * made.to_ground:.2f} %"),
        ("from the surface", f"{100 * made.from_ground:.2f} %"),
        ("seconds", f"{seconds:.1f}"),
    ]


COMMANDS = (retopo,)
