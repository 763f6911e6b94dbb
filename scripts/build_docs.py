"""Write docs/cli.md, docs/api.md and lists of docs/retopo.md from the code; pictures and output
from the program.

    python scripts/build_docs.py              write them
    python scripts/build_docs.py --check      exit code 1 and a diff if they are stale
    python scripts/build_docs.py --walk       do what README and guides say (three
                                              minutes), and keep the pictures and the output
                                              that they show

The pages are put together here, not by click's or inspect's own formatting, so that they
are the same under every version of Python and click.
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import inspect
import json
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import click
import walkthrough

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
IMAGES = DOCS / "images"

#: The modules of the API page, each with the names it documents; None: its ``__all__``.
MODULES: dict[str, tuple[str, ...] | None] = {
    "patterndb": None,
    "patterndb.store": None,
    "ingest": None,
    "query": None,
    "query.placing": None,
    "query.boundaryfile": ("parse_boundary", "read_boundary", "read_strokes"),
    "sketch.surfacing": None,
    "sketch.surfacing.chords": ("Decomposition", "decompose", "affordable"),
    "sketch.surfacing.tessellation": ("PatchMesh", "minimal_area", "tessellate_patch"),
    "sketch.surfacing.quads": ("even_edges", "fill_with_quads"),
    "sketch.features.model": ("Model", "Feet", "Crossings"),
    "sketch.features.strokes": ("Stroke", "RecoveredCurve", "Figures", "Spread", "recovered"),
    "sketch.features.snap": ("Snap", "SnapSettings", "FeatureCurve", "snap"),
    "sketch.features.splines": ("Spline", "Fit", "fit_spline"),
    "sketch.features.drag": ("View", "Drag", "begin_drag", "dragged"),
    "sketch.features.files.strokesjson": ("read_strokes", "write_strokes"),
    "sketch.features.files.curvesjson": ("read_curves", "write_curves"),
    "sketch.features.registration": None,
    "sketch.features.shapemodel": None,
    "sketch.features.sessionfile": (
        "Session",
        "SessionCurve",
        "read_session",
        "write_session",
        "read_template",
        "write_template",
        "write_network",
        "read_shapes",
        "write_shapes",
    ),
    "sketch.features.errors": ("InvalidFeatureError",),
    "sketch.retopo": None,
    "sketch.retopo.editor": ("Call", "Editor", "Outcome", "State"),
    "sketch.retopo.ground": ("Ground", "Feet", "Projected", "Stroke", "cleaned"),
    "sketch.retopo.network": ("Network", "Node", "Chain", "Patch"),
    "sketch.retopo.filling": ("FilledNetwork", "RetopoMesh", "completed", "welded", "ranked"),
    "sketch.retopo.filling.report": ("Report", "report", "hausdorff"),
    "sketch.retopo.script": ("Script", "Line", "read_script", "write_script", "play"),
    "sketch.retopo.sessionfile": ("Session", "read_session", "write_session"),
    "sketch.retopo.symmetry": None,
    "sketch.retopo.quadimport": ("Imported", "imported"),
    "viewer": None,
    "viewer.surfacing": None,
    "viewer.features": None,
    "viewer.shapes": None,
    "viewer.retopo": None,
    "patterndb.pattern": ("Pattern",),
    "patterndb.patternclass": ("PatternClass",),
    "patterndb.disk": ("Disk",),
    "patterndb.polygonmesh": ("PolygonMesh",),
    "query.listing.filters": ("Filters",),
    "query.families.family": ("Family", "family"),
    "patterndb.errors": (
        "InvalidMeshError",
        "MeshFileError",
        "UnsupportedFormatError",
        "InvalidCodeError",
        "InvalidBoundaryError",
        "DatabaseError",
        "NotFoundError",
        "MissingExtraError",
    ),
    "query.errors": ("InvalidQueryError",),
}

#: The pages whose steps draw pictures; they show them as images/NAME.
ILLUSTRATED = (
    ROOT / "README.md",
    DOCS / "tutorial.md",
    DOCS / "queries.md",
    DOCS / "surfacing.md",
    DOCS / "features.md",
    DOCS / "retopo.md",
)

#: How the names of pictures begin that scripts/draw_NAME.py draw, and no step does.
DRAWN_APART = (
    "bodies",
    "explorer-",
    "placing-",
    "surfacing-",
    "features-",
    "shapes-",
    "retopo-",
)

#: Bytes that a picture of the documentation may have.
LARGEST_PICTURE = 300_000

NOTICE = "<!-- Written by scripts/build_docs.py; change the code it describes instead. -->\n"


# The command line


def cli_page() -> str:
    from patterndb.cli import cli

    verbs = list(leaves(cli))
    lines = [NOTICE, "# Command line\n", *help_text(cli.help), "| verb | |", "|---|---|"]
    links = dict(zip((name for name, _ in verbs), anchors(n for n, _ in verbs), strict=True))
    lines += [f"| [{name}](#{links[name]}) | {summary(command.help)} |" for name, command in verbs]
    lines += [
        "",
        "Every verb has `--help` (or `-h`). `python -m patterndb` is the same program.\n",
    ]
    for name, command in verbs:
        lines += [f"## {name}\n", *fence("text", usage(name, command)), *help_text(command.help)]
        options = [p for p in command.params if isinstance(p, click.Option)]
        if not options:
            continue
        lines += ["| option | |", "|---|---|"]
        lines += [f"| {option_name(o)} | {option_help(o)} |" for o in options]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def leaves(group: click.Group, before: str = "") -> Iterator[tuple[str, click.Command]]:
    """All verbs by their names, those of a group after it."""
    for word, command in group.commands.items():
        yield before + word, command
        if isinstance(command, click.Group):
            yield from leaves(command, f"{before}{word} ")


def usage(name: str, command: click.Command) -> str:
    if isinstance(command, click.Group):
        return f"patterndb {name} {'|'.join(command.commands)} ..."
    words = ["patterndb", name, "[OPTIONS]"]
    for param in command.params:
        if isinstance(param, click.Argument):
            word = param.metavar or (param.name or "").upper()
            words.append(word if param.required else f"[{word}]")
    return " ".join(words)


def option_name(option: click.Option) -> str:
    names = ", ".join([*option.opts, *option.secondary_opts])
    if option.is_flag:
        return f"`{names}`"
    kind = option.type
    choices = [str(c) for c in kind.choices] if isinstance(kind, click.Choice) else []
    value = option.metavar or "\\|".join(choices) or kind.name.upper()
    return f"`{names} {value}`"


def option_help(option: click.Option) -> str:
    text = option.help or ""
    if option.required:
        text += " Required."
    if option.secondary_opts:
        text += f" Default: {option.opts[0] if option.default else option.secondary_opts[0]}."
    elif option.show_default and option.default is not None and not option.is_flag:
        text += f" Default: {option.default}."
    return re.sub(r"\s+", " ", text).strip()


def summary(text: str | None) -> str:
    first = inspect.cleandoc(text or "").split("\n\n")[0]
    return re.sub(r"\s+", " ", first).partition(". ")[0].removesuffix(".") + "."


def help_text(text: str | None) -> list[str]:
    """Paragraphs as they are, and click's unwrapped ones, which hold examples, fenced."""
    lines: list[str] = []
    for paragraph in inspect.cleandoc(text or "").split("\n\n"):
        if paragraph.startswith("\b\n"):
            lines += fence("sh", paragraph[2:])
        else:
            lines.append(paragraph + "\n")
    return lines


# Parts of the guide to retopology


def retopo_page(text: str) -> str:
    """The guide with the tools and keys that there are, between its comments."""
    from sketch.retopo.editor import TOOLS
    from sketch.retopo.editor.arguments import REQUIRED
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


def between(text: str, name: str, lines: Iterable[str]) -> str:
    """A page with these lines between the comments that begin and end what ``name`` is."""
    begin = re.search(rf"^<!-- {name}: .*-->\n", text, re.MULTILINE)
    end = text.find(f"<!-- End of {name.lower()}. -->")
    if begin is None or end < begin.end():
        raise ValueError(f"the page has no place for {name.lower()}")
    return text[: begin.end()] + "\n" + "\n".join(lines) + "\n\n" + text[end:]


# The Python interface


def api_page() -> str:
    lines = [
        NOTICE,
        "# Python interface\n",
        "What can be imported from where. Arrays are numpy's; a shape such as (q, 4) names its "
        "sizes. The words are those of [definitions.md](definitions.md).\n",
    ]
    body: list[str] = []
    home: dict[Any, str] = {}
    taken: list[str] = []
    for module_name, names in MODULES.items():
        module = importlib.import_module(module_name)
        listed: list[str] = []
        for name in names or sorted(module.__all__):
            thing = getattr(module, name)
            title = f"{module_name}.{name}"
            if thing not in home:
                taken.append(title)
                home[thing] = anchors(taken)[-1]
                body += [f"### {title}\n", *describe(name, thing)]
            listed.append(f"[`{name}`](#{home[thing]})")
        lines.append(f"- `{module_name}`: {', '.join(listed)}")
    return "\n".join([*lines, "", *tidy(body)]).rstrip() + "\n"


def tidy(lines: list[str]) -> Iterator[str]:
    """Without the empty lines that follow one another."""
    for i, line in enumerate(lines):
        if line or (i and lines[i - 1]):
            yield line


def anchors(titles: Iterable[str]) -> list[str]:
    """The anchors that Markdown renderers give headings; one that is taken gets a number."""
    found: list[str] = []
    seen: Counter[str] = Counter()
    for title in titles:
        plain = re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
        found.append(f"{plain}-{seen[plain]}" if seen[plain] else plain)
        seen[plain] += 1
    return found


def describe(name: str, thing: Any) -> list[str]:
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
    for member, value in vars(thing).items():
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


def signature(name: str, function: Any, *, drop_first: bool = False) -> str:
    """``name(parameters) -> result``, on one line or with a line for each parameter."""
    described = inspect.signature(function)
    parameters = list(described.parameters.values())[drop_first:]
    words: list[str] = []
    star = False
    for p in parameters:
        if p.kind is p.VAR_POSITIONAL:
            star = True
        if p.kind is p.KEYWORD_ONLY and not star:
            words.append("*")
            star = True
        mark = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "")
        word = mark + p.name
        if p.annotation is not p.empty:
            word += f": {spelled(p.annotation)}"
        if p.default is not p.empty:
            word += f" = {default(p.default)}" if ":" in word else f"={default(p.default)}"
        words.append(word)
    result = returned(function)
    tail = f" -> {result}" if result and result != "None" else ""
    line = f"{name}({', '.join(words)}){tail}"
    if len(line) <= 88:
        return line
    return f"{name}(\n" + "".join(f"    {word},\n" for word in words) + f"){tail}"


def one_line(text: str) -> str:
    return re.sub(r",\)", ")", re.sub(r"\s+", " ", text).replace("( ", "(")).replace(", )", ")")


def returned(function: Any) -> str:
    annotation = getattr(function, "__annotations__", {}).get("return", "")
    return spelled(annotation) if annotation else ""


def spelled(annotation: Any) -> str:
    return annotation if isinstance(annotation, str) else getattr(annotation, "__name__", "Any")


def default(value: Any) -> str:
    # A default_factory has an object of dataclasses' own, whose text holds an address.
    text = repr(value)
    return "..." if text.startswith("<") else text


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


def inline(text: str) -> str:
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text)
    return text.replace("``", "`")


def fence(language: str, text: str) -> list[str]:
    return [f"```{language}", text.strip("\n"), "```", ""]


# Pictures


def walk(page: Path) -> None:
    """Do what a page says; keep the pictures it shows, and what its steps write."""
    from PIL import Image

    IMAGES.mkdir(exist_ok=True)
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        walkthrough.begin(folder)
        for step in walkthrough.steps(page):
            print(step.text, end="", flush=True)
            written = walkthrough.perform(step, folder)
            if step.shown is not None:
                said = f"{step.text}```\n\n```text output\n"
                old = said + step.shown
                assert text.count(old) == 1, f"{page.name}:{step.line} stands there twice"
                text = text.replace(old, said + shortened(written, step.shown))
        for picture in pictures_of_steps(text):
            # Few colours are used: a palette makes the file a third as large.
            image = Image.open(folder / picture).convert("RGB").quantize(128)
            image.save(IMAGES / picture, optimize=True)
            size = (IMAGES / picture).stat().st_size
            print(f"{picture}: {size:,} bytes")
            if size > LARGEST_PICTURE:
                sys.exit(f"{picture} has over {LARGEST_PICTURE:,} bytes; draw less in it")
    page.write_text(text, encoding="utf-8")


def pictures_of_steps(text: str) -> list[str]:
    """The names of the pictures that a page shows and its steps draw."""
    shown = re.findall(r"images/([\w-]+\.png)", text)
    return [name for name in shown if not name.startswith(DRAWN_APART)]


def shortened(written: str, shown: str) -> str:
    """What was written, with as many lines before and after a line … as were shown."""
    lines, old = written.splitlines(), shown.splitlines()
    first = [line for line in old[:1] if line == "…"]
    rest = old[len(first) :]
    if "…" in rest:
        cut = rest.index("…")
        after = len(rest) - cut - 1
        lines = [*lines[:cut], "…", *lines[len(lines) - after :]]
    elif first:
        lines = lines[len(lines) - len(rest) :]
    return "".join(f"{line}\n" for line in [*first, *lines])


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="only say whether they are stale")
    parser.add_argument("--walk", action="store_true", help="do what the pages say")
    arguments = parser.parse_args()
    if arguments.walk:
        for page in ILLUSTRATED:
            walk(page)
        return
    stale = False
    retopo = DOCS / "retopo.md"
    for path, page in (
        (DOCS / "cli.md", cli_page()),
        (DOCS / "api.md", api_page()),
        (retopo, retopo_page(retopo.read_text(encoding="utf-8"))),
    ):
        old = path.read_text(encoding="utf-8") if path.exists() else ""
        if old == page:
            continue
        stale = True
        name = path.relative_to(ROOT).as_posix()
        if arguments.check:
            sys.stdout.writelines(
                difflib.unified_diff(
                    old.splitlines(True), page.splitlines(True), name, f"{name} (from the code)"
                )
            )
        else:
            path.write_text(page, encoding="utf-8")
            print(f"written: {name}")
    if arguments.check and stale:
        sys.exit("the documentation is stale; 'make docs' writes it anew")


if __name__ == "__main__":
    main()
