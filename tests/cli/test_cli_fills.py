"""The fills of ``patterndb query --json``, checked by a program that shares nothing with ours."""

from __future__ import annotations

import importlib
import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from commandline import run
from shared import SHARED

CHECKER = SHARED / "oracle" / "check_fill.py"


def boundaries(n_sides: int, count: int) -> list[list[int]]:
    """Random lengths with an even sum."""
    chance = random.Random(n_sides)
    found: list[list[int]] = []
    while len(found) < count:
        lengths = [chance.randint(2, 6) for _ in range(n_sides)]
        if sum(lengths) % 2 == 0 and sum(lengths) >= 4:
            found.append(lengths)
    return found


def ask(db: Path, lengths: list[int], *options: object) -> dict[str, Any]:
    sides = ",".join(map(str, lengths))
    result = run("query", "--sides", sides, "--db", db, "--limit", 30, "--json", *options)
    document = result.document()
    assert result.code == (0 if document["fills"] else 1)
    return document


@pytest.mark.parametrize("n_sides", range(1, 9))
def test_every_fill_is_a_fill(learned: Path, n_sides: int) -> None:
    wanted = [[6], [8], [10]] if n_sides == 1 else boundaries(n_sides, 12)
    lines = [json.dumps(ask(learned, lengths)) for lengths in wanted]
    checked = subprocess.run(
        [sys.executable, CHECKER],
        input="\n".join(lines),
        capture_output=True,
        text=True,
        check=True,
    )
    report = json.loads(checked.stdout)
    assert report["queries"] == len(wanted)
    assert report["fills"] > 0
    assert report["strict"] == report["fills"]
    assert report["bad"] == 0


def test_closed_fills(learned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(CHECKER.parent)
    checker = importlib.import_module("check_fill")
    fills = 0
    for length in (8, 10, 12, 14):
        for fill in ask(learned, [length], "--closed")["fills"]:
            # Where there is no corner, the vertex that the side begins at has two quads.
            wrong, irregular = checker.check([length], fill, kinds=[2])
            assert wrong is None
            assert irregular[1] == 0
            fills += 1
    assert fills > 0
