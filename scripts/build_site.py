"""Build the documentation site from the Markdown of this repository.

    python scripts/build_site.py              into build/site; any warning is an error
    python scripts/build_site.py --pages      only put its pages together, into build/pages

Pages are those of docs/, README, CONTRIBUTING and the like, the Python interface cut into a page
for each package with an index of names, a gallery that the program draws, and the notebooks with
what they write. Needs the extra ``dev`` (Sphinx, myst-parser, furo, nbclient).
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from build_docs_markdown import anchors
from build_site_notebooks import write_notebooks
from build_site_pictures import draw_gallery

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "build" / "pages"
SITE = ROOT / "build" / "site"

#: The page of the Python interface, which is cut.
API = "docs/api.md"

#: The pages of the site by the files that they are made of; those of docs/ keep their names.
NAMES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "SECURITY.md": "security.md",
    "examples/README.md": "examples.md",
    "benchmarks/RESULTS.md": "measurements.md",
    **{f"docs/{path.name}": path.name for path in sorted((ROOT / "docs").glob("*.md"))},
    **{
        f"docs/notes/{path.name}": f"notes-{path.name.lower()}"
        for path in sorted((ROOT / "docs" / "notes").glob("*.md"))
    },
}

#: The page that a name of the interface is on: the first that its dotted name begins with.
API_PAGES = {
    "patterndb_sketch.surfacing": "api-surfacing.md",
    "patterndb_sketch.features": "api-features.md",
    "patterndb_sketch.retopo": "api-retopo.md",
    "patterndb": "api-patterndb.md",
    "viewer": "api-viewer.md",
}

#: The pages in the order of the site, by the titles of their sections.
SECTIONS = {
    "Guides": (
        "install",
        "tutorial",
        "concepts",
        "cookbook",
        "gallery",
        "queries",
        "holes",
        "placing",
        "surfacing",
        "features",
        "retopo",
        "windows",
        "pyvista",
        "page",
        "cluster",
        "scaling",
        "faq",
    ),
    "Notebooks": ("notebooks/fills", "notebooks/learning", "notebooks/placing", "examples"),
    "Reference": ("glossary", "definitions", "cli", "service", "database", "names", "api"),
    "Python": tuple(page.removesuffix(".md") for page in sorted(set(API_PAGES.values()))),
    "Project": ("architecture", "contributing", "measurements", "security", "changelog"),
    "Notes": (
        "notes-readme",
        *(f"notes-{path.stem}" for path in sorted((ROOT / "docs" / "notes").glob("[a-z]*.md"))),
    ),
}

#: A link or, with the mark, a picture: its words and its target.
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
HEADING = re.compile(r"^(#+) (.+)$")


class BrokenLinkError(ValueError):
    """A page links to what is not there."""


def put_pages_together() -> None:
    """Write all pages, and the files that they show, into PAGES."""
    shutil.rmtree(PAGES, ignore_errors=True)
    PAGES.mkdir(parents=True)
    homes = find_api_homes((ROOT / API).read_text(encoding="utf-8"))
    for source, name in NAMES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        pages = cut_api(text) if source == API else {name: text}
        for page, content in pages.items():
            relink = make_relinker(source, page, homes)
            (PAGES / page).write_text(adapt_markdown(content, relink), encoding="utf-8")
    with (PAGES / "index.md").open("a", encoding="utf-8") as index:
        index.write(format_sections())
    (PAGES / "names.md").write_text(list_names(homes), encoding="utf-8")
    draw_gallery(PAGES)
    write_notebooks(PAGES)


def find_page(dotted: str) -> str:
    """The page that a name of the interface is on."""
    return next(page for start, page in API_PAGES.items() if (dotted + ".").startswith(start + "."))


def find_api_homes(text: str) -> dict[str, tuple[str, str]]:
    """The page and the dotted name of every anchor of the interface's page."""
    titles = [match[2] for line in unfenced(text) if (match := HEADING.match(line))]
    return {
        anchor: (find_page(title), title)
        for anchor, title in zip(anchors(titles), titles, strict=True)
        if (title + ".").startswith(tuple(f"{start}." for start in API_PAGES))
    }


def cut_api(text: str) -> dict[str, str]:
    """Cut the interface's page: its head, and a page for each package."""
    pages: dict[str, list[str]] = {"api.md": []}
    here, fenced = pages["api.md"], False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        match = None if fenced else HEADING.match(line)
        if match is not None and match[1] == "###":
            page = find_page(match[2])
            module = next(start for start, held in API_PAGES.items() if held == page)
            here = pages.setdefault(page, [f"# {module}", ""])
        here.append(
            line if match is None else line.removeprefix("#" if here is not pages["api.md"] else "")
        )
    return {page: "\n".join((*lines, "")) for page, lines in pages.items()}


def list_names(homes: dict[str, tuple[str, str]]) -> str:
    """The index of names: each by its last part, in the order of the alphabet."""
    entries = sorted(
        (title.rpartition(".")[2].lower(), title, f"{page}#{anchor}")
        for anchor, (page, title) in homes.items()
    )
    lines = ["# Python interface, by names", ""]
    letter = ""
    for word, title, target in entries:
        if word[0] != letter:
            letter = word[0]
            lines += ["", f"## {letter.upper()}", ""]
        module, _, name = title.rpartition(".")
        lines.append(f"- [`{name}`]({target}) in `{module}`")
    return "\n".join((*lines, ""))


def make_relinker(
    source: str, page: str, homes: dict[str, tuple[str, str]]
) -> Callable[[str], str | None]:
    """A function from a target in a file of the repository to one on the page of the site.

    None stands for a folder, which the site has no page of. Other files are copied.
    """

    def relink(target: str) -> str | None:
        if target.startswith(("http://", "https://", "mailto:")):
            return target
        name, _, anchor = target.partition("#")
        path = (ROOT / source).parent / name if name else ROOT / source
        if not path.exists():
            raise BrokenLinkError(f"{source}: there is no {target}")
        place = path.resolve().relative_to(ROOT).as_posix()
        if place == API and anchor in homes:
            return f"{homes[anchor][0]}#{anchor}"
        if place in NAMES:
            held = "" if NAMES[place] == page else NAMES[place]
            return f"{held}#{anchor}" if anchor else held or page
        if path.is_dir():
            return None
        copy = PAGES / place.removeprefix("docs/")
        copy.parent.mkdir(parents=True, exist_ok=True)
        # A page of code is shown, not downloaded, if it is text.
        if copy.suffix in (".sql", ".py", ".toml"):
            copy = copy.with_name(f"{copy.name}.txt")
        shutil.copy(path, copy)
        return copy.relative_to(PAGES).as_posix()

    return relink


def unfenced(text: str) -> Iterator[str]:
    """The lines of a page that stand in no fence."""
    fenced = False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        if not fenced:
            yield line


def adapt_markdown(text: str, relink: Callable[[str], str | None]) -> str:
    """A page with the site's links; fences keep the first of their words, the language."""
    lines: list[str] = []
    fenced = False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
            line = re.sub(r"^(```\w+) (run|output)$", r"\1", line)
        elif not fenced:
            line = LINK.sub(lambda found: format_link(*found.groups(), relink), line)
        lines.append(line)
    return "\n".join((*lines, ""))


def format_sections() -> str:
    """The tree of pages, for the foot of the first."""
    lines: list[str] = []
    for title, names in SECTIONS.items():
        lines += ["", "```{toctree}", ":hidden:", f":caption: {title}", "", *names, "```"]
    return "\n".join((*lines, ""))


def format_link(mark: str, words: str, target: str, relink: Callable[[str], str | None]) -> str:
    """A link or a picture of the site; of a link to a folder, which has no page, the words."""
    found = relink(target)
    return words if found is None else f"{mark}[{words}]({found})"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--pages", action="store_true", help="build no site of the pages")
    arguments = parser.parse_args()
    put_pages_together()
    if not arguments.pages:
        shutil.rmtree(SITE, ignore_errors=True)
        words = ["-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet", "--fresh-env"]
        subprocess.run(
            [sys.executable, *words, "-c", ROOT / "docs", PAGES, SITE], cwd=ROOT, check=True
        )
        print(f"built: {SITE.relative_to(ROOT)}/index.html")


if __name__ == "__main__":
    main()
