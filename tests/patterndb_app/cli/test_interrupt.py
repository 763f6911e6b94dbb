"""Ctrl-C: what is done stays, the program says how to go on, and exits with 130."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from ingest import MeshReport
from patterndb_app.cli import cli
from patterndb_app.cli.ingest import LearningProgress
from tests.support.cli.commandline import PROGRAM, SMALL, content_hash, mesh_names, run
from tests.support.shared import EXAMPLES


@pytest.fixture
def meshes(learned: Path) -> list[Path]:
    return [*sorted(EXAMPLES.glob("*.obj")), learned.with_name("drop.obj")]


@pytest.mark.parametrize("json", [(), ("--json",)])
@pytest.mark.parametrize("done", [0, 1, 3])
def test_the_same_command_goes_on(
    learned: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    meshes: list[Path],
    done: int,
    json: tuple[str, ...],
) -> None:
    db = tmp_path / "a.db"
    command = ("ingest", *meshes, "--db", db, *SMALL, *json)
    reported: list[str] = []

    def report(self: LearningProgress, mesh: MeshReport) -> None:
        reported.append(mesh.name)
        if len(reported) == done:
            raise KeyboardInterrupt

    def update(self: LearningProgress, state: object) -> None:
        if done == 0:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(LearningProgress, "report", report)
        patch.setattr(LearningProgress, "update", update)
        first = run(*command)
    assert first.code == 130
    assert f"interrupted: {len(reported)} of 5 meshes done" in first.err
    assert f"{db}; the same command goes on from here" in first.err
    if json:
        document = first.document()
        assert document["interrupted"] is True
        given = [mesh.name for mesh in meshes if mesh.name in reported]
        assert [m["name"] for m in document["meshes"]] == given
    assert mesh_names(db) == sorted(reported)
    assert run("verify", "--db", db).code == 0
    second = run("ingest", *meshes, "--db", db, *SMALL, "--json").document()
    outcomes = {m["name"]: m["outcome"] for m in second["meshes"]}
    assert {name for name, what in outcomes.items() if what == "unchanged"} == set(reported)
    assert content_hash(db) == content_hash(learned)


@pytest.fixture
def heeded() -> Iterator[None]:
    """Shells start background jobs deaf to Ctrl-C, and children inherit that: here they must
    not."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeded")
def test_a_signal_ends_a_long_ingest(tmp_path: Path, meshes: list[Path]) -> None:
    db = tmp_path / "a.db"
    # At these limits the head takes minutes, the drop beside it next to nothing.
    command = [*PROGRAM, "ingest", EXAMPLES / "head.obj", meshes[-1], "--db", db, "--jobs", "2"]
    command += ["--convex", "120"]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stderr is not None and process.stdout is not None
        assert process.stderr.readline().startswith("drop.obj: ")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    assert process.returncode == 130
    assert out.startswith("1 of 2 meshes learned, ")
    assert (
        err == f"interrupted: 1 of 2 meshes done and in {db}; the same command goes on from here\n"
    )
    assert mesh_names(db) == ["drop.obj"]
    assert run("verify", "--db", db).code == 0


def test_an_interrupt_anywhere_else(learned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    stats = cli.get_command(click.Context(cli), "stats")
    assert stats is not None
    monkeypatch.setattr(stats, "callback", interrupt)
    result = run("stats", "--db", learned)
    assert (result.code, result.out, result.err.strip()) == (130, "", "interrupted")
