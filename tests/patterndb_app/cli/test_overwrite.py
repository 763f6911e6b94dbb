"""No verb writes onto a file that it reads, by whatever name, unless --overwrite is given."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from patterndb_app.cli import EXIT_USAGE, cli
from patterndb_app.cli.options import DatabaseParam, FileName
from patterndb_app.cli.program import SECTIONS
from patterndb_app.cli.shape_model import Source
from tests.support.cli.commandline import run
from tests.support.shared import CHECKOUT

HEAD = CHECKOUT / "docs" / "meshes" / "head.obj"

#: What names files that are read, and the entries of a command line around the file that is written
#: onto: {0}.
CASES = {
    "holes mesh": ("holes {0} --loop 36 -o {1}", ".obj"),
    "holes surface": (f"holes {HEAD} --loop 36 --surface {{0}} -o {{1}}", ".obj"),
    "holes mesh ply": ("holes {0} --all -o {1}", ".ply"),
    "fill surface": ("fill b.json --surface {0} -o {1}", ".obj"),
    "fill boundary": ("fill {0} -o {1}", ".obj"),
    "surface": ("surface {0} -o {1}", ".obj"),
    "surface picture": ("surface {0} --picture {1}", ".png"),
    "retopo": ("retopo {0} --draft -o {1}", ".obj"),
    "retopo record": ("retopo a.obj --script {0} --record {1}", ".jsonl"),
    "retopo session": ("retopo {0} --script s.jsonl --session {1}", ".retopo"),
    "features": ("features m.obj --strokes {0} -o {1}", ".json"),
    "features model": ("features {0} --strokes s.json --session {1}", ".obj"),
    "register": ("register {0} --network n.json --template box:car -o {1}", ".obj"),
    "shape model source": ("shape-model build {0} b.obj --template box:car -o {1}", ".npz"),
    "shape model network": ("shape-model build a.obj={0} b.obj --template box:car -o {1}", ".npz"),
    "sample": ("shape-model sample {0} -o {1}", ".obj"),
    "edit": ("shape-model edit {0} --drag a=0,0,1 --picture {1}", ".png"),
    "query": ("query --sides 3,5,4,6 --db {0} --image {1}", ".png"),
    "query of several": ("query --sides 3,5,4,6 --db b.db --db {0}=2 --image {1}", ".svg"),
    "show": ("show --sides 3,5,4,6 --db {0} -o {1}", ".png"),
    "gallery": ("gallery --class 5 --db {0} -o {1}", ".png"),
    "browse": ("browse --db {0} -o {1}", ".png"),
    "explore": ("explore {0} -o {1}", ".png"),
    "export": ("export {1} --db {0}", ".csv"),
}


def name_again(how: str, path: Path) -> Path:
    """Another name of a file."""
    other = path.with_name(f"other{path.suffix}")
    match how:
        case "same":
            return path
        case "by another path":
            return path.parent / ".." / path.parent.name / path.name
        case "symbolic link":
            other.symlink_to(path)
        case "hard link":
            os.link(path, other)
        case _:
            raise AssertionError(how)
    return other


@pytest.mark.parametrize("how", ["same", "by another path", "symbolic link", "hard link"])
@pytest.mark.parametrize("case", CASES)
def test_no_verb_writes_onto_what_it_reads(tmp_path: Path, case: str, how: str) -> None:
    line, suffix = CASES[case]
    path = tmp_path / f"a{suffix}"
    path.write_text("not to be lost")
    result = run(*line.format(path, name_again(how, path)).split())
    assert result.code == EXIT_USAGE and not result.out
    assert "which would be lost; name another file, or give --overwrite" in result.err
    assert path.read_text() == "not to be lost"


def test_a_surface_that_a_script_names_is_not_written_onto(tmp_path: Path) -> None:
    mesh, script = tmp_path / "a.obj", tmp_path / "s.jsonl"
    shutil.copy(HEAD, mesh)
    script.write_text('{"tool": "open", "surface": "a.obj"}\n')
    result = run("retopo", "--script", script, "-o", mesh)
    assert result.code == EXIT_USAGE and "is the surface of the script" in result.err
    assert mesh.read_bytes() == HEAD.read_bytes()


def test_an_input_is_replaced_on_demand_and_other_files_always(tmp_path: Path) -> None:
    mesh, other = tmp_path / "a.obj", tmp_path / "b.obj"
    shutil.copy(HEAD, mesh)
    other.write_text("an old file")
    assert run("holes", mesh, "--loop", 36, "-o", other).code == 0
    assert mesh.read_bytes() == HEAD.read_bytes()
    assert run("holes", mesh, "--loop", 36, "-o", mesh, "--overwrite").code == 0
    assert mesh.read_bytes() == other.read_bytes()


def list_commands() -> Iterator[click.Command]:
    context = click.Context(cli)
    for verb in (verb for verbs in SECTIONS.values() for verb in verbs):
        command = cli.get_command(context, verb)
        assert command is not None
        yield from command.commands.values() if isinstance(command, click.Group) else [command]


def test_every_verb_that_reads_and_writes_files_has_the_option() -> None:
    found = {}
    for command in list_commands():
        types = [param.type for param in command.params]
        writes = any(isinstance(one, FileName) and one.writes for one in types)
        reads = any(
            isinstance(one, DatabaseParam | Source) or (isinstance(one, FileName) and one.reads)
            for one in types
        )
        if writes:
            options = {name for param in command.params for name in param.opts}
            found[command.name] = reads <= ("--overwrite" in options)
    assert all(found.values()), found
    assert {"holes", "fill", "retopo", "sample", "export", "query"} <= set(found)
