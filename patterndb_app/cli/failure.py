"""How errors end the program: one line that says what would mend it, and an exit code."""

from __future__ import annotations

import contextlib
import os
import traceback
from collections.abc import Generator
from pathlib import Path

import click

from patterndb.errors import NotFoundError, PatternDBError, TimeLimitError
from patterndb_app.cli.text import say

EXIT_NOTHING = 1
EXIT_USAGE = 2
EXIT_BAD_INPUT = 3
EXIT_INTERRUPTED = 130

#: Set, it shows where an error came from that no one foresaw.
TRACEBACK = "PATTERNDB_TRACEBACK"


class Interrupted(Exception):  # noqa: N818 (it is no error)
    """The user broke off; the message says what is kept and how to go on."""


@contextlib.contextmanager
def resumable(how: str) -> Generator[None]:
    """Say ``how`` to go on if the block is interrupted."""
    try:
        yield
    except BaseException as error:
        if was_interrupted(error):
            raise Interrupted(how) from None
        raise


def was_interrupted(error: BaseException | None) -> bool:
    """Did Ctrl-C lead to this error?"""
    while error is not None:
        if isinstance(error, KeyboardInterrupt | click.Abort):
            return True
        error = error.__cause__ or error.__context__
    return False


def explain(error: BaseException) -> int:
    """Tell what went wrong; return the exit code."""
    if isinstance(error, click.ClickException):
        with contextlib.suppress(OSError):
            error.show()
        return error.exit_code
    if isinstance(error, Interrupted):
        say(f"interrupted: {error}")
        return EXIT_INTERRUPTED
    if was_interrupted(error):
        say("interrupted")
        return EXIT_INTERRUPTED
    if isinstance(error, NotFoundError | TimeLimitError):
        say(f"patterndb: {error}")
        return EXIT_NOTHING
    say(f"patterndb: {_reason(error)}")
    if os.environ.get(TRACEBACK):
        say("".join(traceback.format_exception(error)))
    return EXIT_BAD_INPUT


def _reason(error: BaseException) -> str:
    if isinstance(error, PatternDBError):
        return str(error)
    if isinstance(error, OSError):
        what = error.strerror or str(error)
        return f"{error.filename}: {what}" if error.filename is not None else what
    if isinstance(error, MemoryError):
        return "this needs more memory than there is; ask for shorter sides or fewer fills"
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return (
        f"unforeseen error: {type(error).__name__}: {error} "
        f"({Path(frame.filename).name}:{frame.lineno}); 'patterndb verify' tells whether the "
        f"database is damaged. If it is sound, please report this; {TRACEBACK}=1 shows more"
    )
