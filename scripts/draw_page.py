"""Draw the pictures of docs/page.md: the page of ``patterndb serve``, as a browser shows it.

    python scripts/draw_page.py              into docs/images
    python scripts/draw_page.py --only page-hole --out FOLDER

Needs the page (``make page``), a browser of the system, and the extra ``dev``.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drive_page import ROOT, click_corners, draw_line, open_browser, run_service, wait_for_fills
from playwright.sync_api import Page

WIDE = {"width": 1280, "height": 800}
NARROW = {"width": 390, "height": 844}


def draw_fill(page: Page) -> None:
    """A polygon in the plane with a strand drawn across, the third of its fills."""
    corners = [(0.2, 0.78), (0.5, 0.88), (0.68, 0.66), (0.62, 0.3), (0.3, 0.24)]
    click_corners(page, corners)
    wait_for_fills(page)
    page.get_by_role("radio", name="Strand", exact=True).click()
    draw_line(page, [(0.26, 0.4), (0.38, 0.5), (0.5, 0.54), (0.655, 0.5)])
    wait_for_fills(page)
    page.get_by_role("radio", name="Move", exact=True).click()
    page.keyboard.press("ArrowRight")


def draw_head(page: Page) -> None:
    """A fill on a surface."""
    page.get_by_role("radio", name="Head").click()
    wait_for_fills(page)
    page.keyboard.press("ArrowRight")


def draw_compared(page: Page) -> None:
    """Three fills side by side."""
    page.get_by_role("button", name="Hexagon").click()
    wait_for_fills(page)
    for key in ("p", "ArrowRight", "p", "ArrowRight", "ArrowRight", "c"):
        page.keyboard.press(key)


def draw_patterns(page: Page) -> None:
    """The patterns of five sides, one of them large, a polychord lit up."""
    page.locator("#tab-patterns").click()
    page.locator(".pattern-card").nth(5).click()
    page.locator(".pattern-figure").wait_for()
    page.locator(".polychord-row").nth(2).hover()
    page.wait_for_load_state("networkidle")


def draw_hole(page: Page) -> None:
    """A hole on a head, filled."""
    page.locator("#tab-hole").click()
    page.locator("#hole-begin").get_by_role("button", name="Head").click()
    page.locator(".loop-row").first.click()
    wait_for_fills(page, "#hole-strip")


def draw_narrow(page: Page) -> None:
    """A pentagon on a telephone."""
    page.get_by_role("button", name="Pentagon").click()
    wait_for_fills(page)
    page.keyboard.press("ArrowRight")


PICTURES: dict[str, tuple[Callable[[Page], None], dict[str, Any]]] = {
    "page-fill": (draw_fill, {"viewport": WIDE}),
    "page-head": (draw_head, {"viewport": WIDE, "color_scheme": "dark"}),
    "page-compared": (draw_compared, {"viewport": WIDE}),
    "page-patterns": (draw_patterns, {"viewport": WIDE}),
    "page-hole": (draw_hole, {"viewport": WIDE}),
    "page-narrow": (draw_narrow, {"viewport": NARROW, "device_scale_factor": 2}),
}


def main() -> None:
    parser = argparse.ArgumentParser(description="draw the pictures of docs/page.md")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images", help="the folder")
    parser.add_argument("--only", choices=PICTURES, nargs="+", default=list(PICTURES))
    asked = parser.parse_args()
    folder: Path = asked.out
    folder.mkdir(parents=True, exist_ok=True)
    with run_service() as address, open_browser() as browser:
        for name in asked.only:
            draw, options = PICTURES[name]
            context = browser.new_context(reduced_motion="reduce", **options)
            context.set_default_timeout(120_000)
            page = context.new_page()
            page.goto(address)
            draw(page)
            # The last of what was asked for is drawn.
            page.wait_for_timeout(500)
            path = folder / f"{name}.png"
            page.screenshot(path=path)
            context.close()
            print(f"{path}: {path.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
