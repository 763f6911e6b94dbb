"""SIGKILL at random moments of every way to write: some kills of benchmarks/kill_writes.py."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).parents[3] / "benchmarks" / "kill_writes.py"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork()")
def test_a_killed_write_leaves_what_was_before_or_after() -> None:
    # In a process of its own: one that runs threads must not fork.
    command = [sys.executable, os.fspath(BENCHMARK), "--kills", "16", "--seed", "5"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    # Two of each: of databases, and of networks, sessions and the autosave.
    assert set(json.loads(done.stdout)["killed"].values()) == {2}
