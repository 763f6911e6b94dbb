"""The documentation is written in plain English."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

#: Pages whose language is still to be mended.
PENDING = {
    # Written from docstrings and help.
    "api.md",
}

PAGES = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")]
PAGES += [page for page in sorted((ROOT / "docs").glob("*.md")) if page.name not in PENDING]

#: Phrases that have a plainer form, and that form.
PLAINER = {
    r"\b(is|are|was|were) told\b|\btells? (of|that|what|which|whether|how)\b": "report, print",
    r"(?<!there )\b(is|are) no(?! (longer|more|less|fewer|better|worse))\b": "is not a",
    r"\b(has|have) no \w+ but\b": "has only",
    r"\bwhat there is\b|\bwhatever\b": "a noun",
    r"\bshall\b": "should, must",
    r"\banew\b": "again",
    r"\bso many\b": "at most N, this many",
    r"\bbeside\b": "next to, together with",
    r"\bbut for\b|\bbut that\b": "except",
    r"\bhad of\b": "got from",
}


def find_phrases(text: str) -> list[str]:
    """Return the phrases of a page, outside its blocks of code, that have a plainer form."""
    prose = re.sub(r"^```.*?^```$|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)
    return [
        f"{match[0]!r} ({plainer}): ...{prose[max(0, match.start() - 40) : match.end() + 40]}..."
        for phrase, plainer in PLAINER.items()
        for match in re.finditer(phrase, prose, re.IGNORECASE)
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_use_plain_phrases(page: Path) -> None:
    assert find_phrases(page.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("The user is told what went wrong.", 1),
        ("This is no mesh; write it anew beside the other.", 3),
        ("It is no longer used, and has no effect.", 0),
        ("```sh\nanew\n```\n`beside`", 0),
    ],
)
def test_phrases_are_found(text: str, count: int) -> None:
    assert len(find_phrases(text)) == count


def test_pending_pages_exist() -> None:
    assert all((ROOT / "docs" / name).exists() for name in PENDING)
