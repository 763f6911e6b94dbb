"""The parts of the guide to retopology that the code tells: its tools and keys."""

from __future__ import annotations

import re

from build_docs_markdown import between


def retopo_page(text: str) -> str:
    """The guide with the tools and keys that there are, between its comments."""
    from patterndb_sketch.retopo.table import describe_tools
    from viewer.retopo.keys import KEY_HELP, MOUSE_HELP
    from viewer.retopo.modes import list_modes

    tools = ["| tool | argument | |", "|---|---|---|"]
    for name, word, said in describe_tools():
        tools.append(f"| | `{word}` | {said} |" if word else f"| `{name}` | | {said} |")
    keys = ["| key | tool | |", "|---|---|---|"]
    keys += [f"| `{m.key}` | {m.title} | {spaced(m.hint)} |" for m in list_modes() if m.key]
    keys += ["", "| key | |", "|---|---|", *(f"| `{key}` | {said} |" for key, said in KEY_HELP)]
    keys += ["", spaced(MOUSE_HELP) + "."]
    return between(between(text, "Tools", tools), "Keys", keys)


def spaced(text: str) -> str:
    """What the window parts by wide spaces, parted by semicolons."""
    return re.sub(r" {3,}", "; ", text)
