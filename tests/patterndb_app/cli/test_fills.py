"""The fills of ``patterndb query --json``, checked by plain Python."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

from tests.support.cli.commandline import run
from tests.support.fillchecks import check_fill

#: Options under which fills are strict ones of patterns that were learned.
LEARNED = ("--strict", "--learned-only", "--order", "regular")


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
    result = run("query", "--sides", sides, "--db", db, "--limit", 30, "--json", "--flat", *options)
    document = result.document()
    assert result.code == (0 if document["fills"] else 1)
    return document


def count_strict(documents: list[dict[str, Any]]) -> int:
    """Check every fill of some answers; return how many are regular on the boundary."""
    strict = 0
    for document in documents:
        for fill in document["fills"]:
            strict += check_fill(document["sides"], fill)[1] == 0
    return strict


@pytest.mark.parametrize("options", [(), LEARNED], ids=["default", "learned"])
@pytest.mark.parametrize("n_sides", range(1, 9))
def test_every_fill_is_a_fill(learned: Path, n_sides: int, options: tuple[str, ...]) -> None:
    wanted = [[6], [8], [10]] if n_sides == 1 else boundaries(n_sides, 12)
    documents = [ask(learned, lengths, *options) for lengths in wanted]
    fills = [fill for document in documents for fill in document["fills"]]
    assert fills
    strict = count_strict(documents)
    assert strict == sum(fill["strict"] for fill in fills)
    if options:
        assert strict == len(fills)
    else:
        assert all(document["fills"] for document in documents)


@pytest.mark.parametrize("n_sides", [1, 2, 3, 5, 6, 7, 9])
def test_boundaries_with_the_shortest_sides_are_filled(learned: Path, n_sides: int) -> None:
    """Where no strict fill can be."""
    wanted = [
        lengths
        for last in (1, 2, 3, 4, 5)
        if sum(lengths := [1] * (n_sides - 1) + [last]) % 2 == 0 and sum(lengths) >= 4
    ]
    documents = [ask(learned, lengths) for lengths in wanted]
    assert all(document["fills"] for document in documents)
    assert count_strict(documents) == 0


def test_closed_fills(learned: Path) -> None:
    for options in ((), LEARNED):
        strict = relaxed = 0
        for length in (8, 10, 12, 14):
            for fill in ask(learned, [length], "--closed", *options)["fills"]:
                # Where there is no corner, the vertex that the side begins at has two quads.
                irregular = check_fill([length], fill, kinds=[2])
                assert irregular[1] == fill["n_irregular_boundary"]
                strict += fill["strict"]
                relaxed += not fill["strict"]
        assert strict > 0
        assert (relaxed == 0) == bool(options)
