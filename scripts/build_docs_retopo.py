"""The parts of the guide to retopology that the code tells: its tools and keys."""

from __future__ import annotations

import re

from build_docs_markdown import between


def retopo_page(text: str) -> str:
    """The guide with the tools and keys that there are, between its comments."""
    from patterndb_sketch.retopo.table import describe_tools
    from viewer.commands import QT_NAMES
    from viewer.retopo.keys import COMMANDS
    from viewer.retopo.modes import list_modes

    tools = ["| tool | argument | |", "|---|---|---|"]
    for name, word, said in describe_tools():
        tools.append(f"| | `{word}` | {said} |" if word else f"| `{name}` | | {said} |")
    keys = ["| key | tool | |", "|---|---|---|"]
    keys += [f"| `{m.key}` | {m.title} | {spaced(m.hint)} |" for m in list_modes() if m.key]
    keys += ["", "| key | command | |", "|---|---|---|"]
    for one in COMMANDS:
        if one.keys and not one.name.startswith("tool-"):
            named = " ".join(f"`{QT_NAMES.get(key, key)}`" for key in one.keys)
            keys.append(f"| {named} | {one.title} | {spaced(one.tip)} |")
    return between(between(text, "Tools", tools), "Keys", keys)


def spaced(text: str) -> str:
    """What the window parts by wide spaces, parted by semicolons."""
    return re.sub(r" {3,}", "; ", text)
