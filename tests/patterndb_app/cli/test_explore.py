"""The verb explore: pictures of it, what the window is given, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import patterndb
from patterndb.errors import PatternDBError
from query import Boundary, fills
from query.placing import Surface
from tests.support.cli.commandline import assert_refused, run
from tests.support.shared import EXAMPLES

SQUARE = [[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]]


@pytest.fixture
def boundary(tmp_path: Path) -> Path:
    """A rectangle with a stroke across it."""
    sides = [[a, b] for a, b in zip(SQUARE, SQUARE[1:] + SQUARE[:1], strict=True)]
    path = tmp_path / "boundary.json"
    stroke = [[0, 1.4, 0], [2, 1.8, 0], [4, 1.4, 0]]
    path.write_text(json.dumps({"sides": sides, "lengths": [4, 3, 4, 3], "strokes": [stroke]}))
    return path


def size_of(picture: Path) -> tuple[int, int]:
    from matplotlib.image import imread

    height, width = np.asarray(imread(picture)).shape[:2]
    return width, height


class Seen(dict[str, Any]):
    """What the window was given."""

    def explore(self, source: object, boundary: Boundary | None, **options: object) -> None:
        self.update(options, source=source, boundary=boundary)


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> Seen:
    seen = Seen()
    monkeypatch.setattr("viewer.explore.explore", seen.explore)
    return seen


def test_pictures_of_ranks(learned: Path, tmp_path: Path, boundary: Path) -> None:
    pictures = [tmp_path / f"{rank}.png" for rank in (1, 2)]
    for rank, picture in enumerate(pictures, 1):
        asked = ("explore", boundary, "--rank", rank, "--db", learned, "-o", picture)
        result = run(*asked)
        assert (result.code, result.out, result.err) == (0, "", f"drawn: {picture}\n")
        assert size_of(picture) == (1400, 860)
    assert pictures[0].read_bytes() != pictures[1].read_bytes()


def test_it_needs_no_display(
    learned: Path, tmp_path: Path, boundary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_refused(run("explore", boundary, "--db", learned), 3, "no display")
    # Nothing that windows need is asked for, let alone needed.
    monkeypatch.setattr("viewer.shell.probe.try_display", lambda: "nothing can be opened")
    picture = tmp_path / "a.png"
    assert run("explore", boundary, "--db", learned, "-o", picture, "--keys", "r").code == 0
    assert picture.exists()


def test_what_the_window_is_given(
    learned: Path, tmp_path: Path, boundary: Path, seen: Seen
) -> None:
    head = EXAMPLES / "head.obj"
    picture = tmp_path / "a.png"
    asked = ("--surface", head, "--tolerance", 2, "--rank", 3, "--keys", "o Right", "-o", picture)
    assert run("explore", boundary, *asked, "--db", learned).code == 0
    assert seen["boundary"].lengths == (4, 3, 4, 3) and len(seen["strokes"]) == 1
    assert isinstance(seen["surface"], Surface) and len(seen["surface"].triangles) == 2 * 834
    assert (seen["tolerance"], seen["rank"], seen["keys"]) == (2, 3, "o Right")
    assert seen["off_screen"] == picture


@pytest.mark.usefixtures("screen")
def test_a_boundary_may_be_drawn_in_the_window(learned: Path, seen: Seen) -> None:
    assert run("explore", "--surface", EXAMPLES / "jug.obj", "--db", learned).code == 0
    assert seen["boundary"] is None and seen["off_screen"] is None


@pytest.mark.usefixtures("screen")
def test_what_is_saved_counts_as_used_where_a_database_can_be_written(db: Path, seen: Seen) -> None:
    for starter in ((), ("--db", ":starter:")):
        assert run("explore", "--sides=3,5,4,6", *starter).code == 0
        assert seen["accept"] is None, "the starter is never written to, and saving is no error"
    assert run("explore", "--sides=3,5,4,6", "--db", db).code == 0
    with patterndb.open(db) as source:
        fill = next(iter(fills(source, Boundary((3, 5, 4, 6)))))
    assert "1 use of pattern" in seen["accept"](fill)


@pytest.mark.parametrize(
    ("options", "wanted"),
    [
        (("--sides=3,5,4,6",), Boundary((3, 5, 4, 6))),
        (("--sides=12", "--closed"), Boundary.closed(12)),
        (
            ("--sides=6,2,4,4,2,4", "--corners=c,c,c,r,c,c"),
            Boundary((6, 2, 4, 4, 2, 4), ("convex",) * 3 + ("reflex",) + ("convex",) * 2),
        ),
    ],
)
@pytest.mark.usefixtures("screen")
def test_flat_boundaries(
    learned: Path, seen: Seen, options: tuple[str, ...], wanted: Boundary
) -> None:
    assert run("explore", *options, "--db", learned).code == 0
    assert seen["boundary"] == wanted
    points = seen["boundary"].points
    assert len(points) == wanted.perimeter and (points[:, 2] == 0.0).all()


def test_wrong_usage(learned: Path, tmp_path: Path, boundary: Path) -> None:
    picture = tmp_path / "a.png"
    asked = ("--db", learned, "-o", picture)
    for wrong, word in (
        ((), "nothing to fill"),
        (("--surface", EXAMPLES / "jug.obj"), "nothing to fill"),
        ((boundary, "--sides=2,2,2,2"), "--sides"),
        (("--sides=2,2,2,2", "--surface", EXAMPLES / "jug.obj"), "--sides"),
        ((boundary, "--closed"), "--closed"),
        ((boundary, "--corners=c,c,c,c"), "--corners"),
        ((boundary, "--keys=zz"), "no key 'zz'"),
        ((boundary, "--rank=0"), "--rank"),
    ):
        assert_refused(run("explore", *wrong, *asked), 2, word)
    for name, word in (("a.svg", "must end in .png"), ("no/a.png", "there is no folder")):
        assert_refused(run("explore", boundary, "-o", tmp_path / name), 2, word)
    assert not picture.exists()


def test_nothing_to_show(learned: Path, tmp_path: Path, boundary: Path) -> None:
    picture = tmp_path / "a.png"
    asked = ("--db", learned, "-o", picture)
    assert_refused(run("explore", "--sides=3,4,4", *asked), 3, "odd")
    assert_refused(run("explore", tmp_path / "no.json", *asked), 3, "no.json")
    boundary.write_text('{"sides": 3}')
    assert_refused(run("explore", boundary, *asked), 3, "boundary.json", "sides")
    many = run("explore", "--sides=1,1,1,1", "--rank", 5000, *asked)
    assert_refused(many, 1, "there is no fill 5000, only ")
    assert not picture.exists()


@pytest.mark.usefixtures("screen")
def test_errors_of_the_window_are_explained(
    learned: Path, boundary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise PatternDBError("no light in the window")

    monkeypatch.setattr("viewer.explore.explore", broken)
    result = run("explore", boundary, "--db", learned)
    assert_refused(result, 3, "patterndb: no light in the window")
