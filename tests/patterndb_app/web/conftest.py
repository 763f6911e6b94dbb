"""A service with its page, and a browser that shows it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts"))

import drive_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

#: Milliseconds that anything on the page may take, on a machine that has much else to do.
PATIENCE = 60_000


@pytest.fixture(scope="session")
def service() -> Iterator[str]:
    """The address of a running service."""
    pytest.importorskip("fastapi", reason="the service needs patterndb[service]")
    if not (drive_page.BUNDLE / "page.js").is_file():
        pytest.skip("the page is not built: make page")
    with drive_page.run_service() as address:
        yield address


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """The system's browser."""
    pytest.importorskip("playwright", reason="a browser is driven by playwright")
    if drive_page.find_browser() is None:
        pytest.skip(f"none of {', '.join(drive_page.BROWSERS)} is here: apt-get install chromium")
    with drive_page.open_browser() as opened:
        yield opened


#: Wide enough for all parts beside each other; what is drawn in software shall not be larger.
VIEWPORT = {"width": 1000, "height": 640}


class OpenPage:
    """Opens the page in a window of its own, and watches over what it does.

    requests: of all that was asked for, address and body. failures: what the console told.
    """

    def __init__(self, browser: Browser, service: str) -> None:
        self._browser = browser
        self._contexts: list[Any] = []
        self.service = service
        self.requests: list[tuple[str, str | None]] = []
        self.failures: list[str] = []

    def __call__(self, path: str = "/", **options: Any) -> Page:
        """Open an address of the service; options: of the window, as playwright has them."""
        # What moves is drawn often, and here by the processor.
        options = {"viewport": VIEWPORT, "reduced_motion": "reduce", **options}
        context = self._browser.new_context(accept_downloads=True, **options)
        context.set_default_timeout(PATIENCE)
        self._contexts.append(context)
        page = context.new_page()
        page.on("request", lambda r: self.requests.append((r.url, r.post_data)))
        page.on("pageerror", lambda error: self.failures.append(str(error)))
        page.on(
            "console",
            lambda said: self.failures.append(said.text) if said.type == "error" else None,
        )
        page.goto(self.service + path)
        return page

    def close(self) -> None:
        """Close all windows."""
        for context in self._contexts:
            context.close()


@pytest.fixture
def open_page(browser: Browser, service: str) -> Iterator[OpenPage]:
    """What opens the page; nothing may be told as an error, and nothing come from elsewhere."""
    opened = OpenPage(browser, service)
    yield opened
    opened.close()
    assert not opened.failures
    elsewhere = [url for url, _ in opened.requests if not url.startswith((service, "blob:"))]
    assert not elsewhere
