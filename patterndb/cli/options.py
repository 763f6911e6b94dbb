"""What several verbs share: options, and how results are written."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

import patterndb
from patterndb.store import Database
from patterndb.store.connection import Mode

F = TypeVar("F", bound=Callable[..., Any])

db_to_read: Callable[[F], F] = click.option(
    "--db",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="The database to ask; the starter database if not given.",
)

db_to_write: Callable[[F], F] = click.option(
    "--db",
    type=click.Path(path_type=Path),
    metavar="FILE",
    required=True,
    help="The database to change.",
)

as_json: Callable[[F], F] = click.option(
    "--json", "as_json", is_flag=True, help="Write one JSON document to stdout."
)


def open_database(path: Path | None, mode: Mode = "read") -> Database:
    """The database named by --db, or the starter."""
    return patterndb.open(path, mode, say=lambda text: click.echo(text, err=True))


def write_json(document: object) -> None:
    """One JSON document on one line of stdout."""
    click.echo(json.dumps(document, separators=(",", ":"), ensure_ascii=False))


class Numbers(click.ParamType):
    """Whole numbers with commas between: 3,5,4,6."""

    name = "n,n,..."

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, ...]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        parts = [part.strip() for part in str(value).split(",")]
        if not all(re.fullmatch(r"-?\d{1,9}", part) for part in parts):
            self.fail(f"{value!r} is not a list of whole numbers like 3,5,4,6", param, ctx)
        return tuple(int(part) for part in parts)


class Range(click.ParamType):
    """Two whole numbers: 3..5; one number means from it to itself."""

    name = "a..b"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        match = re.fullmatch(r"(\d{1,4})(?:\.\.(\d{1,4}))?", str(value).strip())
        if not match:
            self.fail(f"{value!r} is not a range like 3..5", param, ctx)
        low = int(match[1])
        high = int(match[2] or match[1])
        if low > high:
            self.fail(f"the range {value} runs backwards", param, ctx)
        return low, high


def picture_path(*suffixes: str) -> click.ParamType:
    """A file to draw into, with one of the suffixes."""

    class Picture(click.ParamType):
        name = "file"

        def convert(
            self, value: Any, param: click.Parameter | None, ctx: click.Context | None
        ) -> Path:
            path = Path(value)
            if path.suffix.lower() not in suffixes:
                self.fail(f"{value} must end in {' or '.join(suffixes)}", param, ctx)
            if not path.absolute().parent.is_dir():
                self.fail(f"there is no folder {path.parent} to draw into", param, ctx)
            return path

    return Picture()
