"""The parts of the guide to retopology that the code tells: its tools and keys."""

from __future__ import annotations

import json
import re

from build_docs_markdown import between


def retopo_page(text: str) -> str:
    """The guide with the tools and keys that there are, between its comments."""
    from patterndb_sketch.retopo.arguments import REQUIRED
    from patterndb_sketch.retopo.editor import TOOLS
    from viewer.retopo.keys import KEY_HELP, MOUSE_HELP
    from viewer.retopo.modes import modes

    tools = ["| tool | argument | |", "|---|---|---|"]
    for name, tool in TOOLS.items():
        tools.append(f"| `{name}` | | {tool.help} |")
        for word, argument in tool.arguments.items():
            wanted = argument.kind.wanted.replace("a number from 1e-12 on", "a number above 0")
            said = f"{argument.help}: {wanted}"
            if argument.default is REQUIRED:
                said += ". Required"
            elif argument.default is not None:
                said += f". Default: {json.dumps(argument.default)}"
            tools.append(f"| | `{word}` | {said} |")
    keys = ["| key | tool | |", "|---|---|---|"]
    keys += [f"| `{m.key}` | {m.title} | {spaced(m.hint)} |" for m in modes() if m.key]
    keys += ["", "| key | |", "|---|---|", *(f"| `{key}` | {said} |" for key, said in KEY_HELP)]
    keys += ["", spaced(MOUSE_HELP) + "."]
    return between(between(text, "Tools", tools), "Keys", keys)


def spaced(text: str) -> str:
    """What the window parts by wide spaces, parted by semicolons."""
    return re.sub(r" {3,}", "; ", text)
