"""Running the program: in this process where that is enough, else in one of its own."""

from __future__ import annotations

import ctypes
import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from patterndb_app.cli import cli

#: Limits that learn the examples in about a second.
SMALL = ("--basic", "5", "--side", "8", "--convex", "16")
#: Limits that learn them at once, where it does not matter what is learned.
TINY = ("--basic", "3", "--side", "0", "--convex", "0")

#: Numbers of the Linux kernel (linux/prctl.h, linux/capability.h).
PR_CAPBSET_DROP = 24
CAP_DAC_OVERRIDE = 1
CAP_DAC_READ_SEARCH = 2

PROGRAM = (sys.executable, "-m", "patterndb")


@dataclass(frozen=True)
class Result:
    """What a run left: exit code, data and talk."""

    code: int
    out: str
    err: str

    def document(self) -> Any:
        """The one JSON document that stdout holds."""
        assert self.out.endswith("\n") and self.out.count("\n") == 1
        return json.loads(self.out)


def run(*arguments: object, environment: Mapping[str, str] | None = None) -> Result:
    """Run a verb in this process."""
    result = CliRunner(env=environment).invoke(
        cli, [str(a) for a in arguments], prog_name="patterndb"
    )
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return Result(result.exit_code, result.stdout, result.stderr)


def program(
    *arguments: object,
    environment: Mapping[str, str | None] | None = None,
    folder: Path | None = None,
    before: Callable[[], None] | None = None,
    **streams: Any,
) -> Result:
    """Run the program in a process of its own, without a terminal.

    environment: variables to set, or None to unset. before: runs in the child first.
    """
    changed = os.environ | {k: v for k, v in (environment or {}).items() if v is not None}
    for name, value in (environment or {}).items():
        if value is None:
            changed.pop(name, None)
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    done = subprocess.run(
        [*PROGRAM, *map(str, arguments)],
        env=changed,
        cwd=folder,
        preexec_fn=before,
        check=False,
        **(pipes | streams),
    )
    return Result(done.returncode, _text(done.stdout), _text(done.stderr))


def without_privileges() -> None:
    """For a child to run first: file permissions then bind it even where it is root."""
    if os.geteuid() == 0:
        libc = ctypes.CDLL(None, use_errno=True)
        for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
            if libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0):
                raise OSError(ctypes.get_errno(), "prctl")


def _text(data: bytes | None) -> str:
    return (data or b"").decode()


def content_hash(db: Path) -> str:
    """What two databases that answer alike have in common."""
    return run("stats", "--db", db, "--json").document()["content_hash"]


def mesh_names(db: Path) -> list[str]:
    document = run("meshes", "--db", db, "--json").document()
    return [mesh["name"] for mesh in document["meshes"]]


def assert_refused(result: Result, code: int, *words: str) -> None:
    """Nothing on stdout, the words on stderr, and no traceback."""
    assert result.code == code, result.err
    assert result.out == ""
    assert "Traceback" not in result.err and "unforeseen" not in result.err
    for word in words:
        assert word in result.err


def write_obj(path: Path, quads: Sequence[Sequence[int]]) -> Path:
    """A mesh whose vertices lie anywhere: patterns are made of the quads alone."""
    vertices = 1 + max(max(quad) for quad in quads)
    lines = [f"v {i} {i * i} 0" for i in range(vertices)]
    lines += ["f " + " ".join(str(v + 1) for v in quad) for quad in quads]
    path.write_text("\n".join(lines) + "\n")
    return path
