"""The command line. It stands above all packages; nothing imports it.

stdout is data, stderr is talk. Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad
input or database, 130 interrupted.
"""

from __future__ import annotations

import sys
from typing import Any

import click

import patterndb
from patterndb_app.cli import (
    asking,
    exchanging,
    exploring,
    features,
    filling,
    learning,
    pictures,
    querying,
    registering,
    retopo,
    shapes,
    surfacing,
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


for command in (
    *learning.COMMANDS,
    *asking.COMMANDS,
    *querying.COMMANDS,
    *filling.COMMANDS,
    *pictures.COMMANDS,
    *exploring.COMMANDS,
    *surfacing.COMMANDS,
    *retopo.COMMANDS,
    *features.COMMANDS,
    *registering.COMMANDS,
    *shapes.COMMANDS,
    *exchanging.COMMANDS,
):
    cli.add_command(command)


def main() -> None:
    """Run the command line."""
    cli()
