"""The pictures and the output that pages show, from doing what the pages say."""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

import walkthrough

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
IMAGES = DOCS / "images"

#: The pages whose steps draw pictures; they show them as images/NAME.
ILLUSTRATED = (
    ROOT / "README.md",
    DOCS / "concepts.md",
    DOCS / "tutorial.md",
    DOCS / "queries.md",
    DOCS / "surfacing.md",
    DOCS / "features.md",
    DOCS / "retopo.md",
    DOCS / "pyvista.md",
)

#: How the names of pictures begin that scripts/draw_NAME.py draw, and no step does.
DRAWN_APART = (
    "bodies",
    "explorer-",
    "placing-",
    "surfacing-",
    "features-",
    "shapes-",
    "retopo-",
    "holes-",
    "page-",
)

#: Bytes that a picture of the documentation may have.
LARGEST_PICTURE = 300_000


def walk(page: Path) -> None:
    """Do what a page says; keep the pictures it shows, and what its steps write."""
    from PIL import Image

    IMAGES.mkdir(exist_ok=True)
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        walkthrough.begin(folder)
        for step in walkthrough.steps(page):
            print(step.text, end="", flush=True)
            written = walkthrough.perform(step, folder)
            if step.shown is not None:
                said = f"{step.text}```\n\n```text output\n"
                old = said + step.shown
                assert text.count(old) == 1, f"{page.name}:{step.line} stands there twice"
                text = text.replace(old, said + shortened(written, step.shown))
        for picture in pictures_of_steps(text):
            Image.open(folder / picture).convert("RGB").save(IMAGES / picture, optimize=True)
            size = (IMAGES / picture).stat().st_size
            print(f"{picture}: {size:,} bytes")
            if size > LARGEST_PICTURE:
                sys.exit(f"{picture} has over {LARGEST_PICTURE:,} bytes; draw less in it")
    page.write_text(text, encoding="utf-8")


def pictures_of_steps(text: str) -> list[str]:
    """Return the names of the pictures that a page shows and its steps draw."""
    steps = "".join(body for _, kind, body in walkthrough.BLOCK.findall(text) if kind == "run")
    drawn = set(re.findall(r"[\w-]+\.png", steps))
    shown = re.findall(r"images/([\w-]+\.png)", text)
    return [name for name in shown if not name.startswith(DRAWN_APART) and name in drawn]


def shortened(written: str, shown: str) -> str:
    """What was written, with as many lines before and after a line … as were shown."""
    lines, old = written.splitlines(), shown.splitlines()
    first = [line for line in old[:1] if line == "…"]
    rest = old[len(first) :]
    if "…" in rest:
        cut = rest.index("…")
        after = len(rest) - cut - 1
        lines = [*lines[:cut], "…", *lines[len(lines) - after :]]
    elif first:
        lines = lines[len(lines) - len(rest) :]
    return "".join(f"{line}\n" for line in [*first, *lines])
