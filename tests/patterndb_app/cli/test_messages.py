"""What is said where something was misspelt, left out, or is not there: it names what mends it."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from patterndb.system import extras
from patterndb.system.extras import EXTRAS
from patterndb_app.cli.program import SECTIONS
from tests.support.cli.commandline import TINY, assert_refused, program, run
from tests.support.shared import EXAMPLES


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("quary", "query"),
        ("Query", "query"),
        ("holse", "holes"),
        ("import_ddq", "import-ddq"),
        ("exportddq", "export-ddq"),
        ("shapemodel", "shape-model"),
        ("shape", "shape-model"),
        ("retop", "retopo"),
        ("shape-model bild", "build"),
    ],
)
def test_a_misspelt_verb(written: str, meant: str) -> None:
    assert_refused(run(*written.split()), 2, f"did you mean {meant}?")


def test_a_slip_in_any_verb_is_understood() -> None:
    for verb in (verb for verbs in SECTIONS.values() for verb in verbs):
        swapped = verb[0] + verb[2] + verb[1] + verb[3:]
        if swapped != verb:
            assert_refused(run(swapped), 2, "did you mean", verb)
    assert_refused(run("xyzzy"), 2, "--help lists the verbs")


@pytest.mark.parametrize(
    ("arguments", "better"),
    [
        ("query --sides 3 5 4 6", "--sides 3,5,4,6"),
        ("query --sides=3 5 4 6 --limit 2", "--sides 3,5,4,6"),
        ("query --sides 3, 5, 4, 6", "--sides 3,5,4,6"),
        ("query 3,5,4,6", "--sides 3,5,4,6"),
        ("query 3 5 4 6", "--sides 3,5,4,6"),
        ("gallery --sides 3 5 4 6 -o a.png", "--sides 3,5,4,6"),
        ("show --sides 3 5 4 6 -o a.png", "--sides 3,5,4,6"),
        ("explore --sides 3 5 4 6", "--sides 3,5,4,6"),
        ("query --sides 3,5,4,6 --corners c c r c", "--corners c,c,r,c"),
        ("holes a.obj --loop 3 17", "--loop 3,17"),
        ("holes --faces 3 17 20-25 a.obj", "--faces 3,17,20-25"),
        ("features a.obj --axis 0 0 1 --strokes a.json", "--axis 0,0,1"),
    ],
)
def test_a_list_with_blanks(arguments: str, better: str) -> None:
    assert_refused(run(*arguments.split()), 2, f"lists have commas and no blanks: {better}\n")


def test_no_list_is_suggested_where_none_was_given() -> None:
    for arguments in ("query --sides 3,5,4,6 --batch a", "holes --loop 3 --faces 4 a.obj"):
        assert "commas" not in run(*arguments.split()).err


@pytest.mark.parametrize(
    "arguments",
    [
        "query --sides 3,5,4,6 --obj -",
        "query --sides 3,5,4,6 --image -",
        "query --batch -",
        "fill - -o a.obj",
        "fill a.json -o -",
        "holes -",
        "holes a.obj -o -",
        "holes a.obj --picture -",
        "surface a.json -o -",
        "retopo a.obj --draft -o -",
        "retopo a.obj --session -",
        "retopo a.obj --draft --record -",
        "features a.obj --strokes a.json -o -",
        "register a.obj --network a.json --template box:roof -o -",
        "shape-model build --template box:roof -o - a.obj=a.json",
        "shape-model sample a.npz -o -",
        "gallery --class 5 -o -",
        "show 05 -o -",
        "export -",
        "export-ddq -",
        "import-ddq - --db a.db",
        "ingest - --db a.db",
        "ingest a.obj --db -",
        "merge - --db a.db",
        "verify --db a.db --repair -",
        "stats --db -",
    ],
)
def test_stdin_and_stdout_are_no_files(
    arguments: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(run(*arguments.split()), 2, "- is not a file")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "how"),
    [
        ("query --sides 3,5,4,6 --db http://127.0.0.1:8017", "--server"),
        ("query --sides 3,5,4,6 --db http://127.0.0.1:8017=2", "--server"),
        ("stats --db https://example.org/a.db", "download it"),
        ("ingest a.obj --db https://example.org/a.db", "download it"),
        ("holes https://example.org/a.obj", "download it"),
    ],
)
def test_an_address_is_no_file(arguments: str, how: str) -> None:
    assert_refused(run(*arguments.split()), 2, "is an address, not a file", how)


def test_options_are_named_as_they_are_written(learned: Path) -> None:
    asked = ("query", "--sides", "3,5,4,6", "--db", learned)
    refused = run(*asked, "--order", "fit")
    assert_refused(refused, 3, "--order fit needs points of the boundary", "artist")
    assert "order=" not in refused.err
    strict = run("query", "--sides", "3,4,5", "--db", learned, "--strict", "--max-irregular", 0)
    assert strict.code == 1 and "--max-irregular is 0" in strict.err


@pytest.mark.parametrize("sides", ["3,5,4,6", "4,4,4,5,5", "3,4,5"])
def test_a_filter_that_leaves_nothing_names_what_there_is(learned: Path, sides: str) -> None:
    asked = ("query", "--sides", sides, "--db", learned, "--order", "regular", "--flat")
    fewest = run(*asked, "--limit", 1, "--json").document()["fills"][0]["n_irregular"]
    refused = run(*asked, "--max-irregular", fewest - 1)
    assert refused.code == 1
    assert f"the fewest irregular vertices that any fill has are {fewest}" in refused.err
    assert run(*asked, "--max-irregular", fewest).code == 0
    assert "quads, but --max-quads is 2" in run(*asked, "--max-quads", 2).err


def test_no_mesh_is_guessed_that_is_not_alike(learned: Path) -> None:
    asked = ("query", "--sides", "3,5,4,6", "--db", learned, "--from-mesh")
    assert "did you mean" not in run(*asked, "nosuch.obj").err
    for slip in ("haed.obj", "head.ply", "Head", "heads.obj"):
        assert "did you mean 'head.obj'" in run(*asked, slip).err
    assert "did you mean 'dog.obj'" in run("remove", "dgo.obj", "--db", learned).err


def test_what_a_line_is_called_is_repeated(learned: Path, tmp_path: Path) -> None:
    names = ["a7", 12, None, {"deep": [1]}]
    triangle = {"sides": [[[0, 0], [4, 0]], [[4, 0], [4, 3]], [[4, 3], [0, 0]]], "edge_length": 1}
    lines = [{"sides": [3, 5, 4, 6], "id": name} for name in names]
    lines += [triangle | {"id": "t"}, {"sides": [3, 4], "id": "odd"}, {"sides": [4, 4, 4, 4]}]
    batch = tmp_path / "batch.jsonl"
    batch.write_text("\n".join(map(json.dumps, lines)))
    result = run("query", "--batch", batch, "--db", learned, "--limit", 1)
    answers = [json.loads(line) for line in result.out.splitlines()]
    assert [answer.get("id") for answer in answers[:-1]] == [*names, "t", "odd"]
    assert "error" in answers[-2] and "error" not in answers[-3]
    assert "id" not in answers[-1]
    questions = [{"mesh": str(EXAMPLES.parent / "docs/meshes/head.obj"), "loop": [36], "id": 5}]
    questions += [{"mesh": "none.obj", "id": 6}]
    batch.write_text("\n".join(map(json.dumps, questions)))
    result = run("holes", "--batch", batch, "--db", learned, "--limit", 1)
    assert [json.loads(line)["id"] for line in result.out.splitlines()] == [5, 6]


def test_a_file_that_is_not_there_comes_first() -> None:
    for arguments in ("nosuch.obj", "nosuch.obj -o a.obj --draft", "--script no.jsonl -o a.obj"):
        assert_refused(run("retopo", *arguments.split()), 3, "No such file")


def test_every_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    refused = run("browse")
    assert_refused(refused, 3, "PySide6 and pyvistaqt, which are not installed")
    assert_refused(
        run("query", "--sides", "3,3", "--solver", "cp-sat"), 3, "which is not installed"
    )


class TestInstallCommand:
    """The command works in the environment that runs the program, whatever made that."""

    @pytest.fixture
    def prefix(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        monkeypatch.setattr(sys, "prefix", str(tmp_path))
        return tmp_path

    def test_pip(self, prefix: Path) -> None:
        for name, extra in EXTRAS.items():
            command = extra.install
            assert command.startswith(f"{sys.executable} -m pip install ")
            assert "patterndb[" not in command, "no index has it"
            for wanted in extras.list_requirements(name):
                assert wanted in command

    def test_pipx(self, prefix: Path) -> None:
        (prefix / "pipx_metadata.json").write_text("{}")
        assert EXTRAS["sketch"].install.startswith(f"pipx inject {prefix.name} ")
        assert "ortools" in EXTRAS["sketch"].install

    def test_uv(self, prefix: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(extras, "find_spec", lambda name: None)
        assert EXTRAS["client"].install.startswith(f"uv pip install --python {sys.executable} ")

    def test_sources_that_are_installed_nowhere(
        self, prefix: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def fail(name: str) -> None:
            raise extras.PackageNotFoundError(name)

        monkeypatch.setattr(extras, "requires", fail)
        root = Path(extras.__file__).parents[2]
        assert EXTRAS["usd"].install.endswith(f'-m pip install "{root}[usd]"')


class TestLimitsOfTheProcess:
    def test_stdout_that_is_closed(self, learned: Path, tmp_path: Path) -> None:
        import os

        def close() -> None:
            os.close(1)

        for arguments in (("stats",), ("query", "--sides=3,5,4,6", "--json")):
            result = program(*arguments, "--db", learned, before=close)
            assert result.code == 3 and "stdout is closed" in result.err
        # What is asked of these is done, and can be seen elsewhere.
        mesh = EXAMPLES / "jug.obj"
        assert program("ingest", mesh, "--db", tmp_path / "a.db", *TINY, before=close).code == 0

    def test_a_small_address_space(self, learned: Path) -> None:
        import resource

        def limit() -> None:
            resource.setrlimit(resource.RLIMIT_AS, (200 << 20, 200 << 20))

        result = program("query", "--sides=3,5,4,6", "--db", learned, before=limit)
        assert_refused(result, 3, "200 MB of address space (ulimit -v)")
        assert program("query", "--help", before=limit).code == 0


def test_a_scheduler_that_is_not_there(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    asked = ("ingest", EXAMPLES / "jug.obj", "--db", tmp_path / "a.db", "--scheduler")
    assert_refused(run(*asked, "tcp://127.0.0.1:9"), 3, "no Dask scheduler answers at")
    assert list(tmp_path.iterdir()) == []


def test_the_hint_is_a_line_that_a_shell_takes() -> None:
    import shlex

    for extra in EXTRAS.values():
        words = shlex.split(extra.install)
        assert words[1:4] == ["-m", "pip", "install"]
        assert all(re.fullmatch(r"[\w.\-/<>=!,\[\]]+", word) for word in words[4:])
