"""The page at /: files that the package's build makes, and nothing else of this machine."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Request
from starlette.responses import Response

from patterndb.errors import NotFoundError
from patterndb_app.service.answers import encode_answer
from patterndb_app.service.context import get_service

ROUTER = APIRouter(include_in_schema=False)

#: What the page may do: load what comes from here, and nothing from elsewhere.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; worker-src 'self' blob:; font-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)

#: Media types by suffix; files of others are not served.
MEDIA_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".webp": "image/webp",
    ".woff2": "font/woff2",
    ".obj": "model/obj",
    ".ply": "application/ply",
}

#: What / answers where the page was not built.
NO_PAGE = b"""<!doctype html>
<html lang="en"><meta charset="utf-8"><title>patterndb</title>
<h1>patterndb</h1>
<p>The service runs, but its page was not built. In a clone, <code>make page</code> builds it.</p>
<p>The interface for programs is there: <a href="/openapi.json">/openapi.json</a>,
<a href="/v1/health">/v1/health</a>.</p>
</html>
"""


@ROUTER.get("/", name="page")
async def show_page(request: Request) -> Response:
    """Show the page, or how to build it."""
    folder = get_service(request).settings.page
    index = folder / "index.html"
    body = index.read_bytes() if index.is_file() else NO_PAGE
    return encode_answer(
        request,
        body,
        media_type=MEDIA_TYPES[".html"],
        headers={"Content-Security-Policy": POLICY},
        kept=True,
    )


@ROUTER.get("/page/{name:path}", name="page_file")
async def send_file(request: Request, name: str) -> Response:
    """Send a file of the page."""
    folder = get_service(request).settings.page.resolve()
    path = find_file(folder, name)
    return encode_answer(
        request,
        path.read_bytes(),
        media_type=MEDIA_TYPES[path.suffix.lower()],
        headers={"Content-Security-Policy": POLICY},
        kept=True,
    )


def find_file(folder: Path, name: str) -> Path:
    """The file of a name in the folder; NotFoundError for what is not in it, or not of the page."""
    if "\0" not in name and "\\" not in name:
        path = (folder / name).resolve()
        # A link in the folder that leads out of it is not followed.
        if path.is_relative_to(folder) and path.suffix.lower() in MEDIA_TYPES and path.is_file():
            return path
    raise NotFoundError(f"the page has no file {name[:64]!r}")
