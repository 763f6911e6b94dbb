"""Help, tables, and the errors that no one foresaw."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import click
import pytest

from patterndb_app.cli import cli
from patterndb_app.cli.failure import TRACEBACK
from patterndb_app.cli.program import SECTIONS, SectionedCommand
from patterndb_app.cli.text import WIDTH, plural, printable, shorten, table
from patterndb_sketch.retopo.table import TOOLS
from tests.support.cli.commandline import assert_refused, run

VERBS = (
    "ingest",
    "list",
    "export",
    "diff",
    "report",
    "holes",
    "serve",
    "stats",
    "meshes",
    "query",
    "fill",
    "explore",
    "surface",
    "retopo",
    "features",
    "register",
    "shape-model",
    "shape-model build",
    "shape-model sample",
    "shape-model edit",
    "show",
    "gallery",
    "browse",
    "verify",
    "merge",
    "remove",
    "import-ddq",
    "export-ddq",
)


def command_of(verb: str) -> click.Command:
    """The verb of this name, one of a group by both words."""
    command: click.Command = cli
    for word in verb.split():
        assert isinstance(command, click.Group)
        found = command.get_command(click.Context(command), word)
        assert found is not None
        command = found
    return command


def test_the_verbs() -> None:
    found = set(cli.list_commands(click.Context(cli)))
    for name in tuple(found):
        command = command_of(name)
        if isinstance(command, click.Group):
            found |= {f"{name} {word}" for word in command.commands}
    assert found == set(VERBS)


def test_the_help_lists_all_verbs_in_their_sections() -> None:
    lines = run("--help").out.splitlines()
    at = [lines.index(f"{title}:") for title in SECTIONS]
    assert at == sorted(at)
    for first, last, verbs in zip(at, (*at[1:], None), SECTIONS.values(), strict=True):
        listed = [line.split()[0] for line in lines[first + 1 : last] if line[2:3].strip()]
        assert listed == list(verbs)


@pytest.mark.parametrize("verb", VERBS)
def test_every_option_is_in_one_section(verb: str) -> None:
    command = command_of(verb)
    options = [p.name for p in command.params if isinstance(p, click.Option)]
    if not isinstance(command, SectionedCommand):
        assert len(options) <= 10, "a list as long as this has sections"
        return
    grouped = [p.name for group in command.group_options().values() for p in group]
    assert sorted(map(str, grouped)) == sorted(map(str, options))


def test_a_verb_that_there_is_not() -> None:
    assert_refused(run("queery"), 2, "queery")


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_has_an_example(verb: str, flag: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    result = run(*verb.split(), flag)
    assert (result.code, result.err) == (0, "")
    assert f"\n  patterndb {verb} " in result.out
    assert max(map(len, result.out.splitlines())) <= WIDTH
    for option in command_of(verb).params:
        if isinstance(option, click.Option):
            assert option.help and option.help.endswith((".", "]", '".')), option.name
            assert option.opts[0] in result.out


@pytest.mark.parametrize("verb", VERBS)
def test_examples_are_in_order(verb: str) -> None:
    """Every line of an example is read by the verb that it names, up to its files."""
    command = command_of(verb)
    help_text = command.help or ""
    lines = [line.strip() for line in help_text.splitlines()]
    examples = [line for line in lines if line.startswith("patterndb ")]
    assert examples
    for line in examples:
        words = shlex.split(line)[1:]
        length = len(verb.split())
        assert words[:length] == verb.split()
        named, rest = command, words[length:]
        if isinstance(command, click.Group):
            named, rest = command.commands[rest[0]], rest[1:]
        context = named.make_context(verb, rest, resilient_parsing=True)
        assert not context.args


def test_the_help_of_retopo_lists_every_tool() -> None:
    lines = run("retopo", "--help").out.splitlines()
    listed = {line.split()[0] for line in lines if line.startswith("  ") and line[2:3].strip()}
    assert set(TOOLS) <= listed


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_is_told_how_to_complete(shell: str) -> None:
    told = run(environment={"_PATTERNDB_COMPLETE": f"{shell}_source"})
    assert told.code == 0 and "_PATTERNDB_COMPLETE" in told.out
    asked = {
        "_PATTERNDB_COMPLETE": "fish_complete",
        "COMP_WORDS": "patterndb que",
        "COMP_CWORD": "que",
    }
    assert "query" in run(environment=asked).out
    asked |= {"COMP_WORDS": "patterndb query --db ", "COMP_CWORD": ""}
    assert run(environment=asked).out.startswith("file,")


def test_the_program_names_its_exit_codes() -> None:
    result = run("--help")
    assert result.code == 0
    for words in ("0 done", "1 nothing found", "2 wrong usage", "3 bad input", "130 interrupted"):
        assert words in result.out
    assert max(map(len, result.out.splitlines())) <= WIDTH
    bare = run()
    assert (bare.code, bare.out) == (2, "")
    assert "Usage: patterndb" in bare.err


def test_an_unforeseen_error_is_one_line(learned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ValueError("the sky is green")

    monkeypatch.setattr(command_of("stats"), "callback", fail)
    result = run("stats", "--db", learned)
    assert (result.code, result.out) == (3, "")
    (line,) = result.err.splitlines()
    assert "ValueError: the sky is green (test_text.py:" in line
    assert "patterndb verify" in line and TRACEBACK in line
    monkeypatch.setenv(TRACEBACK, "1")
    assert "Traceback" in run("stats", "--db", learned).err


def test_out_of_memory(learned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr(command_of("query"), "callback", fail)
    result = run("query", "--sides=4,4", "--db", learned)
    assert result.code == 3
    assert "memory" in result.err and "fewer fills" in result.err


def test_plural() -> None:
    assert plural(1, "mesh", "meshes") == "1 mesh"
    assert plural(0, "mesh", "meshes") == "0 meshes"
    assert plural(12345, "pattern") == "12,345 patterns"


def test_printable_is_one_line_that_tells_all() -> None:
    text = "a\nb\x1b[31m\t☃é\u202e"
    shown = printable(text)
    assert shown == "a\\nb\\x1b[31m\\t☃é\\u202e"
    assert shown.isprintable()
    assert json.loads(json.dumps(text)) == text


def test_shortened() -> None:
    assert shorten("abcdef", 6) == "abcdef"
    assert shorten("abcdefg", 6) == "abcde…"
    assert shorten("abc", 0) == "…"


class TestTable:
    def test_lines_up(self) -> None:
        lines = table(("n", "name", "what"), [(1, "a", "x y"), (1000, "long name", "")])
        assert lines.splitlines() == [
            "    n  name       what",
            "    1  a          x y",
            "1,000  long name",
        ]

    def test_is_as_wide_as_a_help_text(self) -> None:
        lines = table(("n", "widths"), [(k, "12 " * 200) for k in range(3)]).splitlines()
        assert [len(line) for line in lines[1:]] == [WIDTH] * 3
        assert all(line.endswith("…") for line in lines[1:])

    def test_without_rows_has_its_heads(self) -> None:
        assert table(("mesh", "quads"), []) == "mesh  quads"
