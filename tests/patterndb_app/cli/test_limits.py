"""A time limit ends whole commands, which then report that the search was not complete; and every
number is bounded where it enters."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from patterndb_app.cli import cli
from patterndb_app.cli.options import Count
from tests.support.cli.commandline import PROGRAM, run

#: A limit that is over before anything is found.
AT_ONCE = ("--time-limit", "0.000001")

SIDES = ("--sides", "9,9,9,9,9,9")


def list_options() -> Iterator[tuple[str, click.Option]]:
    """Every option of every command, with the command's name."""
    context = click.Context(cli)

    def walk(name: str, command: click.Command) -> Iterator[tuple[str, click.Option]]:
        if isinstance(command, click.Group):
            for inner in command.list_commands(context):
                found = command.get_command(context, inner)
                assert found is not None
                yield from walk(f"{name} {inner}".strip(), found)
        for option in command.params:
            if isinstance(option, click.Option):
                yield name, option

    return walk("", cli)


def test_every_whole_number_has_bounds() -> None:
    numbers = [
        (name, option)
        for name, option in list_options()
        if isinstance(option.type, click.IntRange | type(click.INT)) and not option.count
    ]
    assert len(numbers) > 30
    unbounded = [
        f"{name} {option.name}" for name, option in numbers if not isinstance(option.type, Count)
    ]
    assert unbounded == []


@pytest.mark.parametrize("number", [10**26, 2**63, -(10**30), "9" * 5000])
@pytest.mark.parametrize(
    "command",
    [
        ("query", *SIDES, "--tolerance"),
        ("query", *SIDES, "--max-boundary-irregular"),
        ("query", *SIDES, "--limit"),
        ("list", "--class"),
        ("list", "--limit"),
        ("gallery", "-o", "o.png", "--class"),
        ("ingest", "a.obj", "--db", "a.db", "--max-bytes"),
        ("holes", "a.obj", "--rank"),
    ],
)
def test_a_number_out_of_bounds_is_wrong_usage(command: tuple[str, ...], number: object) -> None:
    result = run(*command, str(number))
    assert result.code == 2
    assert command[-1] in result.err


def test_a_tolerance_of_all_sides_is_no_more_than_of_one() -> None:
    flow = ("--flow", "0:1-2:1", "--json", "--limit", "5")
    whole = run("query", "--sides", "3,5,4,6", *flow, "--tolerance", "2000").document()
    longest = run("query", "--sides", "3,5,4,6", *flow, "--tolerance", "6").document()
    assert whole["fills"] == longest["fills"] and len(whole["fills"]) == 5


@pytest.mark.parametrize(
    "command",
    [
        ("query", *SIDES),
        ("query", *SIDES, "--flow", "0:1-3:7", "--flow", "1:2-4:6"),
        ("show", *SIDES, "-o", "o.png"),
        ("gallery", *SIDES, "-o", "o.png"),
        ("gallery", "--class", "5", "-o", "o.png"),
        ("list", "--class", "5"),
        ("export", "o.jsonl", "--class", "5"),
    ],
)
def test_a_command_that_its_limit_ends_proves_nothing(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*command, *AT_ONCE)
    # Something may be found in a hurry, but not all.
    assert "time limit" in result.err
    kept = result.out or (tmp_path / "o.jsonl").exists()
    assert result.code == (0 if kept else 1)
    assert result.code == 1 or "complete" in result.err or "more" in result.err
    assert not (tmp_path / "o.png").exists()


def test_a_limit_counts_from_the_start_of_the_process() -> None:
    command = ["query", *SIDES, "--json", "--time-limit", "900"]
    began = time.perf_counter() - 1000.0
    answers = [
        json.loads(CliRunner().invoke(cli, command, obj=since).stdout) for since in (None, began)
    ]
    assert [one["stopped"] for one in answers] == [None, "time limit"]
    assert len(answers[0]["fills"]) > len(answers[1]["fills"]) == 1


def test_json_carries_whether_the_search_was_complete() -> None:
    whole = run("query", "--sides", "3,5,4,6", "--json").document()
    assert (whole["complete"], whole["stopped"]) == (True, None)
    none = run("query", *SIDES, "--max-irregular", "0", "--strict", "--json").document()
    assert none["fills"] == [] and none["complete"] and none["reason"]


def test_lines_of_a_batch_after_the_limit_are_not_proofs(tmp_path: Path) -> None:
    batch = tmp_path / "b.jsonl"
    batch.write_text("9,9,9,9,9,9\n5,4,6,5\n7,7,7,7\n")
    result = run("query", "--batch", batch, *AT_ONCE)
    documents = [json.loads(line) for line in result.out.splitlines()]
    assert [one["line"] for one in documents] == [1, 2, 3]
    for one in documents:
        assert (one["complete"], one["stopped"]) == (False, "time limit")
        assert one["fills"] or "time limit" in one["reason"]
    assert result.code == 1


def test_holes_have_a_limit(tmp_path: Path) -> None:
    grid = tmp_path / "open.obj"
    n = 9
    lines = [f"v {i} {j} 0" for i in range(n) for j in range(n)]
    for i in range(n - 1):
        for j in range(n - 1):
            if not (2 <= i < 6 and 2 <= j < 6):
                a = i * n + j + 1
                lines.append(f"f {a} {a + n} {a + n + 1} {a + 1}")
    grid.write_text("\n".join((*lines, "")))
    filled = tmp_path / "filled.obj"
    result = run("holes", grid, "--all", "-o", filled, *AT_ONCE)
    assert "time limit" in result.err
    assert result.code == (0 if filled.exists() else 1)
    result = run("holes", grid, "--loop", "22", "--json", "--limit", "3").document()
    (hole,) = result["holes"]
    assert (hole["stopped"], hole["complete"], len(hole["fills"])) == (None, True, 3)


def test_ctrl_c_ends_a_command_that_draws(tmp_path: Path) -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        sides = ",".join(["200"] * 8)
        command = [*PROGRAM, "query", "--sides", sides, "--limit", "300"]
        command += ["--image", str(tmp_path / "o.png")]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            time.sleep(2.0)
            process.send_signal(signal.SIGINT)
            _, err = process.communicate()
    finally:
        signal.signal(signal.SIGINT, before)
    assert process.returncode == 130
    assert err.splitlines()[-1] == b"interrupted"


def test_ctrl_c_while_the_program_is_loaded_is_no_traceback() -> None:
    script = (
        "import sys\n"
        "class Interrupts:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'patterndb_app.cli':\n"
        "            raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupts())\n"
        "from patterndb_app.__main__ import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    assert done.returncode == 130
    assert done.stderr.split() == [b"interrupted"]


def test_ctrl_c_that_a_callback_drops_is_raised_again() -> None:
    script = (
        "import ctypes, signal, sys, time\n"
        # Ignored where the tests run in the background of a shell.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "def interrupt():\n"
        "    raise KeyboardInterrupt\n"
        "class Interrupts:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'patterndb_app.cli.listing':\n"
        "            ctypes.CFUNCTYPE(None)(interrupt)()\n"
        "            for _ in range(6000):\n"
        "                time.sleep(0.01)\n"
        "sys.meta_path.insert(0, Interrupts())\n"
        "from patterndb_app.__main__ import main\n"
        "sys.argv = ['patterndb', 'list', '--limit', '1']\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    # Python ends by the signal itself where it came while a module was loaded.
    assert done.returncode in (130, -signal.SIGINT)
    assert done.stderr.split() == [b"interrupted"] and not done.stdout
