"""The program's verbs in their sections, each loaded when it is asked for, and help in sections."""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

import click

from patterndb.errors import PatternDBError
from patterndb.system.memory import refuse_small_address_space
from patterndb_app.cli.failure import EXIT_BAD_INPUT, explain
from patterndb_app.cli.progressline import told_waiting
from patterndb_app.cli.text import is_output_lost, say

#: The verbs by what one wants, in the order of the help, and the module that each stands in. One
#: more verb is one more entry.
SECTIONS: Mapping[str, Mapping[str, str]] = {
    "Learn": {
        "ingest": "ingest",
        "import-ddq": "exchange",
    },
    "Ask and fill": {
        "query": "query",
        "fill": "fill",
        "holes": "holes",
    },
    "Look": {
        "list": "listing",
        "stats": "database",
        "meshes": "database",
        "show": "pictures",
        "gallery": "pictures",
        "browse": "pictures",
        "explore": "explore",
    },
    "Serve": {
        "serve": "serve",
    },
    "Maintain": {
        "verify": "database",
        "merge": "database",
        "remove": "database",
        "diff": "database",
        "report": "report",
        "export": "listing",
        "export-ddq": "exchange",
    },
    "Sketch": {
        "surface": "surface",
        "retopo": "retopo",
        "features": "features",
        "register": "register",
        "shape-model": "shape_model",
    },
}


class VerbGroup(click.Group):
    """A group of verbs; where one is misspelt, those that are spelt alike are named."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As click's, but that the error offers verbs."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            near = find_alike(name, self.list_commands(ctx))
            offered = f"did you mean {' or '.join(near)}?" if near else "--help lists the verbs"
            raise click.UsageError(f"there is no verb {name!r}; {offered}", ctx)
        return super().resolve_command(ctx, args)


#: Names that are offered for a misspelt one, at most, and how alike they must be (difflib).
MOST_OFFERED = 3
LEAST_ALIKE = 0.6


def find_alike(name: str, known: Sequence[str]) -> list[str]:
    """Find those of the known names that may be meant by one that is unknown."""
    plain = name.lower().replace("_", "-")
    near = difflib.get_close_matches(plain, known, MOST_OFFERED, LEAST_ALIKE)
    near += [one for one in known if plain and one.startswith(plain) and one not in near]
    # The same letters without the hyphen are meant.
    same = [one for one in known if one.replace("-", "") == plain.replace("-", "")]
    return same or near[:MOST_OFFERED]


def suggest_list(ctx: click.Context, given: Sequence[str]) -> str | None:
    """Suggest the option as it should be written, where the values of a list have blanks between
    them, or stand without their option; None where nothing of the kind was given."""
    lists = [
        (param, name)
        for param in ctx.command.params
        if getattr(param.type, "has_commas", False)
        for name in param.opts
    ]
    for param, name in lists:
        for at, word in enumerate(given):
            if word == name or word.startswith(name + "="):
                values = [*word.split("=", 1)[1:], *given[at + 1 :]]
                joined = _join_values(param, ctx, values)
                if joined is not None:
                    return f"{name} {joined}"
    verb = ctx.info_name or ""
    alone = list(given[given.index(verb) + 1 :]) if verb in given else list[str]()
    for param, name in lists:
        if name == "--sides" and name not in given and alone:
            joined = _join_values(param, ctx, [*alone[0].split(","), *alone[1:]])
            if joined is not None:
                return f"{name} {joined}"
    return None


def _offer_list(error: click.UsageError, given: Sequence[str]) -> click.UsageError:
    """The error, with the list as it should be written where one was not."""
    better = None if error.ctx is None else suggest_list(error.ctx, given)
    if better is None:
        return error
    text = f"{error.format_message()}; lists have commas and no blanks: {better}"
    return click.UsageError(text, error.ctx)


#: Values of a list that are looked at.
MOST_VALUES = 64


def _join_values(param: click.Parameter, ctx: click.Context, words: Sequence[str]) -> str | None:
    """The most of the first words that are the option's value with commas between them, two at
    least; None where they are not."""
    found = None
    joined = ""
    for count, word in enumerate(words[:MOST_VALUES], 1):
        if word.startswith("--"):
            break
        joined = f"{joined},{word.strip(',')}" if joined else word.strip(",")
        try:
            param.type.convert(joined, param, ctx)
        except click.UsageError:
            continue
        found = joined if count > 1 else found
    return found


def name_options(text: str, command: click.Command | None = None) -> str:
    """Name the options of a verb where a message of the library names its own keywords.

    command: the verb; that which runs if not given.
    """
    command = command or click.get_current_context().command
    for name, option in _list_options(command):
        text = re.sub(rf"""(?<![\w./-]){name}="?([\w-]+)"?""", rf"{option} \1", text)
        if "_" in name:
            text = re.sub(rf"(?<![\w./-]){name}(?![\w./-])", option, text)
    return text


def _list_options(command: click.Command) -> Iterator[tuple[str, str]]:
    for param in command.params:
        if isinstance(param, click.Option) and param.name:
            yield param.name, max(param.opts, key=len)


class Program(VerbGroup):
    """The group of all verbs; it ends every error with a message and an exit code."""

    #: Does the verb that ran change a database? Then its answer on stdout is only a report.
    _changes_database = False

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        """As click's; out of standalone mode errors are raised."""
        if not standalone_mode:
            return super().main(*args, standalone_mode=False, **extra)
        try:
            result = super().main(*args, standalone_mode=False, **extra)
        except click.UsageError as error:
            given = args[0] if args else extra.get("args")
            code = explain(_offer_list(error, sys.argv[1:] if given is None else list(given)))
        except Exception as error:
            code = explain(error)
        except KeyboardInterrupt as error:
            code = explain(error)
        else:
            code = result if isinstance(result, int) else 0
            if code == 0 and is_output_lost() and not self._changes_database:
                say("patterndb: stdout is closed: the answer could not be written")
                code = EXIT_BAD_INPUT
        sys.exit(code)

    def invoke(self, ctx: click.Context) -> Any:
        """As click's; says that the verb is at work when it takes long."""

        def name_verb() -> str | None:
            return ctx.invoked_subcommand

        with told_waiting(name_verb):
            try:
                return super().invoke(ctx)
            except PatternDBError as error:
                command = self.get_command(ctx, name_verb() or "")
                if command is not None:
                    error.args = (name_options(str(error), command), *error.args[1:])
                raise

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As :class:`VerbGroup` does; notes what the verb does. A process with too little memory
        gets no further than its help."""
        if not {"-h", "--help"}.intersection(args):
            refuse_small_address_space()
        found = super().resolve_command(ctx, args)
        params = [] if found[1] is None else found[1].params
        self._changes_database = any("--db" in one.opts and one.required for one in params)
        return found

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the verbs in the order of their sections."""
        return [verb for verbs in SECTIONS.values() for verb in verbs]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load a verb: of the other modules none is imported."""
        module = next((verbs[cmd_name] for verbs in SECTIONS.values() if cmd_name in verbs), None)
        if module is None:
            return None
        held = vars(import_module(f"patterndb_app.cli.{module}")).values()
        return next(c for c in held if isinstance(c, click.Command) and c.name == cmd_name)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the verbs, a list for each section."""
        width = max(map(len, self.list_commands(ctx)))
        for title, verbs in SECTIONS.items():
            rows = [(verb, self._summarise(ctx, verb)) for verb in verbs]
            with formatter.section(title):
                # Columns of one width, so that the sections line up.
                formatter.write_dl([(verb.ljust(width), said) for verb, said in rows])

    def _summarise(self, ctx: click.Context, verb: str) -> str:
        command = self.get_command(ctx, verb)
        assert command is not None
        return command.get_short_help_str(limit=WHOLE_SENTENCE)


#: Characters of a first sentence that the help may show: more than any has.
WHOLE_SENTENCE = 1000


class SectionedCommand(click.Command):
    """A verb with many options, whose help lists them in sections.

    sections: the options, as they are written, by the titles of their sections. Each option but
    --help is in one of them.
    """

    def __init__(
        self, *args: Any, sections: Mapping[str, Sequence[str]] | None = None, **extra: Any
    ) -> None:
        super().__init__(*args, **extra)
        self.sections = sections or {}

    def group_options(self) -> dict[str, list[click.Option]]:
        """Group the options but --help by the titles of their sections."""
        options = {name: p for p in self.params if isinstance(p, click.Option) for name in p.opts}
        return {title: [options[name] for name in names] for title, names in self.sections.items()}

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, a list for each section, and --help."""
        asked = self.get_help_option(ctx)
        for title, options in {**self.group_options(), "Help": [asked] if asked else []}.items():
            rows = [row for option in options if (row := option.get_help_record(ctx)) is not None]
            with formatter.section(title):
                formatter.write_dl(rows)
