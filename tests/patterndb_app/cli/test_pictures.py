"""patterndb show, gallery and browse, and the pictures of query."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from patterndb.errors import PatternDBError
from tests.support.cli.commandline import assert_refused, run

PNG = b"\x89PNG\r\n\x1a\n"


def is_picture(path: Path) -> bool:
    if path.suffix.lower() == ".png":
        return path.read_bytes().startswith(PNG)
    return ElementTree.parse(path).getroot().tag.endswith("svg")


@pytest.fixture
def name(learned: Path) -> str:
    """Of the first pattern with three sides."""
    fills = run("query", "--sides", "2,2,2", "--db", learned, "--json").document()["fills"]
    return fills[0]["pattern"]


class TestShow:
    @pytest.mark.parametrize("suffix", [".png", ".svg", ".PNG"])
    def test_pattern(self, learned: Path, tmp_path: Path, name: str, suffix: str) -> None:
        picture = tmp_path / f"ä b{suffix}"
        result = run("show", name, "--db", learned, "-o", picture)
        assert (result.code, result.out) == (0, "")
        assert result.err == f"drawn: {picture}\n"
        assert is_picture(picture)

    def test_first_digits_in_either_case(self, learned: Path, tmp_path: Path, name: str) -> None:
        pictures = [tmp_path / f"{k}.svg" for k in range(2)]
        for picture, digits in zip(pictures, (name, name[:12].upper()), strict=True):
            assert run("show", digits, "--db", learned, "-o", picture).code == 0
        assert pictures[0].read_bytes() == pictures[1].read_bytes()
        assert name in pictures[0].read_text()

    def test_fill_by_rank(self, learned: Path, tmp_path: Path) -> None:
        listed = run("query", "--sides=3,5,4,6", "--db", learned, "--json", "--flat")
        fills = listed.document()["fills"]
        picture = tmp_path / "fill.svg"
        asked = ("show", "--sides=3,5,4,6", "--rank", 5, "--db", learned, "-o", picture)
        assert run(*asked, "--flat").code == 0
        assert fills[4]["pattern"] in picture.read_text()
        # Of different patterns, unless all are asked for.
        assert run(*asked).code == 0
        assert list(dict.fromkeys(fill["pattern"] for fill in fills))[4] in picture.read_text()

    def test_widened(self, learned: Path, tmp_path: Path) -> None:
        fill = run("query", "--sides=3,4,5", "--db", learned, "--json").document()["fills"][0]
        widths = ",".join(map(str, fill["widths"]))
        picture = tmp_path / "wide.svg"
        asked = ("show", fill["pattern"], "--db", learned, "-o", picture)
        assert run(*asked, "--widths", widths).code == 0
        quads = ElementTree.parse(picture).findall(".//{*}g[@id='quads']/{*}path")
        assert len(quads) == len(fill["quads"])
        plain = tmp_path / "plain.svg"
        assert run(*asked[:-1], plain, "--widths", widths, "--plain").code == 0
        assert plain.read_bytes() != picture.read_bytes()

    @pytest.mark.parametrize(("widths", "code"), [("1", 3), ("0,1,1", 3), ("1,2,x", 2), ("", 2)])
    def test_wrong_widths(
        self, learned: Path, tmp_path: Path, name: str, widths: str, code: int
    ) -> None:
        picture = tmp_path / "a.svg"
        result = run("show", name, "--db", learned, "-o", picture, "--widths", widths)
        assert_refused(result, code, "width")
        assert not picture.exists()

    @pytest.mark.parametrize(
        ("digits", "word"),
        [
            ("ffffffff", "no pattern's name begins with ffffffff"),
            ("04", "more than one"),
            ("zz", "no pattern name"),
            ("", "no pattern name"),
            ("0" * 17, "no pattern name"),
            ("../../etc/passwd", "no pattern name"),
        ],
    )
    def test_unknown_and_ambiguous(
        self, learned: Path, tmp_path: Path, digits: str, word: str
    ) -> None:
        picture = tmp_path / "a.svg"
        assert_refused(run("show", digits, "--db", learned, "-o", picture), 1, word)
        assert not picture.exists()

    def test_rank_beyond_the_last(self, learned: Path, tmp_path: Path) -> None:
        asked = ("show", "--sides=2,2,2,2", "--db", learned, "-o", tmp_path / "a.svg")
        assert_refused(run(*asked, "--rank", 999), 1, "there is no fill 999, only ")
        assert_refused(run(*asked, "--rank", 0), 2, "--rank")

    def test_fewer_fills(self, learned: Path, tmp_path: Path) -> None:
        picture = tmp_path / "a.svg"
        asked = ("show", "--sides=2,2", "--db", learned, "-o", picture)
        assert_refused(run(*asked, "--rank", 2), 1, "there is no fill 2, only 1 pattern")
        flat = run(*asked, "--rank", 2, "--flat")
        assert_refused(flat, 1, "there is no fill 2, only 1 fill")
        assert not picture.exists()
        assert run(*asked).code == 0 and is_picture(picture)

    def test_one_thing_to_show(self, learned: Path, tmp_path: Path, name: str) -> None:
        asked = ("--db", learned, "-o", tmp_path / "a.svg")
        assert_refused(run("show", *asked), 2, "--sides")
        assert_refused(run("show", name, "--sides=2,2,2", *asked), 2, "--sides")
        assert_refused(run("show", "--sides=2,2,2", "--widths=1", *asked), 2, "--widths")
        assert_refused(run("show", name, "--db", learned), 2, "--output")


class TestGallery:
    def test_class(self, learned: Path, tmp_path: Path) -> None:
        sheet = tmp_path / "five.svg"
        result = run("gallery", "--class", 5, "--limit", 4, "--db", learned, "-o", sheet)
        assert (result.code, result.out, result.err) == (0, "", f"drawn: {sheet}\n")
        assert is_picture(sheet)
        assert "the first 4 of" in sheet.read_text()

    def test_fills(self, learned: Path, tmp_path: Path) -> None:
        sheet = tmp_path / "fills.png"
        assert run("gallery", "--sides=3,5,4,6", "--db", learned, "-o", sheet).code == 0
        assert is_picture(sheet)
        none = ("gallery", "--sides=2,2", "--max-irregular", 0, "--db", learned, "-o", sheet)
        assert_refused(run(*none), 1, "no fill")

    def test_pages_are_numbered(self, learned: Path, tmp_path: Path) -> None:
        sheet = tmp_path / "sheet.svg"
        asked = ("--class", 5, "--limit", 5, "--per-page", 2)
        result = run("gallery", *asked, "--db", learned, "-o", sheet)
        pages = [tmp_path / f"sheet-{k}.svg" for k in (1, 2, 3)]
        assert sorted(tmp_path.iterdir()) == pages and all(map(is_picture, pages))
        assert result.err.splitlines() == [f"drawn: {page}" for page in pages]

    def test_filters(self, learned: Path, tmp_path: Path) -> None:
        counts: list[int] = []
        for k, options in enumerate(
            [(), ("--convex",), ("--max-irregular", 1), ("--valence", "5")]
        ):
            sheet = tmp_path / f"{k}.svg"
            asked = ("gallery", "--class", 5, "--limit", 500, "--per-page", 200, *options)
            assert run(*asked, "--db", learned, "-o", sheet).code == 0
            tree = ElementTree.parse(sheet)
            groups = {g.get("id", "") for g in tree.findall(".//{*}g")}
            counts.append(sum(g.startswith("quads-") for g in groups))
        by_sides = run("stats", "--db", learned, "--json").document()["by_sides"]
        assert counts[0] == by_sides["5"]
        assert all(0 < count < counts[0] for count in counts[1:])

    def test_nothing_passes(self, learned: Path, tmp_path: Path) -> None:
        asked = ("gallery", "--db", learned, "-o", tmp_path / "a.png", "--class")
        assert_refused(run(*asked, 99), 1, "no such pattern of 99 sides")
        assert_refused(run(*asked, 5, "--max-irregular", 0), 1, "no such pattern")
        assert list(tmp_path.iterdir()) == []

    def test_one_thing_to_draw(self, learned: Path, tmp_path: Path) -> None:
        asked = ("gallery", "--db", learned, "-o", tmp_path / "a.png")
        assert_refused(run(*asked), 2, "--class")
        assert_refused(run(*asked, "--class", 5, "--sides=2,2,2"), 2, "--class")
        assert_refused(run(*asked, "--convex", "--sides=2,2,2"), 2, "--convex")
        assert_refused(run(*asked, "--class", 5, "--per-page", 201), 2, "--per-page")


@pytest.mark.parametrize("verb", ["show", "gallery", "browse", "query"])
def test_picture_names(learned: Path, tmp_path: Path, verb: str) -> None:
    what = {
        "show": ("0", "-o"),
        "gallery": ("--class=4", "-o"),
        "browse": ("-o",),
        "query": ("--sides=2,2,2,2", "--image"),
    }[verb]
    for picture, word in (
        ("a.bmp", "must end in .png"),
        ("png", "must end in .png"),
        ("", "the name is empty"),
        (tmp_path / "no" / "a.png", "there is no folder"),
        (tmp_path / "folder.png", "is a folder"),
    ):
        (tmp_path / "folder.png").mkdir(exist_ok=True)
        assert_refused(run(verb, "--db", learned, *what, picture), 2, word)


def test_query_draws_a_sheet(learned: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "fills.svg"
    result = run("query", "--sides=3,5,4,6", "--db", learned, "--image", sheet, "--json")
    fills = result.document()["fills"]
    text = sheet.read_text()
    assert f"drawn: {sheet}\n" in result.err
    assert all(fill["pattern"] in text for fill in fills)


class TestBrowse:
    def test_without_a_display(self, learned: Path) -> None:
        assert_refused(run("browse", "--db", learned), 3, "no display")

    def test_passes_what_was_asked(
        self, learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        seen: dict[str, object] = {}

        def browse(source: object, **options: object) -> None:
            seen.update(options)
            pattern = source.pattern_class(4).pattern(0)  # type: ignore[attr-defined]
            disk = options["expand"](pattern, [2] * pattern.n_chords)  # type: ignore[operator]
            seen["quads"] = len(disk.quads)
            seen["names"] = options["meshes"](pattern)  # type: ignore[operator]

        monkeypatch.setattr("viewer.browse", browse)
        picture = tmp_path / "page.png"
        asked = ("--class", 5, "--keys", "n n ] Up", "-o", picture)
        result = run("browse", "--db", learned, *asked)
        assert (result.code, result.out, result.err) == (0, "", f"drawn: {picture}\n")
        assert (seen["n_sides"], seen["keys"], seen["off_screen"]) == (5, "n n ] Up", picture)
        assert seen["quads"] == 4
        assert seen["names"] and set(seen["names"]) <= {  # type: ignore[call-overload]
            "dog.obj",
            "hand.obj",
            "head.obj",
            "jug.obj",
            "drop.obj",
        }

    @pytest.mark.usefixtures("screen")
    def test_errors_of_the_window_are_explained(
        self, learned: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def browse(*_: object, **__: object) -> None:
            raise PatternDBError("no light in the window")

        monkeypatch.setattr("viewer.browse", browse)
        assert_refused(run("browse", "--db", learned), 3, "patterndb: no light in the window")
