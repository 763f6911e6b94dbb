"""The program's verbs in their sections, each loaded when it is asked for, and help in sections."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import click

from patterndb_app.cli.compiletalk import told_compiling
from patterndb_app.cli.failure import explain
from patterndb_app.cli.progressline import told_waiting

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
        "warmup": "warmup",
    },
    "Sketch": {
        "surface": "surface",
        "retopo": "retopo",
        "features": "features",
        "register": "register",
        "shape-model": "shape_model",
    },
}


class Program(click.Group):
    """The group of all verbs; it ends every error with a message and an exit code."""

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        """As click's; out of standalone mode errors are raised."""
        if not standalone_mode:
            return super().main(*args, standalone_mode=False, **extra)
        try:
            result = super().main(*args, standalone_mode=False, **extra)
        except Exception as error:
            code = explain(error)
        except KeyboardInterrupt as error:
            code = explain(error)
        else:
            code = result if isinstance(result, int) else 0
        sys.exit(code)

    def invoke(self, ctx: click.Context) -> Any:
        """As click's; what the verb has to compile is told, and that it is at work."""

        def name_verb() -> str | None:
            return ctx.invoked_subcommand

        with told_waiting(name_verb), told_compiling(name_verb):
            return super().invoke(ctx)

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
