"""The table of tools: what calls there are, for scripts, windows, the guide and the tests.

A tool is a module in :mod:`patterndb_sketch.retopo.tools` with its entry, a
:class:`~patterndb_sketch.retopo.tool.Tool`, as a constant. This module finds the entries, so
that one more tool is one more module, and nothing else knows it by name.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from patterndb_sketch.retopo import tools
from patterndb_sketch.retopo.tool import Tool, accept_snap

#: Calls that the editor obeys itself, and that a script has beside tools: no tool may be called so.
NOT_TOOLS = ("undo", "redo", "open", "export")


def find_tools() -> dict[str, Tool]:
    """The tools by name, in the order of their positions.

    Raises ValueError for two of one name or one key, and for a name that scripts need: mistakes in
    an entry, which show as soon as anything is imported.
    """
    found: dict[str, Tool] = {}
    keys: dict[str, str] = {}
    for module in pkgutil.iter_modules(tools.__path__):
        for entry in vars(import_module(f"{tools.__name__}.{module.name}")).values():
            if not isinstance(entry, Tool):
                continue
            if entry.name in NOT_TOOLS or found.get(entry.name, entry) is not entry:
                raise ValueError(f"{module.name}: there is another tool {entry.name!r}")
            key = entry.control.key
            if key and keys.setdefault(key, entry.name) != entry.name:
                raise ValueError(f"{entry.name} and {keys[key]} have both the key {key!r}")
            found[entry.name] = entry
    ordered = sorted(found.values(), key=lambda tool: (tool.position, tool.name))
    return {tool.name: accept_snap(tool) for tool in ordered}


#: The tools by name; "undo" and "redo" are the editor's own.
TOOLS = find_tools()


def describe_tools() -> list[tuple[str, str, str]]:
    """The table in words: rows of a tool, an argument and what it is; a tool's own row, with its
    help, has no argument."""
    rows: list[tuple[str, str, str]] = []
    for name, tool in TOOLS.items():
        rows.append((name, "", tool.help))
        rows += [(name, word, argument.describe()) for word, argument in tool.arguments.items()]
    return rows
