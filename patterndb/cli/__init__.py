"""The command line. It stands above all packages; nothing imports it.

stdout is data, stderr is talk. Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad
input or database, 130 interrupted.
"""

from __future__ import annotations

import os
import sys

import click

import patterndb
from patterndb.cli import asking, learning, pictures
from patterndb.errors import NotFoundError, PatternDBError

EXIT_NOTHING = 1
EXIT_BAD_INPUT = 3
EXIT_INTERRUPTED = 130


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(patterndb.__version__, prog_name="patterndb")
def cli() -> None:
    """Learn patterns from hand-made quad meshes, and fill boundaries with them.

    \b
    patterndb ingest meshes/ --db my.db        learn every mesh of a folder
    patterndb query --sides 3,5,4,6            fills for a boundary, as text
    patterndb gallery --class 5 -o five.png  a sheet of all five-sided patterns

    Verbs that only ask use the starter database unless --db names another.
    """


for command in (*learning.COMMANDS, *asking.COMMANDS, *pictures.COMMANDS):
    cli.add_command(command)


def main() -> None:
    """Run the command line, turning errors into messages and exit codes."""
    try:
        result = cli.main(standalone_mode=False)
        sys.exit(result if isinstance(result, int) else 0)
    except click.exceptions.Abort:
        click.echo("interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)
    except KeyboardInterrupt:
        click.echo("interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except NotFoundError as error:
        click.echo(f"patterndb: {error}", err=True)
        sys.exit(EXIT_NOTHING)
    except (PatternDBError, OSError) as error:
        if isinstance(error, BrokenPipeError):
            # The reader of our output has gone (head, say): that is no error of ours, and
            # Python must not complain about it once more while it shuts down.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            sys.exit(0)
        click.echo(f"patterndb: {error}", err=True)
        sys.exit(EXIT_BAD_INPUT)
