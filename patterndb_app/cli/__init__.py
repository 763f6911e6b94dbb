"""The command line. It stands above all packages; nothing imports it.

stdout is data, stderr is talk. Exit codes: 0 done, 1 nothing found, 2 wrong usage, 3 bad
input or database, 130 interrupted.

A module holds a tool, one verb or a few that belong together. Read in this order: text and failure
(how a verb speaks, and how it ends), program (the table of verbs), options, then the verbs; search
has the options that query and fill share, obj the files that several of them write.
"""

from __future__ import annotations

import _thread
import contextlib
import gc
import os
import signal
import sys
import threading

import click

import patterndb
from patterndb.system.deadline import has_tasks_left
from patterndb_app.cli.failure import (
    EXIT_BAD_INPUT,
    EXIT_INTERRUPTED,
    EXIT_NOTHING,
    EXIT_USAGE,
)
from patterndb_app.cli.program import Program
from patterndb_app.cli.text import WIDTH

__all__ = ["EXIT_BAD_INPUT", "EXIT_INTERRUPTED", "EXIT_NOTHING", "EXIT_USAGE", "cli", "main"]


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


#: Seconds after which Ctrl-C that was dropped is raised again.
INTERRUPT_SECONDS = 0.02


def main(began: float | None = None) -> None:
    """Run the command line, and end the process; began: when that did (``time.perf_counter``)."""
    sys.unraisablehook = _interrupt_again
    try:
        cli(obj=began)
    except SystemExit as leaving:
        # What is left is to end; Ctrl-C changes no exit code any more.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        # The last garbage collection would look through all modules, for a fifth of a second.
        gc.freeze()
        if not has_tasks_left():
            raise
        # Python would wait for steps that a time limit or Ctrl-C has left to themselves.
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError, AttributeError):
                stream.flush()
        os._exit(leaving.code if isinstance(leaving.code, int) else 1)


def _interrupt_again(lost: sys.UnraisableHookArgs) -> None:
    """Raise Ctrl-C once more where it was lost: callbacks of libraries and destructors drop it."""
    if isinstance(lost.exc_value, KeyboardInterrupt):
        # Later and from elsewhere: raised in here it would be dropped as well.
        again = threading.Timer(INTERRUPT_SECONDS, _thread.interrupt_main)
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(lost)
