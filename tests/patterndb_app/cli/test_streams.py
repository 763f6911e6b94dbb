"""stdout is data, stderr is talk; either may be closed, full, or go away."""

from __future__ import annotations

import json
import os
import pty
import re
import subprocess
from pathlib import Path

import pytest

from tests.support.cli.commandline import PROGRAM, SMALL, TINY, content_hash, program, run
from tests.support.shared import EXAMPLES

MESHES = sorted(EXAMPLES.glob("*.obj"))


def test_python_m_and_the_version() -> None:
    result = program("--version")
    assert (result.code, result.err) == (0, "")
    assert re.fullmatch(r"patterndb, version \d+\.\d+\.\d+\n", result.out)


def test_exit_codes_of_a_process(learned: Path, tmp_path: Path) -> None:
    for code, arguments in (
        (0, ("query", "--sides=3,5,4,6", "--db", learned)),
        (1, ("query", "--sides=2,2", "--strict", "--db", learned)),
        (2, ("query", "--sides=a", "--db", learned)),
        (2, ()),
        (3, ("query", "--sides=3,4", "--db", learned)),
        (3, ("stats", "--db", tmp_path)),
    ):
        result = program(*arguments)
        assert result.code == code, arguments
        assert "Traceback" not in result.err
        assert bool(result.out) == (code == 0)


def test_json_with_nothing_on_stderr_but_talk(learned: Path) -> None:
    result = program("query", "--sides=2,2", "--strict", "--db", learned, "--json")
    assert result.code == 1
    assert result.document()["fills"] == []
    assert result.err.startswith("no fill: ")


def test_no_terminal_no_line_of_progress(tmp_path: Path) -> None:
    result = program("ingest", *MESHES, "--db", tmp_path / "a.db", *TINY)
    assert result.code == 0
    assert len(result.out.splitlines()) == 1
    assert len(result.err.splitlines()) == len(MESHES)
    assert "\x1b" not in result.out + result.err and "\r" not in result.out + result.err


def test_a_terminal_has_a_line_of_progress(tmp_path: Path) -> None:
    screen, terminal = pty.openpty()
    # At the default limits, which take a second: what ends within a moment is not told.
    command = [*PROGRAM, "ingest", *MESHES, "--db", tmp_path / "a.db", "--json"]
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    with subprocess.Popen(
        command,
        stdin=terminal,
        stdout=subprocess.PIPE,
        stderr=terminal,
        env=environment,
    ) as process:
        os.close(terminal)
        shown = b""
        while True:
            try:
                shown += os.read(screen, 65536)
            except OSError:  # the other end is closed
                break
        assert process.stdout is not None
        document = json.load(process.stdout)
    os.close(screen)
    assert process.returncode == 0
    assert len(document["meshes"]) == len(MESHES)
    text = shown.decode()
    assert re.search(r"learning: \d+%.*, [\d,]+ patches/s; ", text)
    # It goes away when all is done.
    assert text.endswith("\r\x1b[K")


class TestReadersThatLeave:
    @pytest.mark.parametrize("json", [(), ("--json",)])
    def test_of_stdout(self, learned: Path, json: tuple[str, ...]) -> None:
        asked = ("query", "--sides=16,16,16,16,16", "--limit=60", "--db", learned, *json)
        with subprocess.Popen(
            [*PROGRAM, *map(str, asked)], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        ) as process:
            assert process.stdout is not None and process.stderr is not None
            assert process.stdout.read(4) in (b"rank", b'{"si')
            process.stdout.close()
            talk = process.stderr.read().decode()
        assert process.returncode == 0
        assert "Traceback" not in talk and "Broken pipe" not in talk and "Exception" not in talk

    def test_of_stderr_do_not_stop_an_ingest(self, tmp_path: Path, learned: Path) -> None:
        db = tmp_path / "a.db"
        reader, writer = os.pipe()
        os.close(reader)
        result = program("ingest", *MESHES, "--db", db, *TINY, stderr=writer)
        os.close(writer)
        assert result.code == 0
        assert len(run("meshes", "--db", db, "--json").document()["meshes"]) == len(MESHES)

    def test_no_streams_at_all(self, tmp_path: Path) -> None:
        db = tmp_path / "a.db"

        def close() -> None:
            for descriptor in (0, 1, 2):
                os.close(descriptor)

        result = program("ingest", MESHES[0], "--db", db, *TINY, before=close)
        assert result.code == 0
        assert run("verify", "--db", db).code == 0
        assert program("query", "--sides=2,2", "--strict", "--db", db, before=close).code == 1
        assert program("stats", "--db", tmp_path, before=close).code == 3


@pytest.mark.parametrize("verb", [("stats",), ("query", "--sides=3,5,4,6", "--json")])
def test_stdout_is_full(learned: Path, verb: tuple[str, ...]) -> None:
    with Path("/dev/full").open("wb") as full:
        result = program(*verb, "--db", learned, stdout=full)
    assert result.code == 3
    assert result.err.splitlines() == ["patterndb: No space left on device"]


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-16"])
def test_any_encoding_of_stdout(tmp_path: Path, encoding: str) -> None:
    mesh = tmp_path / "jüg ☃.obj"
    mesh.write_bytes((EXAMPLES / "jug.obj").read_bytes())
    db = tmp_path / "a.db"
    environment = {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [*PROGRAM, "ingest", str(mesh), "--db", str(db), *TINY, "--json"]
    done = subprocess.run(command, env=os.environ | environment, check=False, **streams)
    assert done.returncode == 0
    decoded = done.stdout.decode("utf-16" if encoding == "utf-16" else "ascii")
    assert json.loads(decoded)["meshes"][0]["name"] == mesh.name
    command = [*PROGRAM, "meshes", "--db", str(db)]
    done = subprocess.run(command, env=os.environ | environment, check=False, **streams)
    assert done.returncode == 0
    assert b"Traceback" not in done.stderr


def test_a_full_disk_keeps_what_was_committed(tmp_path: Path) -> None:
    db = tmp_path / "a.db"
    assert run("ingest", EXAMPLES / "jug.obj", "--db", db, *TINY).code == 0
    before = content_hash(db)

    def no_more() -> None:
        import resource

        size = db.stat().st_size
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    result = program("ingest", EXAMPLES / "dog.obj", "--db", db, *SMALL, before=no_more)
    assert (result.code, result.out) == (3, "")
    assert str(db) in result.err and "Traceback" not in result.err
    assert content_hash(db) == before
    assert run("verify", "--db", db).code == 0
