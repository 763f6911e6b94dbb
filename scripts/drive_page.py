"""Drive the page of ``patterndb serve`` in a browser: for its tests, its pictures, its figures.

The browser is Chromium or Chrome of the system (Debian: ``apt-get install chromium``), without a
window; it draws in software, so that it needs no graphics card and draws alike everywhere.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

ROOT = Path(__file__).resolve().parents[1]
BUNDLE = ROOT / "patterndb_app" / "web" / "bundle"

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

#: WebGL in software, and no sandbox, which needs rights that containers do not have.
OPTIONS = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-sandbox",
)

#: Seconds that the service may take to come up: it loads the database first.
PATIENCE = 120.0


def find_browser() -> str | None:
    """Find the program of a browser; None where there is none."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


@contextmanager
def run_service(*options: str) -> Iterator[str]:
    """Run ``patterndb serve`` on a free port, and give its address; it ends with the context."""
    command = [sys.executable, "-m", "patterndb", "serve", "--port", "0", *options]
    process = subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    told: list[str] = []
    heard = threading.Event()

    def listen() -> None:
        assert process.stdout is not None
        for line in process.stdout:
            found = re.search(r"http://[\w.:\[\]]+:\d+", line)
            if found and not heard.is_set():
                told.append(found[0])
                heard.set()
        heard.set()

    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    try:
        if not heard.wait(PATIENCE) or not told:
            raise RuntimeError("patterndb serve did not say its address")
        yield told[0]
    finally:
        process.terminate()
        process.wait(30)


@contextmanager
def open_browser() -> Iterator[Browser]:
    """Open the system's browser without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_browser(), args=list(OPTIONS))
        yield browser
        browser.close()


def click_corners(page: Page, corners: list[tuple[float, float]]) -> None:
    """Click corners on the canvas, in shares of its width and height, and close the polygon.

    Enter closes it where the view came to rest late, and the first corner is not where it was
    clicked; it does nothing to a polygon that is closed.
    """
    for x, y in [*corners, corners[0]]:
        page.mouse.click(*find_place(page.locator("#fill-canvas"), x, y))
    page.keyboard.press("Enter")


def draw_line(page: Page, points: list[tuple[float, float]]) -> None:
    """Draw a line on the canvas with the pointer held down, in shares of its width and height."""
    canvas = page.locator("#fill-canvas")
    page.mouse.move(*find_place(canvas, *points[0]))
    page.mouse.down()
    for x, y in points[1:]:
        page.mouse.move(*find_place(canvas, x, y), steps=6)
    page.mouse.up()


def find_place(canvas: Locator, x: float, y: float) -> tuple[float, float]:
    """Where on the page a share of the canvas's width and height is."""
    box = canvas.bounding_box()
    assert box is not None
    return box["x"] + x * box["width"], box["y"] + y * box["height"]


def wait_for_fills(page: Page, strip: str = "#fill-strip") -> None:
    """Wait until a list has come whole: its status tells how long it took."""
    page.locator(f"{strip} .option").first.wait_for()
    page.locator(f"{strip} .status", has_text=" ms").wait_for()
