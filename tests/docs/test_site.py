"""The site's pages: every one in the tree, links kept, the interface cut without a loss."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import build_site  # noqa: E402
from build_docs_markdown import anchors  # noqa: E402


@pytest.fixture
def pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """All pages but for what the program draws and the notebooks write, which takes its time."""
    monkeypatch.setattr(build_site, "PAGES", tmp_path / "pages")
    monkeypatch.setattr(build_site, "draw_gallery", lambda pages: None)
    monkeypatch.setattr(build_site, "write_notebooks", lambda pages: None)
    build_site.put_pages_together()
    return tmp_path / "pages"


def test_every_page_is_in_the_tree_once(pages: Path) -> None:
    listed = [name for names in build_site.SECTIONS.values() for name in names]
    assert len(listed) == len(set(listed))
    made = {path.stem for path in pages.glob("*.md")}
    assert made - {"index"} == {name for name in listed if "/" not in name} - {"gallery"}
    notebooks = {path.stem for path in (ROOT / "examples" / "notebooks").glob("*.ipynb")}
    assert {name.partition("/")[2] for name in listed if "/" in name} == notebooks
    assert all((pages / "index.md").read_text().count(f"\n{name}\n") == 1 for name in listed)


def test_every_link_leads_to_a_page_or_a_file(pages: Path) -> None:
    count = 0
    for page in pages.glob("*.md"):
        for line in build_site.unfenced(page.read_text(encoding="utf-8")):
            for _, _, target in build_site.LINK.findall(line):
                name, _, anchor = target.partition("#")
                if target.startswith("http"):
                    continue
                count += 1
                other = pages / name if name else page
                assert other.is_file(), f"{page.name}: {target}"
                if anchor:
                    titles = re.findall(r"^#+ (.+)$", other.read_text(), re.MULTILINE)
                    assert anchor in anchors(titles), f"{page.name}: {target}"
    assert count > 300


def test_the_interface_is_cut_without_a_loss(pages: Path) -> None:
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    titles = re.findall(r"^### (.+)$", text, re.MULTILINE)
    found = [
        title
        for page in set(build_site.API_PAGES.values())
        for title in re.findall(r"^## (.+)$", (pages / page).read_text(), re.MULTILINE)
    ]
    assert sorted(found) == sorted(titles)
    names = (pages / "names.md").read_text()
    assert all(f"`{title.rpartition('.')[2]}`" in names for title in titles)


def test_a_link_to_what_is_not_there_is_told() -> None:
    relink = build_site.make_relinker("README.md", "index.md", {})
    assert relink("docs/queries.md#the-explorer") == "queries.md#the-explorer"
    assert relink("https://example.org") == "https://example.org"
    assert relink("examples/notebooks/") is None
    with pytest.raises(build_site.BrokenLinkError, match=r"README.md: there is no docs/gone.md"):
        relink("docs/gone.md")
