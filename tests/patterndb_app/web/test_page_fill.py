"""The tab Fill in a browser: drawing, counts, strands, the list, what is downloaded."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from drive_page import click_corners, draw_line, wait_for_fills

import patterndb
from query.boundaryfile import parse_boundary

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from query import Fill
    from tests.patterndb_app.web.conftest import OpenPage

pytestmark = pytest.mark.browser

#: A pentagon in shares of the canvas, away from tools and card.
PENTAGON = [(0.3, 0.85), (0.62, 0.86), (0.68, 0.45), (0.45, 0.25), (0.22, 0.5)]


def last_question(open_page: OpenPage) -> dict[str, Any]:
    """The body that the page asked last."""
    bodies = [body for url, body in open_page.requests if url.endswith("/v1/fills")]
    return json.loads(bodies[-1] or "")


def ask_library(question: dict[str, Any]) -> list[Fill]:
    """The fills that the library has for a question of the page."""
    own = {"limit", "order", "per_pattern", "strict", "max_irregular"}
    options = {name: value for name, value in question.items() if name in own}
    asked = {k: v for k, v in question.items() if k not in own and k != "surface"}
    boundary, strokes = parse_boundary(json.dumps(asked))
    with patterndb.open() as db:
        return list(db.fills(boundary, strokes=strokes, **options))


def read_card(page: Page) -> dict[str, str]:
    """What the card tells of the fill that is shown."""
    names = page.locator("#fill-card dt").all_inner_texts()
    values = page.locator("#fill-card dd").all_inner_texts()
    return dict(zip(names, values, strict=True))


def download(page: Page, folder: Path) -> patterndb.PolygonMesh:
    """Download the fill that is shown, and read it."""
    with page.expect_download() as started:
        page.get_by_role("button", name="Download OBJ").click()
    path = folder / started.value.suggested_filename
    started.value.save_as(path)
    return patterndb.read(path)


def count_edges(page: Page) -> list[int]:
    return [int(field.input_value()) for field in page.locator(".side-row .count").all()]


def test_draw_count_stream_page_through_download(open_page: OpenPage, tmp_path: Path) -> None:
    page = open_page()
    with page.expect_response("**/v1/fills") as answered:
        click_corners(page, PENTAGON)
    assert answered.value.headers["content-type"] == "application/x-ndjson"
    wait_for_fills(page)
    assert sum(count_edges(page)) % 2 == 0

    # The list, read card by card with the arrow key, is that of the library.
    expected = ask_library(last_question(open_page))
    assert page.locator("#fill-strip .option").count() == len(expected)
    for rank, fill in enumerate(expected, 1):
        page.get_by_role("heading", name=f"Fill {rank} of").wait_for()
        told = read_card(page)
        assert (told["pattern"], told["quads"]) == (fill.pattern.name, str(fill.n_quads))
        if rank < 6:
            page.keyboard.press("ArrowRight")
        else:
            break
    option = page.locator("#fill-strip .option").nth(5)
    assert option.get_attribute("aria-selected") == "true"

    mesh = download(page, tmp_path)
    assert set(mesh.arities().tolist()) == {4}
    assert mesh.n_faces == expected[5].n_quads
    np.testing.assert_array_equal(np.asarray(mesh.faces()), expected[5].quads)
    placed = expected[5].place(parse_question(last_question(open_page)))
    np.testing.assert_allclose(mesh.points, placed.vertices, atol=1e-9)


def parse_question(question: dict[str, Any]) -> np.ndarray[Any, Any]:
    """(P, 3) the boundary's vertices of a question."""
    asked = {name: question[name] for name in ("sides", "lengths", "corners")}
    points = parse_boundary(json.dumps(asked))[0].points
    assert points is not None
    return points


def test_counts_by_keys_wheel_and_offers(open_page: OpenPage) -> None:
    page = open_page()
    page.get_by_role("button", name="Pentagon").click()
    wait_for_fills(page)
    before = count_edges(page)
    first = page.get_by_role("spinbutton", name="edges of side 1", exact=True)
    first.hover()
    page.mouse.wheel(0, -60)
    page.locator(".offer").first.wait_for()
    assert count_edges(page) == [before[0] + 1, *before[1:]]
    assert page.locator("#fill-strip .option").count() == 0
    assert "odd" in page.locator("#fill-status").inner_text()
    page.locator(".offer").first.click()
    wait_for_fills(page)
    counts = count_edges(page)
    assert sum(counts) % 2 == 0 and sum(abs(np.subtract(counts, before))) in (0, 2)

    page.get_by_role("spinbutton", name="edges of side 2, in the list").fill("7")
    field = page.get_by_role("spinbutton", name="edges of side 3, in the list")
    field.fill("x")
    assert field.get_attribute("aria-invalid") == "true"
    field.fill("5")
    page.get_by_role("spinbutton", name="edges of side 1", exact=True).focus()
    page.keyboard.press("ArrowDown")
    assert count_edges(page)[1:3] == [7, 5]


def test_lengths_are_read_in_english_and_german(open_page: OpenPage) -> None:
    page = open_page()
    page.get_by_role("button", name="Quad").click()
    wait_for_fills(page)
    told: list[list[int]] = []
    for text in ("0.25", "0.7", "0,25"):
        page.get_by_label("Edge length").fill(text)
        page.keyboard.press("Enter")
        wait_for_fills(page)
        told.append(count_edges(page))
    assert told[0] == told[2] != told[1]


def test_strands_and_loops_are_asked_for(open_page: OpenPage, tmp_path: Path) -> None:
    page = open_page()
    click_corners(page, PENTAGON)
    wait_for_fills(page)
    page.get_by_role("radio", name="Strand", exact=True).click()
    with page.expect_response("**/v1/fills"):
        draw_line(page, [(0.46, 0.85), (0.45, 0.6), (0.33, 0.38)])
    wait_for_fills(page)
    asked = last_question(open_page)
    assert [stroke["loop"] for stroke in asked["strokes"]] == [False]
    expected = ask_library(asked)
    assert expected
    assert read_card(page)["pattern"] == expected[0].pattern.name
    assert "off strokes" in read_card(page)

    page.get_by_role("button", name="remove strand 1").click()
    wait_for_fills(page)
    assert "strokes" not in last_question(open_page)
    page.get_by_role("radio", name="Loop", exact=True).click()
    with page.expect_response("**/v1/fills"):
        draw_line(page, [(0.38, 0.5), (0.38, 0.7), (0.55, 0.7), (0.55, 0.5), (0.4, 0.48)])
    wait_for_fills(page)
    assert [stroke["loop"] for stroke in last_question(open_page)["strokes"]] == [True]
    assert set(download(page, tmp_path).arities().tolist()) == {4}


def test_a_link_asks_the_same_again(open_page: OpenPage) -> None:
    page = open_page()
    page.get_by_role("button", name="L with").click()
    wait_for_fills(page)
    page.get_by_label("Order").select_option("regular")
    page.get_by_label("Max. irregular").fill("4")
    page.keyboard.press("Enter")
    wait_for_fills(page)
    page.locator("#fill-strip .option").nth(2).click()
    asked, card, address = last_question(open_page), read_card(page), page.url
    again = open_page("/" + address.partition("/#")[2].join(["#", ""]))
    wait_for_fills(again)
    again.get_by_role("heading", name="Fill 3 of").wait_for()
    assert last_question(open_page) == asked
    assert read_card(again) == card
    assert asked["corners"].count("reflex") == 1 and asked["order"] == "regular"


def test_fills_are_pinned_and_compared(open_page: OpenPage) -> None:
    page = open_page()
    page.get_by_role("button", name="Hexagon").click()
    wait_for_fills(page)
    for key in ("p", "ArrowRight", "p", "ArrowRight", "c"):
        page.keyboard.press(key)
    assert page.locator(".compared").count() == 3
    assert page.locator("#fill-strip .pinned").count() == 2
    page.locator("#fill-overlay").wait_for(state="hidden")
    page.keyboard.press("Escape")
    assert page.locator(".compared").count() == 0


def test_fills_lie_on_surfaces(open_page: OpenPage, tmp_path: Path) -> None:
    page = open_page()
    page.get_by_role("radio", name="Ball").click()
    wait_for_fills(page)
    mesh = download(page, tmp_path)
    assert set(mesh.arities().tolist()) == {4}
    # The ball's quads are flat: their middles lie a little within.
    assert np.allclose(np.linalg.norm(mesh.points, axis=1), 1.0, atol=4e-3)

    # A surface from a file, and corners clicked on it.
    points = "".join(f"v {x} {y} {0.2 * x * y}\n" for y in range(-2, 3) for x in range(-2, 3))
    faces = "".join(
        f"f {r + c} {r + c + 1} {r + c + 6} {r + c + 5}\n" for r in (1, 6, 11, 16) for c in range(4)
    )
    (tmp_path / "sheet.obj").write_text(points + faces)
    page.locator("#surface-file").set_input_files(tmp_path / "sheet.obj")
    page.locator("#fill-status", has_text="click corners").wait_for()
    click_corners(page, [(0.45, 0.6), (0.56, 0.58), (0.55, 0.42), (0.45, 0.44)])
    wait_for_fills(page)
    x, y, z = download(page, tmp_path).points.T
    # Between its vertices the sheet is of triangles.
    np.testing.assert_allclose(z, 0.2 * x * y, atol=0.06)


def test_corners_move_by_keys_and_change_their_kind(open_page: OpenPage) -> None:
    page = open_page()
    page.get_by_role("button", name="Quad").click()
    wait_for_fills(page)
    before = last_question(open_page)
    handle = page.get_by_role("button", name="corner 2, convex")
    handle.focus()
    with page.expect_response("**/v1/fills"):
        page.keyboard.press("Shift+ArrowRight")
    moved = last_question(open_page)
    assert moved["sides"][1][0][0] > before["sides"][1][0][0]
    assert moved["sides"][0][0] == before["sides"][0][0]
    with page.expect_response("**/v1/fills"):
        page.keyboard.press("Enter")
    assert last_question(open_page)["corners"] == ["convex", "reflex", "convex", "convex"]


def test_what_the_service_refuses_is_told(open_page: OpenPage) -> None:
    page = open_page()
    page.get_by_role("button", name="Triangle").click()
    wait_for_fills(page)
    page.get_by_label("Max. irregular").fill("0")
    page.keyboard.press("Enter")
    page.locator("#fill-status.error").wait_for()
    assert page.locator("#fill-strip .option").count() == 0
    assert page.locator("#fill-card").is_hidden()
