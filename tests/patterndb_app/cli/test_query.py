"""patterndb query: corners, strokes, relaxed boundaries and wrong options, told from the quads
that it lists, which are checked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.support.cli.commandline import assert_refused, run
from tests.support.cli.querychecks import ALL, FEW, LOOPED, Fill, codes, document, fills, list_few
from tests.support.fillchecks import off, strands

#: L-shaped, its fourth corner reflex.
CORNER = ("--sides=6,2,4,2,2,4", "--corners=c,c,c,r,c,c")


@pytest.fixture(scope="module")
def few(learned: Path) -> list[Fill]:
    """All fills of FEW, in the default order."""
    return list_few(learned)


class TestCorners:
    def test_reflex(self, learned: Path) -> None:
        answer = document(learned, *CORNER, "--order=regular")
        assert answer["corners"] == ["convex"] * 3 + ["reflex"] + ["convex"] * 2
        best = answer["fills"][0]
        assert best["n_irregular"] == 0 and len(best["quads"]) == 6 * 4 - 4 * 2
        long = document(learned, CORNER[0], "--corners", "convex,C,c,Reflex,c, c")
        assert long["fills"] == document(learned, *CORNER)["fills"]
        convex = document(learned, CORNER[0], "--order=regular")
        assert convex["corners"] == ["convex"] * 6
        assert convex["fills"][0]["n_irregular"] > 0

    def test_strict_ones_have_three_quads_there(self, learned: Path) -> None:
        listed = fills(learned, *CORNER, "--strict")
        assert listed and all(fill["strict"] for fill in listed)
        for fill in listed:
            assert sum(fill["sides"][3][0] in quad for quad in fill["quads"]) == 3

    def test_closed(self, learned: Path) -> None:
        answer = document(learned, "--sides=10", "--closed")
        assert answer["corners"] == [] and answer["fills"]


class TestStrokes:
    @pytest.mark.parametrize(
        "strokes",
        [
            [((0, 0), (2, 1))],
            [((1, 1), (3, 2))],
            [((0, 1), (1, 0))],
            [((3, 3), (3, 0))],
            [((0, 0), (2, 1)), ((1, 1), (3, 2))],
            [((1, 0), (3, 3)), ((3, 2), (1, 1))],
            [((0, 0), (2, 1)), ((2, 1), (0, 0))],
        ],
        ids=str,
    )
    def test_exactly_the_fills_with_strands_on_them(
        self, learned: Path, few: list[Fill], strokes: list[Any]
    ) -> None:
        flows = [f"--flow={a}:{i}-{b}:{j}" for (a, i), (b, j) in strokes]
        for tolerance in (0, 1, 2):
            listed = fills(learned, *FEW, *ALL, *flows, "--tolerance", tolerance)
            for fill in listed:
                assert fill["flow_distance"] == off(fill, strokes, tolerance)
            expected = [fill for fill in few if off(fill, strokes, tolerance) is not None]
            assert codes(listed) == codes(expected)

    def test_the_table_tells_how_far_they_are_off(self, learned: Path) -> None:
        asked = ("query", *FEW, "--flow=0:0-2:1", "--db", learned)
        listed = run(*asked, "--json", "--flat").document()["fills"]
        head, *lines = run(*asked, "--flat").out.splitlines()
        assert head.split()[:5] == ["rank", "pattern", "irregular", "off", "quads"]
        at = head.index("off") + len("off")
        shown = [line[:at].split()[-1] for line in lines]
        assert shown == [f"{fill['flow_distance']:g}" for fill in listed]

    def test_loops(self, learned: Path) -> None:
        looped = [fill for fill in fills(learned, *LOOPED, *ALL) if strands(fill)[1]]
        listed = fills(learned, *LOOPED, *ALL, "--loop")
        assert listed and all(fill["flow_distance"] == 0 for fill in listed)
        assert codes(listed) == codes(looped)
        # One loop may be widened to carry both.
        two = fills(learned, *LOOPED, *ALL, "--loop", "--loop")
        assert all(strands(fill)[1] >= 2 for fill in two)
        assert len(two) >= len(listed)

    def test_a_loop_and_a_strand(self, learned: Path) -> None:
        strokes = [((0, 2), (2, 2))]
        listed = fills(learned, "--sides=5,5,5,5", "--flow=0:2-2:2", "--loop")
        assert listed
        for fill in listed:
            assert strands(fill)[1] >= 1
            assert fill["flow_distance"] == off(fill, strokes, 1)

    def test_nothing_follows_them(self, learned: Path) -> None:
        result = run("query", *FEW, "--flow=0:0-0:1", "--db", learned)
        assert_refused(result, 1, "no fill", "strokes", "tolerance")


class TestRelaxed:
    def test_strict_and_relaxed(self, learned: Path, few: list[Fill]) -> None:
        assert fills(learned, *FEW, *ALL, "--relaxed") == few
        strict = fills(learned, *FEW, *ALL, "--strict")
        assert strict and all(fill["strict"] for fill in strict)
        assert codes(strict) == codes([fill for fill in few if fill["strict"]])

    @pytest.mark.parametrize("most", range(5))
    def test_max_boundary_irregular(self, learned: Path, few: list[Fill], most: int) -> None:
        listed = fills(learned, *FEW, *ALL, "--max-boundary-irregular", most)
        tabled = [f for f in listed if f["origin"] != "constructed"]
        assert all(f["n_irregular_boundary"] <= most for f in tabled)
        assert len({f["n_irregular_boundary"] for f in tabled}) == most + 1
        if most <= 3:
            # 3 is what there is without the option.
            kept = [f for f in few if f["n_irregular_boundary"] <= most]
            assert codes(tabled) == codes([f for f in kept if f["origin"] != "constructed"])

    @pytest.mark.parametrize("sides", ["2,2", "4", "2,1,1", "1,1,1,1,1,1", "1,9", "7,1,1,1"])
    def test_never_empty_handed(self, learned: Path, sides: str) -> None:
        answer = document(learned, f"--sides={sides}")
        assert answer["fills"]
        assert answer["fills"][0]["n_irregular"] == min(f["n_irregular"] for f in answer["fills"])


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (("--corners=c,c,r",), 3, ("4 sides have 4 corners, not 3", "name every corner")),
        (("--corners=c,c,r,x",), 2, ("--corners", "'x' is no corner", "r for reflex")),
        (("--corners=",), 2, ("--corners", "c for convex")),
        (("--flow=0:2",), 2, ("--flow", "0:2-3:1")),
        (("--flow=0:2-3",), 2, ("--flow", "0:2-3:1")),
        (("--flow=-1:0-2:0",), 2, ("--flow",)),
        (("--flow=0:0-4:0",), 3, ("side 4", "0 to 3")),
        (("--flow=0:3-2:0",), 3, ("edge 3 of side 0", "0 to 2")),
        (("--flow=1:1-1:1",), 3, ("edge 1 of side 1", "two different edges")),
        (("--tolerance=-1",), 2, ("--tolerance",)),
        (("--max-boundary-irregular=-1",), 2, ("--max-boundary-irregular",)),
        (("--max-quads=0",), 2, ("--max-quads",)),
        (("--pattern-corners=5..3",), 2, ("--pattern-corners", "3..5")),
        (("--min-frequency=0",), 2, ("--min-frequency",)),
        (("--order=best",), 2, ("--order", "artist", "regular")),
        (("--time-limit=0",), 2, ("--time-limit",)),
        (("--time-limit=nan",), 2, ("--time-limit", "nan is no number of seconds")),
        (("--per-pattern=-1",), 2, ("--per-pattern",)),
        (("--jobs=0",), 2, ("--jobs",)),
        (("--closed",), 2, ("--closed", "one length")),
        (("--from-mesh=gone.obj",), 1, ("gone.obj", "patterndb meshes")),
        (("--from-licence=gone",), 1, ("gone",)),
        (("--batch=lines.txt",), 2, ("--sides or --batch",)),
    ],
    ids=str,
)
def test_wrong_options_say_what_would_do(
    learned: Path, options: tuple[str, ...], code: int, words: tuple[str, ...]
) -> None:
    assert_refused(run("query", "--sides=3,5,4,6", "--db", learned, *options), code, *words)
