"""The tabs Patterns and Hole in a browser, and what all tabs share: keys, colours, widths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from drive_page import find_place, wait_for_fills

import patterndb
from query.holes.caps import RimPlane
from query.holes.options import SHAPES

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.patterndb_app.web.conftest import OpenPage

pytestmark = pytest.mark.browser

HEAD = Path(__file__).resolve().parents[3] / "docs" / "meshes" / "head.obj"


def click_rim(page: Page) -> None:
    """Move over the canvas until a rim is near, and click it."""
    canvas = page.locator("#hole-canvas")
    for y in np.linspace(0.35, 0.6, 12):
        for x in np.linspace(0.3, 0.6, 16):
            page.mouse.move(*find_place(canvas, float(x), float(y)))
            if "near" in (canvas.get_attribute("class") or ""):
                page.mouse.down()
                page.mouse.up()
                return
    raise AssertionError("no rim was found on the canvas")


def test_a_hole_is_clicked_filled_paged_and_downloaded(open_page: OpenPage, tmp_path: Path) -> None:
    page = open_page("/#hole")
    page.locator("#hole-file").set_input_files(HEAD)
    page.locator(".loop-row").first.wait_for()
    old = patterndb.read(HEAD)
    assert page.locator(".loop-row").count() == len(old.holes())

    click_rim(page)
    wait_for_fills(page, "#hole-strip")
    page.get_by_role("heading", name="Fill 1 of").wait_for()
    page.keyboard.press("ArrowRight")
    page.get_by_role("heading", name="Fill 2 of").wait_for()
    with page.expect_download() as started:
        page.get_by_role("button", name="Download the mesh").click()
    started.value.save_as(tmp_path / "filled.obj")
    new = patterndb.read(tmp_path / "filled.obj")
    added = np.arange(new.n_faces) >= old.n_faces
    assert added.any() and set(new.arities()[added].tolist()) == {4}
    assert new.faces()[: old.n_faces] == old.faces()
    np.testing.assert_array_equal(new.points[: len(old.points)], old.points)
    # One border loop less, and all faces run the same way: else no holes could be told.
    assert len(new.holes()) == len(old.holes()) - 1


def test_the_shape_of_a_fill_is_chosen(open_page: OpenPage, tmp_path: Path) -> None:
    page = open_page("/#hole")
    page.locator("#hole-file").set_input_files(HEAD)
    page.locator(".loop-row").first.wait_for()
    select = page.locator("#hole-shape")
    select.wait_for()
    assert select.locator("option").all_text_contents() == list(SHAPES)
    select.select_option("flat")
    assert page.locator("#hole-tension").is_disabled()
    page.locator(".loop-row").first.click()
    wait_for_fills(page, "#hole-strip")
    page.locator("#hole-card").get_by_text("flat").wait_for()
    with page.expect_download() as started:
        page.get_by_role("button", name="Download the mesh").click()
    started.value.save_as(tmp_path / "filled.obj")
    old, new = patterndb.read(HEAD), patterndb.read(tmp_path / "filled.obj")
    plane = RimPlane.of(old.holes()[0].points)
    added = new.points[len(old.points) :]
    assert len(added)
    np.testing.assert_allclose(plane.project(added), added, atol=1e-9)

    select.select_option("smooth")
    wait_for_fills(page, "#hole-strip")
    page.locator("#hole-tension").fill("1")
    page.locator("#hole-tension").press("Enter")
    wait_for_fills(page, "#hole-strip")
    page.get_by_role("heading", name="Fill 1 of").wait_for()


def test_patterns_are_those_of_the_database(open_page: OpenPage) -> None:
    page = open_page("/#patterns?sides=5&max_irregular=2&convex=true")
    page.locator(".pattern-card").first.wait_for()
    with patterndb.open() as db:
        patterns = db.pattern_class(5)
        fits = (patterns.n_irregular <= 2) & (patterns.n_reflex == 0)
        rows = np.flatnonzero(fits)
        best = rows[np.argmax(patterns.frequency[rows])]
        first = page.locator(".pattern-card").first
        assert f"{int(patterns.frequency[best]):,}×" in first.inner_text()
        name = first.get_attribute("data-id")
        assert name is not None
        seen = {one.mesh: one.patches for one in db.occurrences(db.pattern(name))}
        licences = {mesh.name: mesh.provenance.licence for mesh in db.meshes()}
    # The picture is there, not only its address.
    assert first.locator("img").evaluate("async i => { await i.decode(); return i.naturalWidth }")

    first.click()
    page.locator(".pattern-figure").wait_for()
    rows_shown = page.locator(".detail tbody tr")
    assert rows_shown.count() == len(seen)
    mesh, licence, count = rows_shown.first.locator("td").all_inner_texts()
    assert (licence, count) == (licences[mesh], f"{seen[mesh]:,}")
    page.locator(".polychord-row").nth(1).focus()
    assert page.locator(".pattern-figure.lit .polychord.on").count() == 1

    page.get_by_label("Max. irregular").fill("0")
    page.keyboard.press("Enter")
    page.locator("#pattern-status", has_text="no such pattern").wait_for()
    assert "max_irregular=0" in page.url and name in page.url


def test_all_can_be_done_by_keys(open_page: OpenPage) -> None:
    page = open_page()
    page.locator("#tab-fill").focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("#tab-patterns").get_attribute("aria-selected") == "true"
    page.keyboard.press("ArrowLeft")
    page.get_by_role("button", name="Pentagon").focus()
    page.keyboard.press("Enter")
    wait_for_fills(page)
    strip = page.get_by_role("listbox", name="fills, best first")
    strip.focus()
    page.keyboard.press("End")
    chosen = strip.get_attribute("aria-activedescendant")
    assert page.locator(f"#{chosen}").get_attribute("aria-selected") == "true"
    # What can be pressed or typed into has a name.
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, [role]")]
        .filter(e => e.checkVisibility() && e.tabIndex >= 0)
        .filter(e => !(e.getAttribute("aria-label") || e.getAttribute("aria-labelledby")
            || e.textContent.trim() || e.labels?.length))
        .map(e => e.outerHTML)"""
    )
    assert unnamed == []


def test_colours_follow_the_system_until_one_chooses(open_page: OpenPage) -> None:
    page = open_page(color_scheme="dark")
    root = page.locator("html")
    assert root.get_attribute("data-theme") == "dark"
    page.get_by_role("button", name="light colours").click()
    assert root.get_attribute("data-theme") == "light"
    page.reload()
    assert root.get_attribute("data-theme") == "light"
    page.get_by_role("button", name="dark colours").click()
    page.emulate_media(color_scheme="light")
    page.locator("html[data-theme=light]").wait_for()


def test_a_narrow_window_shows_all_without_scrolling_sideways(open_page: OpenPage) -> None:
    page = open_page(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page.get_by_role("button", name="Quad").tap()
    wait_for_fills(page)
    for tab in ("fill", "patterns", "hole"):
        page.locator(f"#tab-{tab}").tap()
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
