"""The page of the Python interface: what can be imported from where, from its docstrings."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterable, Mapping
from typing import Any

from build_docs_markdown import NOTICE, anchors, fence, prose, tidy
from build_docs_signatures import one_line, returned, signature

from patterndb.system.requests import Request, list_options

#: The modules of the API page, all of whose public names it documents.
MODULES = (
    "patterndb",
    "patterndb_sketch.surfacing",
    "patterndb_sketch.features",
    "patterndb_sketch.retopo",
    "viewer",
)


def list_members(thing: type) -> list[tuple[str, Any]]:
    """Return what a class defines, and the verbs that it has from patterndb.verbs."""
    verbs = [base for base in thing.__mro__ if base.__module__ == "patterndb.verbs"]
    return [member for one in (thing, *verbs) for member in vars(one).items()]


def describe_options(request: type[Request]) -> list[str]:
    """Return a table of the options of a request."""
    rows = [
        f"| `{name}` | `{one.default!r}` | {one.text.help} |".replace("\n", " ")
        for name, one in list_options(request).items()
    ]
    return ["| option | default | |", "| --- | --- | --- |", *rows, ""]


def api_page() -> str:
    lines = [
        NOTICE,
        "# Python interface\n",
        "What can be imported from where. Arrays are numpy's; a shape such as (q, 4) names its "
        "sizes. The words are those of [definitions.md](definitions.md).\n",
    ]
    body: list[str] = []
    home: dict[int, str] = {}
    taken: list[str] = []
    for module_name in MODULES:
        module = importlib.import_module(module_name)
        listed: list[str] = []
        for name in sorted(module.__all__):
            thing = getattr(module, name)
            title = f"{module_name}.{name}"
            if id(thing) not in home:
                taken.append(title)
                home[id(thing)] = anchors(taken)[-1]
                body += [f"### {title}\n", *describe(name, thing)]
            listed.append(f"[`{name}`](#{home[id(thing)]})")
        lines.append(f"- `{module_name}`: {', '.join(listed)}")
    return "\n".join([*lines, "", *tidy(body)]).rstrip() + "\n"


def describe(name: str, thing: Any) -> list[str]:
    if isinstance(thing, Mapping):
        entries = ", ".join(f"`{entry}`" for entry in thing)
        return [f"The table of {name.lower()}, by name: {entries}.", ""]
    if isinstance(thing, tuple):
        entries = ", ".join(f"`{getattr(entry, 'name', entry)}`" for entry in thing)
        return [f"The table of {name.lower()}: {entries}.", ""]
    if not inspect.isclass(thing):
        names = inspect.signature(thing).parameters
        return [*fence("python", signature(name, thing)), *prose(thing.__doc__, names)]
    bases = [b.__name__ for b in thing.__bases__ if b is not object]
    head = f"class {name}" + (f"({', '.join(bases)})" if bases else "")
    made_of: Iterable[str] = ()
    if "__init__" in vars(thing) and not getattr(thing, "_is_protocol", False):
        # What a constructor sets is told of like what it takes.
        made_of = [*inspect.signature(thing.__init__).parameters][1:]
        made_of += [name for name in thing.__init__.__code__.co_names if name not in made_of]
        if not issubclass(thing, Exception):
            head = "class " + signature(name, thing.__init__, drop_first=True)
    lines = [*fence("python", head), *prose(thing.__doc__, [*made_of, *vars(thing)])]
    if issubclass(thing, Request):
        lines += describe_options(thing)
    for member, value in list_members(thing):
        if member.startswith("_"):
            continue
        if isinstance(value, property):
            returns = returned(value.fget)
            lines += [f"**`{member}`**{f' → `{returns}`' if returns else ''}", ""]
            lines += prose(value.fget.__doc__ if value.fget else None)
        elif isinstance(value, classmethod | staticmethod):
            text = signature(member, value.__func__, drop_first=isinstance(value, classmethod))
            lines += [f"**`{name}.{one_line(text)}`**", "", *prose(value.__func__.__doc__)]
        elif inspect.isfunction(value):
            text = signature(member, value, drop_first=True)
            lines += [f"**`.{one_line(text)}`**", "", *prose(value.__doc__)]
    return lines
