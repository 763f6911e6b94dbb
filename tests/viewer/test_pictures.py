"""Pictures and contact sheets as files: the same bytes, text as text, a path per quad."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from tests.support.viewer.disks import ALL, disk, pattern, refined
from viewer import PictureFormatError, save_gallery, save_picture
from viewer.card import Card
from viewer.gallery import MOST_PER_PAGE, Grid

SVG = "{http://www.w3.org/2000/svg}"


def paths_in(root: ET.Element, name: str) -> int:
    """Number of outlines drawn in the group of this name."""
    group = root.find(f".//{SVG}g[@id='{name}']")
    assert group is not None
    return len(group.findall(f".//{SVG}path")) - len(group.findall(f".//{SVG}clipPath//{SVG}path"))


def texts_in(root: ET.Element) -> list[str]:
    return ["".join(t.itertext()) for t in root.iter(f"{SVG}text")]


@pytest.mark.parametrize("suffix", [".png", ".svg", ".SVG"])
def test_the_same_input_gives_the_same_bytes(tmp_path: Path, suffix: str) -> None:
    card = Card.of_pattern(pattern(ALL["plus"], frequency=12))
    one = save_picture(tmp_path / f"one{suffix}", card)
    other = save_picture(tmp_path / f"other{suffix}", card)
    assert one.read_bytes() == other.read_bytes()
    assert (
        save_picture(tmp_path / f"m{suffix}", card, tinted=False).read_bytes() != one.read_bytes()
    )


@pytest.mark.parametrize("name", ALL)
def test_an_svg_has_a_path_for_every_quad(tmp_path: Path, name: str) -> None:
    card = Card.of_pattern(pattern(ALL[name], frequency=1234), rank=7)
    root = ET.parse(save_picture(tmp_path / "a.svg", card)).getroot()
    assert paths_in(root, "quads") == card.disk.n_quads
    texts = texts_in(root)
    assert f"7   {card.title}" in texts
    assert any("1,234×" in t for t in texts)
    assert any("quad" in t for t in texts)


def test_a_caption_is_taken_literally(tmp_path: Path) -> None:
    card = Card.of_disk(disk(ALL["ring"]), title="$a_1$ < & >", facts="")
    root = ET.parse(save_picture(tmp_path / "a.svg", card)).getroot()
    assert "$a_1$ < & >" in texts_in(root)


def test_a_png_shows_its_colours(tmp_path: Path) -> None:
    from matplotlib.image import imread

    path = save_picture(tmp_path / "a.png", Card.of_disk(refined(ALL["pentagon"], 4)))
    image = np.asarray(imread(path))[..., :3]
    assert image.shape[0] > 500 and image.shape[1] > 500
    assert (image[0] == 1.0).all() and (image[:, 0] == 1.0).all()
    assert len(np.unique((image.reshape(-1, 3) * 255).astype(int), axis=0)) > 50


@pytest.mark.parametrize("name", ["a.pdf", "a", "a.svg.gz"])
def test_an_unknown_suffix_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(PictureFormatError, match=r"\.png or \.svg"):
        save_picture(tmp_path / name, Card.of_disk(disk(ALL["L"])))
    with pytest.raises(PictureFormatError):
        save_gallery(tmp_path / name, [])
    assert list(tmp_path.iterdir()) == []


def test_a_sheet_of_one_page(tmp_path: Path) -> None:
    cards = [Card.of_pattern(pattern(q, 5), i + 1) for i, q in enumerate(ALL.values())]
    paths = save_gallery(tmp_path / "sheet.svg", cards, title="Some")
    assert paths == [tmp_path / "sheet.svg"]
    root = ET.parse(paths[0]).getroot()
    for i, card in enumerate(cards):
        assert paths_in(root, f"quads-{i + 1}") == card.disk.n_quads
    texts = texts_in(root)
    assert "Some" in texts and texts.count("convex corner") == 1
    assert [t for t in texts if t == "3"] == ["3"]
    assert all(card.title in texts for card in cards)


def test_a_sheet_of_several_pages(tmp_path: Path) -> None:
    cards = [Card.of_disk(disk(ALL["L"]), f"disk {i}") for i in range(7)]
    paths = save_gallery(tmp_path / "sheet.png", cards, per_page=3)
    assert [p.name for p in paths] == ["sheet-1.png", "sheet-2.png", "sheet-3.png"]
    assert sorted(tmp_path.iterdir()) == paths
    svg = save_gallery(tmp_path / "sheet.svg", cards, per_page=3)
    texts = [texts_in(ET.parse(p).getroot()) for p in svg]
    assert [t.count("page 3 of 3") for t in texts] == [0, 0, 1]
    assert [[f"disk {i}" in t for i in range(7)].count(True) for t in texts] == [3, 3, 1]


def test_no_cards_make_no_file(tmp_path: Path) -> None:
    assert save_gallery(tmp_path / "a.png", []) == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("per_page", [0, MOST_PER_PAGE + 1])
def test_a_page_holds_so_many(tmp_path: Path, per_page: int) -> None:
    with pytest.raises(ValueError, match="a page holds"):
        save_gallery(tmp_path / "a.png", [], per_page=per_page)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 8, 9, 20, 21, 42, 60, 80, 81, 200])
def test_cells_lie_on_the_page_and_apart(n: int) -> None:
    grid = Grid.of(n)
    assert grid.columns * grid.rows >= n > grid.columns * (grid.rows - 1)
    centres = np.array([grid.centre(i) for i in range(n)])
    half = grid.cell / 2.0
    assert (centres - half > 0.0).all()
    assert (centres + half < [grid.width, grid.height]).all()
    gaps = np.abs(centres[:, None] - centres[None]).max(axis=2) + np.eye(n) * 1e9
    assert gaps.min() >= grid.cell
