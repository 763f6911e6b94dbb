"""The gallery of the site: pictures that the program draws while the site is built."""

from __future__ import annotations

import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class GalleryPicture:
    """A picture: its title, what to see in it, and the command that draws it, but for the name."""

    title: str
    text: str
    command: str
    option: str = "-o"
    suffix: str = ".svg"

    @property
    def name(self) -> str:
        """The name of its file."""
        return self.title.lower().replace(" ", "-") + self.suffix


GALLERY = (
    GalleryPicture(
        "Patterns of three sides",
        "What artists put into triangles: a vertex of three quads in the middle, or pairs of "
        "irregular vertices that turn the flow.",
        "gallery --class 3 --convex --limit 12",
    ),
    GalleryPicture(
        "Patterns of four sides",
        "The first is the regular grid. The others let sides that face each other differ.",
        "gallery --class 4 --convex --limit 12",
    ),
    GalleryPicture(
        "Patterns of five sides",
        "A pentagon asks for a vertex of five quads.",
        "gallery --class 5 --convex --limit 12",
    ),
    GalleryPicture(
        "Patterns of six sides",
        "",
        "gallery --class 6 --convex --limit 12",
    ),
    GalleryPicture(
        "Fills of a pentagon",
        "One boundary, eight patterns, the best fill of each.",
        "query --sides 5,4,6,3,4 --limit 8 --per-pattern 1",
        "--image",
    ),
    GalleryPicture(
        "Fills with a stroke",
        "A strand runs from edge 2 of side 0 to edge 3 of side 2.",
        "query --sides 5,4,6,5 --flow 0:2-2:3 --limit 8 --per-pattern 1",
        "--image",
    ),
    GalleryPicture(
        "Fills around a reflex corner",
        "The fourth corner is reflex: three quads meet there.",
        "query --sides 6,2,4,4,2,4 --corners c,c,c,r,c,c --limit 8 --per-pattern 1",
        "--image",
    ),
    GalleryPicture(
        "Fills of a disc",
        "One closed side of twelve edges, without a corner.",
        "query --sides 12 --closed --limit 8 --per-pattern 1",
        "--image",
    ),
    GalleryPicture(
        "A surfaced teacup",
        "Curves drawn in space, and a patch for each of their cycles; the rim stays open.",
        "surface examples/networks/teacup.json --ban rim",
        "--picture",
        ".png",
    ),
)


def draw_gallery(pages: Path) -> None:
    """Draw every picture into a folder of the pages, and write the page that shows them."""
    folder = pages / "images" / "gallery"
    folder.mkdir(parents=True)
    lines = [
        "# Gallery",
        "",
        "The program drew these when this site was built, by the command under each. Bands of one "
        "colour are polychords, strips of quads; triangles, pentagons and hexagons mark the "
        "vertices where three, five or six quads meet.",
        "",
    ]
    for picture in GALLERY:
        words = [*shlex.split(picture.command), picture.option, str(folder / picture.name)]
        subprocess.run(
            [sys.executable, "-m", "patterndb", *words],
            cwd=ROOT,
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        shown = f"patterndb {picture.command} {picture.option} {picture.name}"
        lines += [f"## {picture.title}", ""]
        lines += [picture.text, ""] if picture.text else []
        lines += [f"![{picture.title}](images/gallery/{picture.name})", ""]
        lines += ["```sh", shown, "```", ""]
    (pages / "gallery.md").write_text("\n".join(lines), encoding="utf-8")
