"""--json changes how an answer is written, and not the answer: of every verb that has it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from patterndb_app.cli import cli
from tests.support.cli.commandline import SMALL, content_hash, run
from tests.support.features.drawnbodies import write_bodies
from tests.support.shared import EXAMPLES

SQUARE = {"sides": [[[0, 0], [4, 0]], [[4, 0], [4, 4]], [[4, 4], [0, 4]], [[0, 4], [0, 0]]]}
TRIANGLE = {
    "curves": [
        {"id": 1, "points": [[0, 0, 0], [1, 0, 0]]},
        {"id": 2, "points": [[1, 0, 0], [0, 1, 0]]},
        {"id": 3, "points": [[0, 1, 0], [0, 0, 0]]},
    ],
    "cycles": [[1, 2, 3]],
}
CALLS = (
    {"tool": "open", "surface": "jug.obj"},
    {"tool": "loop", "at": [0, -6.5, 5], "normal": [0, 0, 1]},
    {"tool": "loop", "at": [0, -6.5, 2], "normal": [0, 0, 1]},
    {"tool": "cylinder", "points": [[0, -6.5, 5], [0, -6.5, 2]], "division": 4},
)

#: What every verb is asked, in a folder that has the files of :func:`folder`. Several questions
#: where --json once chose another answer, or might.
ASKED: dict[str, tuple[str, ...]] = {
    "ingest": (f"jug.obj --db new.db {' '.join(SMALL)}", "triangle.obj --db new.db"),
    "import-ddq": ("patches.db --db new.db",),
    "export-ddq": ("again.db --db a.db",),
    "query": (
        "--sides 3,5,4,6 --db a.db --limit 6 --obj fills --image fills.svg",
        "--sides 3,5,4,6 --db a.db --limit 6 --flat --obj fills",
        "--sides 2,2 --strict --db a.db --obj fills",
        "--batch lines.jsonl --db a.db --limit 3 --obj fills",
    ),
    "fill": (
        *(f"square.json --db a.db --rank {rank} -o fill.obj" for rank in (1, 2, 3)),
        "square.json --db a.db --rank 3 --flat -o fill.obj --record",
        "square.json --db a.db --max-irregular 1 --rank 100000 -o fill.obj",
    ),
    "holes": (
        "head.obj",
        "triangle.obj",
        "head.obj --loop 36 --db a.db -o filled.obj --rank 2 --limit 3",
        "head.obj --loop 36 --loop 475 --db a.db -o filled.obj",
    ),
    "list": ("--db a.db --class 5", "--db a.db --class 77"),
    "stats": ("--db a.db",),
    "meshes": ("--db a.db",),
    "verify": ("--db a.db", "--db wrong.db", "--db wrong.db --repair saved.db"),
    "merge": ("a.db --db new.db", "wrong.db --db new.db"),
    "remove": ("jug.obj --db a.db", "no.obj --db a.db"),
    "diff": ("a.db wrong.db",),
    "report": ("",),
    "surface": ("triangle.json -o out.obj --picture out.png", "triangle.json --cycles-only"),
    "retopo": (
        "--script jug.jsonl --db a.db -o out.obj --session out.retopo --record done.jsonl",
        "jug.obj --script open.jsonl --db a.db -o out.obj",
    ),
    "features": ("sedan.obj --strokes sedan.strokes.json -o curves.json --session a.session",),
    "register": ("sedan.obj --network sedan.network.json --template box:roof?r=4 -o out.obj",),
    "shape-model build": (
        "sedan.obj=sedan.network.json wagon.obj=wagon.network.json --template box:roof?r=4 "
        "-o out.npz",
    ),
    "shape-model sample": ("cars.npz --random --seed 3 -o out.obj",),
    "shape-model edit": ("cars.npz --drag roof_rail=0,0,0.1 -o out.obj",),
}


def list_verbs(group: click.Group, before: str = "") -> Iterator[tuple[str, click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from list_verbs(command, f"{before}{name} ")
        else:
            yield before + name, command


def test_every_verb_that_has_the_option_is_asked() -> None:
    having = {
        name for name, verb in list_verbs(cli) if any("--json" in p.opts for p in verb.params)
    }
    assert having == set(ASKED)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, learned: Path) -> Path:
    """What the questions are about."""
    folder = write_bodies(tmp_path_factory.mktemp("json"), "sedan", "wagon")
    shutil.copy(learned, folder / "a.db")
    shutil.copy(EXAMPLES / "jug.obj", folder / "jug.obj")
    shutil.copy(EXAMPLES.parent / "docs" / "meshes" / "head.obj", folder / "head.obj")
    (folder / "triangle.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "square.json").write_text(json.dumps(SQUARE | {"edge_length": 1.0}))
    (folder / "triangle.json").write_text(json.dumps(TRIANGLE))
    (folder / "lines.jsonl").write_text('3,5,4,6\n{"sides": [4, 4, 4, 4], "id": "b"}\n4,4\n')
    (folder / "jug.jsonl").write_text("\n".join(map(json.dumps, CALLS)))
    (folder / "open.jsonl").write_text(json.dumps(CALLS[0]))
    asked = ("sedan", "wagon")
    pairs = [f"{folder / name}.obj={folder / name}.network.json" for name in asked]
    built = ("shape-model", "build", *pairs, "--template", "box:roof?r=4", "-o")
    assert run(*built, folder / "cars.npz").code == 0
    assert run("export-ddq", folder / "patches.db", "--db", folder / "a.db").code == 0
    wrong = folder / "wrong.db"
    assert run("ingest", folder / "jug.obj", "--db", wrong, *SMALL).code == 0
    spoil(wrong)
    return folder


def spoil(db: Path) -> None:
    import sqlite3

    connection = sqlite3.connect(db)
    connection.execute("UPDATE mesh SET distinct_patches = 127")
    connection.commit()
    connection.close()


@pytest.mark.parametrize(
    ("verb", "asked"), [(verb, asked) for verb, every in ASKED.items() for asked in every]
)
def test_the_answer_is_the_same(
    verb: str, asked: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    codes: list[int] = []
    files: list[dict[str, object]] = []
    for more in ((), ("--json",)):
        here = tmp_path / f"run{len(more)}"
        shutil.copytree(folder, here)
        monkeypatch.chdir(here)
        result = run(*verb.split(), *asked.split(), *more)
        codes.append(result.code)
        files.append({p.relative_to(here).as_posix(): content(p) for p in sorted(here.rglob("*"))})
        if more and result.out:
            for line in result.out.splitlines():
                assert isinstance(json.loads(line), dict)
    assert codes[0] == codes[1]
    assert files[0] == files[1]


def content(path: Path) -> object:
    """What a file holds; of a database, independent of the order in which it was written."""
    if path.is_dir():
        return None
    if path.suffix == ".db" and path.name not in ("patches.db", "again.db"):
        return content_hash(path)
    return path.read_bytes()


def test_the_list_is_the_same_line_for_line(learned: Path) -> None:
    for more in ((), ("--flat",), ("--per-pattern", 2)):
        asked = ("query", "--sides", "3,5,4,6", "--limit", 8, "--db", learned, *more)
        names = [line.split()[1] for line in run(*asked).out.splitlines()[1:]]
        document = run(*asked, "--json").document()
        assert [fill["pattern"] for fill in document["fills"]] == names
