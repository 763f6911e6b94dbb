"""patterndb query --batch: a line of JSON for every line, as single queries answer it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from ingest.formats import read_mesh
from tests.support.cli.commandline import Result, assert_refused, program, run

#: Lines, and the options of the single query that asks the same.
SAME = (
    ("3,5,4,6", ("--sides=3,5,4,6",)),
    (" 2, 3,3 ,4 ", ("--sides=2,3,3,4",)),
    ("8", ("--sides=8",)),
    ('{"sides": [2, 1, 1]}', ("--sides=2,1,1",)),
    ('{"sides": [8], "corners": []}', ("--sides=8", "--closed")),
    ('{"sides": [4.0, 4, 4, 4], "corners": null}', ("--sides=4,4,4,4",)),
    (
        '{"sides": [6,2,4,2,2,4], "corners": ["c", "convex", "c", "reflex", "c", "c"]}',
        ("--sides=6,2,4,2,2,4", "--corners=c,c,c,r,c,c"),
    ),
    (
        '{"sides": [3,5,4,6], "strokes": [[[0,1],[2,1]], [[1, 0], [3, 5]]]}',
        ("--sides=3,5,4,6", "--flow=0:1-2:1", "--flow=1:0-3:5"),
    ),
    ('{"sides": [5,5], "loops": 2}', ("--sides=5,5", "--loop", "--loop")),
    (
        '{"sides": [3,5,4,6], "max_quads": 60, "valence": [3, 5], "strict": true}',
        ("--sides=3,5,4,6", "--max-quads=60", "--valence=3..5", "--strict"),
    ),
    (
        '{"mesh": "head.obj", "sides": [4,4,3,3,4], "irregular": 1, "quads": [[0,1,2,3]]}',
        ("--sides=4,4,3,3,4",),
    ),
)

#: Lines that are no boundary, and what is said of them.
WRONG = (
    ("3,5,4,5", ("perimeter 17 is odd", "change one side")),
    ("0,4", ("every side needs at least 1 edge",)),
    ("3,x,4", ("'x'", "no whole number")),
    ("3;4", ("'3;4'", "no whole number")),
    ('{"sides": [3,5,4,6]', ("not JSON",)),
    ("{" + '"a":{' * 100_000, ("not JSON",)),
    ("{}", ("sides is None", "give a list")),
    ('{"sides": "3,5,4,6"}', ("sides is '3,5,4,6'", "give a list")),
    ('{"sides": [3,5,4,6.5]}', ("6.5", "no whole number")),
    ('{"sides": [3,5,4,true]}', ("True", "no whole number")),
    ('{"sides": [3,5,4,NaN]}', ("NaN", "no number that JSON has")),
    ('{"sides": [4,4,4,4], "corners": ["c", "c", "c"]}', ("4 corners, not 3",)),
    ('{"sides": [4,4,4,4], "corners": "cccc"}', ("corners is 'cccc'", "give a list")),
    ('{"sides": [4,4,4,4], "corners": ["c", "c", "c", "flat"]}', ("'flat'", '"reflex"')),
    ('{"sides": [4,4,4,4], "corners": ["c", "c", "c", ["r"]]}', ("['r']", '"reflex"')),
    ('{"sides": [4,4,4,4], "strokes": [[0, 2]]}', ("stroke 0", "[[side, edge], [side, edge]]")),
    ('{"sides": [4,4,4,4], "strokes": [[[0,1],[2,"b"]]]}', ("'b'", "stroke 0")),
    ('{"sides": [4,4,4,4], "strokes": [[[0,1],[7,1]]]}', ("side 7", "0 to 3")),
    ('{"sides": [4,4,4,4], "strokes": [[[0,1],[0,1]]]}', ("two different edges",)),
    ('{"sides": [4,4,4,4], "strokes": 3}', ("strokes is 3", "give a list")),
    ('{"sides": [4,4,4,4], "loops": -1}', ("loops is -1", "from 0")),
    ('{"sides": [4,4,4,4], "max_quads": 0}', ("max", "the least is 1")),
    ('{"sides": [4,4,4,4], "loops": true}', ("loops is True", "from 0")),
)


@pytest.fixture
def lines(tmp_path: Path) -> Path:
    return tmp_path / "lines.jsonl"


def batch(db: Path, lines: Path, *options: object) -> tuple[Result, list[dict[str, Any]]]:
    result = run("query", "--batch", lines, "--db", db, *options)
    assert result.out.endswith("\n") or not result.out
    return result, [json.loads(line) for line in result.out.splitlines()]


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--limit=3", "--order=regular", "--json"),
        ("--strict", "--learned-only", "--per-pattern=1", "--tolerance=0"),
    ],
    ids=str,
)
def test_every_line_is_answered_as_it_is_alone(
    learned: Path, lines: Path, options: tuple[str, ...]
) -> None:
    lines.write_text("\n".join(line for line, _ in SAME) + "\n")
    result, answers = batch(learned, lines, *options)
    assert [answer["line"] for answer in answers] == list(range(1, len(SAME) + 1))
    empty = 0
    for answer, (_, asked) in zip(answers, SAME, strict=True):
        alone = run("query", *asked, "--db", learned, *{*options, "--json"}).document()
        empty += not alone["fills"]
        assert answer.keys() == (alone.keys() | {"line"}) - {"feasible_patterns"}
        for fill in alone["fills"]:
            # A batch does not count how many more fills a pattern has.
            fill.pop("variants", None)
        for key in ("sides", "corners", "truncated", "stopped", "reason", "fills"):
            assert answer[key] == alone[key]
    assert (empty > 0) == ("--strict" in options)
    assert result.code == (1 if empty else 0)
    assert (
        result.err == f"{len(SAME)} boundaries, {empty} without a fill, 0 that could not be read\n"
    )


def test_a_wrong_line_stops_none_of_the_others(learned: Path, lines: Path) -> None:
    text = ["2,2,2,2"]
    for line, _ in WRONG:
        text += [line, "", "2,2,2,2"]
    lines.write_text("\r\n".join(text), encoding="utf-8")
    result, answers = batch(learned, lines, "--limit=1")
    assert result.code == 3
    total = 2 * len(WRONG) + 1
    assert result.err == (
        f"{total} boundaries, 0 without a fill, {len(WRONG)} that could not be read\n"
    )
    # Empty lines count as lines, but are no question.
    assert [answer["line"] for answer in answers] == [
        n for n, line in enumerate(text, 1) if line.strip()
    ]
    for answer, (line, words) in zip(answers[1::2], WRONG, strict=True):
        assert answer.keys() == {"line", "error"}, line
        for word in words:
            assert word in answer["error"], line
    good = answers[::2]
    assert all(answer["fills"] == good[0]["fills"] and answer["fills"] for answer in good)


def test_lines_are_written_one_by_one(learned: Path, lines: Path) -> None:
    lines.write_text("2,2\n3,4\n2,2,2,2\n")
    result = run("query", "--batch", lines, "--strict", "--db", learned)
    assert [json.loads(line)["line"] for line in result.out.splitlines()] == [1, 2, 3]
    # Bad input outweighs what has no fill.
    assert result.code == 3
    lines.write_text("2,2\n2,2,2,2\n")
    assert run("query", "--batch", lines, "--strict", "--db", learned).code == 1
    lines.write_text("2,2,2,2\n")
    assert run("query", "--batch", lines, "--strict", "--db", learned).code == 0


def test_nothing_asked(learned: Path, lines: Path) -> None:
    lines.write_text("\n  \n")
    result, answers = batch(learned, lines)
    assert (result.code, answers) == (0, [])
    assert result.err == "0 boundaries, 0 without a fill, 0 that could not be read\n"


@pytest.mark.parametrize(
    "option",
    [
        ("--sides=2,2,2,2",),
        ("--closed",),
        ("--corners=c,c",),
        ("--flow=0:0-1:0",),
        ("--loop",),
    ],
    ids=str,
)
def test_options_of_single_queries_are_refused(
    learned: Path, lines: Path, option: tuple[str, ...]
) -> None:
    lines.write_text("2,2,2,2\n")
    assert_refused(run("query", "--batch", lines, "--db", learned, *option), 2, "--batch")


def test_files_and_pictures_of_every_line(learned: Path, lines: Path, tmp_path: Path) -> None:
    lines.write_text("2,2,2,2\n1,2\n\n3,3,2,2,2\n")
    folder, image = tmp_path / "fills", tmp_path / "fills.svg"
    _, answers = batch(learned, lines, "--limit=2", "--obj", folder, "--image", image)
    answered = {a["line"]: a["fills"] for a in answers if "fills" in a}
    assert list(answered) == [1, 4]
    assert sorted(p.name for p in folder.iterdir()) == ["line-001", "line-004"]
    for line, fills in answered.items():
        files = sorted((folder / f"line-{line:03}").iterdir())
        quads = [read_mesh(path).quads()[0].tolist() for path in files]
        assert quads == [fill["quads"] for fill in fills]
        text = (tmp_path / f"fills-line-{line}.svg").read_text()
        assert all(fill["pattern"] in text for fill in fills)
    assert not image.exists()


def test_what_no_line_can_mend_ends_the_run(learned: Path, lines: Path) -> None:
    lines.write_text("2,2,2,2\n" * 3)
    asked = ("query", "--batch", lines, "--db", learned)
    assert_refused(run(*asked, "--from-mesh=gone.obj"), 1, "gone.obj")
    assert_refused(run(*asked, "--valence=5..3"), 2, "--valence")


def test_files_that_cannot_be_read(learned: Path, lines: Path, tmp_path: Path) -> None:
    for path in (tmp_path / "gone.jsonl", tmp_path):
        result = program("query", "--batch", path, "--db", learned)
        assert_refused(result, 3, str(path))


def test_lines_that_are_no_text(learned: Path, lines: Path) -> None:
    lines.write_bytes(b"\xef\xbb\xbf2,2,2,2\n2,\xff\n2,2,2,2\n")
    result, answers = batch(learned, lines)
    assert result.code == 3
    assert answers[0]["fills"] and answers[0]["fills"] == answers[2]["fills"]
    assert answers[1].keys() == {"line", "error"} and "UTF-8" in answers[1]["error"]
