"""The command line. It stands above all packages; nothing imports it.

stdout is data, stderr is talk. Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad
input or database, 130 interrupted.

A module holds a tool, one verb or a few that belong together. Read in this order: text and failure
(how a verb speaks, and how it ends), options, then the verbs; search has the options that query
and fill share, obj the files that several of them write.
"""

from __future__ import annotations

import sys
from typing import Any

import click

import patterndb
from patterndb_app.cli import (
    database,
    explore,
    features,
    fill,
    ingest,
    pictures,
    query,
    register,
    retopo,
    shape_model,
    surface,
)
from patterndb_app.cli.failure import (
    EXIT_BAD_INPUT,
    EXIT_INTERRUPTED,
    EXIT_NOTHING,
    EXIT_USAGE,
    explain,
)
from patterndb_app.cli.text import WIDTH

__all__ = ["EXIT_BAD_INPUT", "EXIT_INTERRUPTED", "EXIT_NOTHING", "EXIT_USAGE", "cli", "main"]


class Program(click.Group):
    """A group of verbs that ends every error with a message and an exit code."""

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


@click.group(
    cls=Program,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": WIDTH},
)
@click.version_option(patterndb.__version__, prog_name="patterndb")
def cli() -> None:
    """Learn patterns from hand-made quad meshes, and fill boundaries with them.

    \b
    patterndb ingest meshes/ --db my.db       # learn every mesh of a folder
    patterndb query --sides 3,5,4,6           # fills of a boundary, as text
    patterndb gallery --class 5 -o five.png   # a sheet of five-sided patterns

    Verbs that only ask use the starter database unless --db names another. Results go to
    stdout, all else to stderr.

    Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad input or database,
    130 interrupted.
    """


#: The modules of the verbs: one more tool is one more module here.
TOOLS = (
    ingest,
    database,
    query,
    fill,
    pictures,
    explore,
    surface,
    retopo,
    features,
    register,
    shape_model,
)

for command in (command for tool in TOOLS for command in tool.COMMANDS):
    cli.add_command(command)


def main() -> None:
    """Run the command line."""
    cli()
