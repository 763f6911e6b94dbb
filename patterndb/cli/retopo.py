"""The verb that retopologises a surface: retopo."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from patterndb.cli.options import OBJ, FileName, as_json, db_to_read, open_database
from patterndb.cli.text import plural, say, table, write, write_json

if TYPE_CHECKING:
    from sketch.retopo.editor import Editor, Outcome
    from sketch.retopo.filling import FilledNetwork
    from sketch.retopo.script import Line, Script


@click.command()
@click.argument("surface", type=FileName(), required=False)
@click.option(
    "--script",
    type=FileName(),
    metavar="FILE",
    required=True,
    help="The script to play, JSON lines.",
)
@click.option("-o", "--output", type=OBJ, metavar="FILE", help="The mesh at the end, OBJ.")
@click.option(
    "--lenient", is_flag=True, help="Go on after a call that is refused, and say what was."
)
@db_to_read
@as_json
def retopo(
    surface: Path | None,
    script: Path,
    output: Path | None,
    lenient: bool,
    db: Path | None,
    as_json: bool,
) -> int:
    """Make a clean quad mesh on a surface, from curves drawn on it.

    SURFACE is a mesh of triangles, or of polygons, which are cut into triangles; left out, it
    is the one that the script names. A script is a line of JSON for each tool that is used:

    \b
    {"tool": "open", "surface": "spot.obj"}
    {"tool": "loop", "at": [0, 0.1, 0.3], "normal": [0, 0, 1]}
    {"tool": "stroke", "points": [[0, 0.1, 0.3], [0.1, 0.2, 0.3]]}
    {"tool": "export", "mesh": "quads.obj"}

    Loops of curves become patches, which are filled from the database; counts of edges are
    chosen so that all can be. The same script gives the same mesh.

    Exit code 1 where there is no patch at the end, 3 for a script that is not what it must be,
    or a call that is refused.

    \b
    patterndb retopo --script spot.jsonl -o spot-quads.obj
    patterndb retopo spot.obj --script spot.jsonl --lenient --json
    """
    # Imported here because compiled kernels take a moment that --help need not wait for.
    from ingest.read import read_mesh
    from sketch.retopo.editor import Editor
    from sketch.retopo.filling.report import report
    from sketch.retopo.ground import Ground
    from sketch.retopo.script import read_script, surface_path

    wanted = read_script(script)
    path = surface_path(wanted, script) if surface is None else surface
    ground = Ground.of_polygons(read_mesh(path))
    say(f"{path.name}: {plural(len(ground.triangles), 'triangle')}")
    started = time.perf_counter()
    with open_database(db) as database:
        editor = Editor(ground, database)
        refused = _played(wanted, editor, script, lenient)
        found = editor.fill()
    seconds = time.perf_counter() - started
    if output is not None:
        _write(output, found)
    made = report(found, ground)
    for note in found.notes:
        say(note)
    if as_json:
        write_json(
            {
                "surface": str(path),
                "triangles": len(ground.triangles),
                "calls": len(wanted.lines),
                "refused": [
                    {"line": line.number, "tool": line.call.tool, "why": outcome.refused}
                    for line, outcome in refused
                ],
                **asdict(made),
                "seconds": round(seconds, 6),
                "notes": list(found.notes),
                "output": None if output is None else str(output),
            }
        )
    else:
        rows = [
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
        write(table(("what", "value"), rows))
    return 0 if made.quads else 1


def _played(
    wanted: Script, editor: Editor, script: Path, lenient: bool
) -> list[tuple[Line, Outcome]]:
    """Play a script; the lines that were refused."""
    from sketch.retopo.script import play

    def export(name: str, found: FilledNetwork) -> None:
        _write(script.parent / name, found)

    refused: list[tuple[Line, Outcome]] = []
    for line, outcome in play(wanted, editor, export, lenient=lenient):
        for note in outcome.notes:
            say(f"line {line.number}: {note}")
        if outcome.refused is not None:
            say(f"line {line.number}: {line.call.tool}: {outcome.refused}")
            refused.append((line, outcome))
    return refused


def _write(path: Path, found: FilledNetwork) -> None:
    from patterndb.cli.obj import write_quads
    from sketch.retopo.filling import welded

    mesh = welded(found)
    write_quads(path, mesh.vertices, mesh.quads, mesh.patch)


COMMANDS = (retopo,)
