"""What README and docs tell their readers to do works, and writes what they show."""

from __future__ import annotations

import re
import sys
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import walkthrough  # noqa: E402
from build_docs_api import api_page  # noqa: E402
from build_docs_cli import cli_page  # noqa: E402
from build_docs_markdown import anchors  # noqa: E402
from build_docs_pictures import (  # noqa: E402
    DRAWN_APART,
    ILLUSTRATED,
    IMAGES,
    LARGEST_PICTURE,
    pictures_of_steps,
)
from build_docs_queries import queries_page  # noqa: E402
from build_docs_retopo import retopo_page  # noqa: E402

PAGES = [ROOT / "README.md"]
PAGES += [
    ROOT / "docs" / f"{name}.md"
    for name in (
        "tutorial",
        "concepts",
        "cookbook",
        "queries",
        "placing",
        "surfacing",
        "holes",
        "database",
        "retopo",
        "pyvista",
    )
]
ALL_PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "benchmarks" / "RESULTS.md"]
ALL_PAGES += sorted((ROOT / "docs").rglob("*.md"))


def shape(line: str) -> str:
    """A line without what differs from run to run: times, counts, names, widths."""
    line = re.sub(r"\b[0-9a-f]{16,}\b", "#", line)
    line = re.sub(r"\d[\d.,]*", "#", line).replace(" mirrored", "")
    return re.sub(r"#(?:,? #)+", "#", re.sub(r"\s+", " ", line)).strip()


def compare(shown: str, written: str) -> None:
    """Have both the same lines, in any order? A line … stands for lines left out."""
    wanted = sorted(shape(line) for line in shown.splitlines())
    got = sorted(shape(line) for line in written.splitlines())
    if "…" in wanted:
        left = got.copy()
        for line in wanted:
            if line == "…":
                continue
            assert line in left, f"{line!r} is not in what was written:\n{written}"
            left.remove(line)
    else:
        assert wanted == got, f"written was:\n{written}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_the_steps_of_a_page_work_and_write_what_it_shows(page: Path, tmp_path: Path) -> None:
    walkthrough.begin(tmp_path)
    if page.name == "database.md":
        made = walkthrough.Step(page.name, 0, "sh", "patterndb ingest examples --db my.db", None)
        walkthrough.perform(made, tmp_path)
    steps = walkthrough.steps(page)
    assert steps
    for step in steps:
        written = walkthrough.perform(step, tmp_path)
        if step.shown is not None:
            compare(step.shown, written)
        elif step.language == "sql":
            assert written, f"{page.name}:{step.line} finds nothing"
    left = [path.name for path in tmp_path.iterdir() if path.name not in ("examples", "docs")]
    assert list_unignored(left) == [], "git status of a clone would show this"
    for picture in pictures_of_steps(page.read_text(encoding="utf-8")):
        assert (tmp_path / picture).stat().st_size > 0, f"no step draws {picture}"


def list_unignored(names: list[str]) -> list[str]:
    """List those of the names, in a clone's folder, that its .gitignore does not name."""
    lines = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    patterns = [line.strip("/") for line in lines if line and not line.startswith("#")]
    return [name for name in names if not any(fnmatch(name, pattern) for pattern in patterns)]


def test_readme_and_tutorial_make_different_files() -> None:
    made: list[set[str]] = []
    for page in PAGES[:2]:
        text = "".join(step.text for step in walkthrough.steps(page))
        found = re.findall(r'(?:--db|--obj|(?:-o|>)) (\S+)|open\("(\S+?)", "create"', text)
        made.append({(one or other).strip("/") for one, other in found})
    assert all(len(names) >= 3 for names in made)
    assert not made[0] & made[1]


def test_the_pages_made_from_the_code_are_up_to_date() -> None:
    hint = "'make docs' writes it anew"
    assert (ROOT / "docs" / "cli.md").read_text(encoding="utf-8") == cli_page(), hint
    assert (ROOT / "docs" / "api.md").read_text(encoding="utf-8") == api_page(), hint
    guide = (ROOT / "docs" / "retopo.md").read_text(encoding="utf-8")
    assert retopo_page(guide) == guide, hint
    guide = (ROOT / "docs" / "queries.md").read_text(encoding="utf-8")
    assert queries_page(guide) == guide, hint


@pytest.mark.parametrize("page", ALL_PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith(("http://", "https://")):
            continue
        name, _, heading = target.partition("#")
        path = page if not name else page.parent / name
        assert path.exists(), f"{page.name}: there is no {target}"
        if heading and path.suffix == ".md":
            titles = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
            assert heading in anchors(titles), f"{page.name}: no heading {target}"


def test_pictures_are_small_and_all_shown() -> None:
    pictures = {
        p.relative_to(IMAGES).as_posix(): p.stat().st_size for p in IMAGES.rglob("*") if p.is_file()
    }
    assert max(pictures.values()) <= LARGEST_PICTURE
    shown = {
        name
        for page in ALL_PAGES
        for name in re.findall(r"images/([\w/-]+\.png)", page.read_text(encoding="utf-8"))
    }
    assert shown == set(pictures)
    drawn = {name for page in ILLUSTRATED for name in pictures_of_steps(page.read_text("utf-8"))}
    apart = {name for name in shown if name.startswith((*DRAWN_APART, "windows/"))}
    assert shown - apart == drawn, "a picture has no command"
    for name in DRAWN_APART:
        assert (ROOT / "scripts" / f"draw_{name.rstrip('-')}.py").exists()


def test_every_difference_from_the_paper_is_told() -> None:
    told = (ROOT / "docs" / "definitions.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w/]+\.(?:py|rs))`", told))
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []
    packages = ("patterndb", "ingest", "query", "patterndb_sketch", "viewer", "patterndb_app")
    for source in (path for name in packages for path in ROOT.glob(f"{name}/**/*.py")):
        text = re.sub(r"\s+", " ", source.read_text(encoding="utf-8"))
        if "Differs from the paper" in text:
            name = source.relative_to(ROOT).as_posix()
            assert f"`{name}`" in told, f"docs/definitions.md does not tell how {name} differs"
