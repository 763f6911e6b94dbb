"""Fills that patterndb query lists, each checked."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from tests.support.cli.commandline import run
from tests.support.fillchecks import QUADS_AT, check_fill, code, irregular

Fill = dict[str, Any]

#: A boundary whose fills are few enough to be listed all.
FEW = ("--sides=2,3,3,4",)
ALL = ("--limit", 100_000)

#: One of which some fills have loops.
LOOPED = ("--sides=5,5",)


@cache
def checked(asked: str) -> tuple[int, int]:
    """What the checker counts; many tests list the same fills."""
    sides, corners, fill = json.loads(asked)
    kinds = [QUADS_AT[kind] for kind in corners] or [2]
    return check_fill(sides, fill, kinds)


def document(db: Path, *arguments: object) -> dict[str, Any]:
    """The answer, after every fill is found to be one, none twice, and as it says it is."""
    result = run("query", "--db", db, "--json", "--flat", *arguments)
    answer = result.document()
    assert result.code == (0 if answer["fills"] else 1), result.err
    assert (answer["reason"] is None) == bool(answer["fills"])
    corners = answer["corners"]
    for fill in answer["fills"]:
        counted = irregular(fill, corners)
        assert checked(json.dumps([answer["sides"], corners, fill])) == counted
        assert (fill["n_irregular"], fill["n_irregular_boundary"]) == (sum(counted), counted[1])
        assert fill["strict"] == (counted[1] == 0)
        assert (fill["frequency"] > 0) == (fill["origin"] == "learned")
    codes = [code(fill) for fill in answer["fills"]]
    assert len(set(codes)) == len(codes)
    return answer


def fills(db: Path, *arguments: object) -> list[Fill]:
    return document(db, *arguments)["fills"]


def codes(listed: list[Fill]) -> set[tuple[int, ...]]:
    return {tuple(code(fill)) for fill in listed}


@cache
def list_few(learned: Path) -> list[Fill]:
    """All fills of FEW, in the default order. Not to be changed: they are everyone's."""
    answer = document(learned, *FEW, *ALL)
    assert not answer["truncated"]
    assert {fill["origin"] for fill in answer["fills"]} >= {"learned", "family"}
    return answer["fills"]
