"""What the verbs write: data to stdout, talk to stderr.

Whoever reads either may go away at any time (``| head -1``). That is no error, and no reason
to break off an ingest half-way: what is written from then on is lost, and nothing else.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path

import click

#: Columns that tables and help texts are made for.
WIDTH = 100


class LastWord:
    """When something was said last, and what must go from the terminal's line before more is.

    at: by time.monotonic(). clear: takes away lines that change, each by a function of its own.
    """

    def __init__(self) -> None:
        self.at = time.monotonic()
        self.clear: list[Callable[[], None]] = []

    def begin(self) -> None:
        """Make way for a line that stays."""
        for clear in tuple(self.clear):
            clear()
        self.at = time.monotonic()


LAST_WORD = LastWord()


def say(text: str) -> None:
    """A line of talk."""
    LAST_WORD.begin()
    with contextlib.suppress(OSError):
        click.echo(text, err=True)


def write(text: str = "", *, end: str = "\n") -> None:
    """A line of data; OSError as writing raises it, but for a reader that has gone."""
    LAST_WORD.begin()
    if sys.stdout is None:  # pyright: ignore[reportUnnecessaryComparison]
        LOST.append(text)
        return
    try:
        try:
            click.echo(text + end, nl=False)
        except UnicodeEncodeError as error:
            # A terminal of few letters: the rest is written as \\u2603, say.
            plain = (text + end).encode(error.encoding, "backslashreplace")
            click.echo(plain.decode(error.encoding), nl=False)
    except BrokenPipeError:
        # Python would complain when it flushes on its way out; it shall find a reader then.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


#: What was to be written while stdout was closed from the beginning.
LOST: list[str] = []


def is_output_lost() -> bool:
    """Was data to be written to a stdout that was closed from the beginning?"""
    return bool(LOST)


def write_json(document: Mapping[str, object]) -> None:
    """One JSON document on one line."""
    write(_json(document))


def write_json_with(
    document: Mapping[str, object],
    name: str,
    items: Iterable[object],
    end: Callable[[], Mapping[str, object]] | None = None,
) -> None:
    """As write_json, with one more entry: the list of items, which are made one at a time,
    for the fills of long sides are large. end: gives the entries that follow, once they are known.
    """
    head = _json(document).removesuffix("}")
    write(head, end=f'{"," if document else ""}"{name}":[')
    for number, item in enumerate(items):
        write("," if number else "", end=_json(item))
    last: Mapping[str, object] = {} if end is None else end()
    write("]" + ("," + _json(last)[1:] if last else "}"))


def _json(value: object) -> str:
    # ASCII alone is valid whatever encoding stdout has.
    return json.dumps(value, separators=(",", ":"))


def plural(count: int, one: str, many: str | None = None) -> str:
    """ "1 mesh", "2,000 meshes": many is one and an s where it is not given."""
    return f"{count:,} {one if count == 1 else many or one + 's'}"


def tell_left_over(folder: Path, names: str, written: Collection[Path]) -> None:
    """Name the files of a folder that an earlier run left: they look like this run's.

    names: a pattern of the names that this run gives. written: the files that it wrote.
    """
    left = sorted({path.name for path in folder.glob(names)} - {path.name for path in written})
    if left:
        shown = ", ".join(map(printable, left[:SHOWN_LEFT_OVER]))
        more = ", …" if len(left) > SHOWN_LEFT_OVER else ""
        say(
            f"{plural(len(left), 'older file')} in {folder}, not of these: {shown}{more}; remove "
            "them, or name another folder"
        )


#: Names of left-over files that are told.
SHOWN_LEFT_OVER = 4


def printable(text: str) -> str:
    """The text on one line, without what would move a terminal's cursor."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shorten(text: str, width: int) -> str:
    """The text, cut to so many characters."""
    return text if len(text) <= width else text[: max(width - 1, 0)] + "…"


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Lines of columns under their heads; numbers to the right, the last column cut where
    the line would be longer than WIDTH."""
    cells = [[_cell(value) for value in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(heads, *cells, strict=True)]
    to_the_right = [all(isinstance(row[i], int) for row in rows) for i in range(len(heads))]
    room = WIDTH - sum(widths[:-1]) - 2 * (len(widths) - 1)
    lines: list[str] = []
    for row in (heads, *cells):
        *fixed, last = (
            cell.rjust(width) if right else cell.ljust(width)
            for cell, width, right in zip(row, widths, to_the_right, strict=True)
        )
        cut = shorten(last.rstrip(), max(room, len(heads[-1])))
        lines.append("  ".join((*fixed, cut)).rstrip())
    return "\n".join(lines)


def _cell(value: object) -> str:
    return f"{value:,}" if isinstance(value, int) else printable(str(value))
