"""The page of the command line, from the commands' own help."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator

import click
from build_docs_markdown import NOTICE, anchors, fence

from patterndb_app.cli.program import SECTIONS, SectionedCommand


def cli_page() -> str:
    from ingest.formats import FORMATS
    from patterndb_app.cli import cli

    verbs = list(leaves(cli))
    lines = [NOTICE, "# Command line\n", *help_text(cli.help)]
    names = [name for name, _ in verbs]
    links = dict(zip(names, anchors(["Mesh files", *names])[1:], strict=True))
    for title, section in SECTIONS.items():
        lines += [f"| {title} | |", "|---|---|"]
        lines += [
            f"| [{name}](#{links[name]}) | {summary(command.help)} |"
            for name, command in verbs
            if name.partition(" ")[0] in section
        ]
        lines.append("")
    lines += [
        "",
        "Every verb has `--help` (or `-h`). `python -m patterndb` is the same program.\n",
    ]
    lines += ["## Mesh files\n", "| format | files | |", "|---|---|---|"]
    for entry in FORMATS:
        suffixes = " ".join(f"`{suffix}`" for suffix in entry.suffixes)
        lines.append(f"| {entry.name} | {suffixes} | {entry.help}. |")
    lines.append("")
    for name, command in verbs:
        lines += [f"## {name}\n", *fence("text", usage(name, command)), *help_text(command.help)]
        for title, options in group_options(command).items():
            lines += [f"| {title} | |", "|---|---|"]
            lines += [f"| {option_name(o)} | {option_help(o)} |" for o in options]
            lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def leaves(group: click.Group, before: str = "") -> Iterator[tuple[str, click.Command]]:
    """All verbs by their names, those of a group after it."""
    context = click.Context(group)
    for word in group.list_commands(context):
        command = group.get_command(context, word)
        assert command is not None
        yield before + word, command
        if isinstance(command, click.Group):
            yield from leaves(command, f"{before}{word} ")


def usage(name: str, command: click.Command) -> str:
    if isinstance(command, click.Group):
        return f"patterndb {name} {'|'.join(command.list_commands(click.Context(command)))} ..."
    words = ["patterndb", name, "[OPTIONS]"]
    for param in command.params:
        if isinstance(param, click.Argument):
            word = param.metavar or (param.name or "").upper()
            words.append(word if param.required else f"[{word}]")
    return " ".join(words)


def group_options(command: click.Command) -> dict[str, list[click.Option]]:
    """Group a verb's options as its help does, but for --help; a group without options has none."""
    if isinstance(command, SectionedCommand):
        return command.group_options()
    options = [p for p in command.params if isinstance(p, click.Option)]
    return {"option": options} if options else {}


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
    elif isinstance(option.show_default, str):
        text += f" Default: {option.show_default}."
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
