"""Markdown: headings, fences, what stands between comments, and docstrings."""

from __future__ import annotations

import inspect
import re
from collections import Counter
from collections.abc import Iterable, Iterator

NOTICE = "<!-- Written by scripts/build_docs.py; change the code it describes instead. -->\n"


def anchors(titles: Iterable[str]) -> list[str]:
    """The anchors that Markdown renderers give headings; one that is taken gets a number."""
    found: list[str] = []
    seen: Counter[str] = Counter()
    for title in titles:
        plain = re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
        found.append(f"{plain}-{seen[plain]}" if seen[plain] else plain)
        seen[plain] += 1
    return found


def between(text: str, name: str, lines: Iterable[str]) -> str:
    """A page with these lines between the comments that begin and end what ``name`` is."""
    begin = re.search(rf"^<!-- {name}: .*-->\n", text, re.MULTILINE)
    end = text.find(f"<!-- End of {name.lower()}. -->")
    if begin is None or end < begin.end():
        raise ValueError(f"the page has no place for {name.lower()}")
    return text[: begin.end()] + "\n" + "\n".join(lines) + "\n\n" + text[end:]


def fence(language: str, text: str) -> list[str]:
    return [f"```{language}", text.strip("\n"), "```", ""]


def inline(text: str) -> str:
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text)
    return text.replace("``", "`")


def prose(text: str | None, names: Iterable[str] = ()) -> list[str]:
    """A docstring as Markdown.

    names: parameters or fields; "name: what it is" becomes an item of a list.
    """
    words = "|".join(sorted(map(re.escape, names), key=len, reverse=True)) or "(?!)"
    item = re.compile(rf"(?:^|(?<=[.;)] ))((?:{words})(?:, (?:{words}))*): +")
    lines: list[str] = []
    for paragraph in inspect.cleandoc(text or "").split("\n\n"):
        if paragraph.startswith(">>>"):
            lines += fence("python", paragraph)
            continue
        flat = inline(re.sub(r"\s*\n\s*", " ", paragraph))
        before, *items = item.split(flat)
        if before.strip():
            lines += [before.strip(), ""]
        after = ""
        for found, said in zip(items[::2], items[1::2], strict=True):
            # A sentence on what is returned or raised is no part of the last item.
            said, *rest = re.split(r" (?=Returns |Raises )", said, maxsplit=1)
            after += "".join(rest)
            head = ", ".join(f"`{name}`" for name in found.split(", "))
            lines.append(f"- {head}: {said.strip()}")
        lines += [""] * bool(items) + [after.strip(), ""] * bool(after)
    return lines if text else []


def tidy(lines: list[str]) -> Iterator[str]:
    """Without the empty lines that follow one another."""
    for i, line in enumerate(lines):
        if line or (i and lines[i - 1]):
            yield line
