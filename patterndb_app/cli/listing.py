"""The verbs that give patterns away: list, export."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from patterndb.errors import NotFoundError, PatternDBError, TimeLimitError
from patterndb.system.deadline import refuse_if_late
from patterndb.system.files import replace_file
from patterndb_app.cli.options import (
    Count,
    DatabaseChoice,
    FileName,
    as_json,
    dbs_to_read,
    limit_command,
    list_flags,
    may_overwrite,
    open_database,
    read_options,
    request_options,
    time_limit_option,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.text import plural, say, table, tell_left_over, write, write_json_with
from query.request import PatternRequest, choose_patterns

if TYPE_CHECKING:
    from patterndb.core.pattern import Pattern
    from patterndb.store import Database, DatabaseUnion


@dataclass(frozen=True, slots=True)
class ListedPattern:
    """A pattern, and what the database knows of it beside its frequency.

    meshes: in how many it occurs. uses: accepted fills that were recorded.
    """

    pattern: Pattern
    meshes: int
    uses: int

    def to_json(self) -> dict[str, object]:
        """The pattern as JSON takes it."""
        return {**self.pattern.to_json(), "meshes": self.meshes, "uses": self.uses}


#: The section of the help that the options which choose patterns are in.
CHOICE_OPTIONS = list_flags(PatternRequest, "filter")


def list_chosen(
    database: Database | DatabaseUnion, request: PatternRequest
) -> Iterator[ListedPattern]:
    """Yield patterns by class, the fewest irregular vertices first, then the most frequent."""
    for held, rows in choose_patterns(database, request):
        for row in rows.tolist():
            yield ListedPattern(held.pattern(row), int(held.n_meshes[row]), int(held.uses[row]))


@click.command(
    "list",
    cls=SectionedCommand,
    sections={
        "Which patterns": (*CHOICE_OPTIONS, "--limit"),
        "How": ("--db", "--time-limit", "--json"),
    },
)
@request_options(PatternRequest)
@click.option(
    "--limit",
    type=Count(1),
    default=20,
    show_default=True,
    metavar="N",
    help="List at most N.",
)
@dbs_to_read
@time_limit_option
@as_json
def list_(
    limit: int, db: DatabaseChoice, time_limit: float | None, as_json: bool, **choice: Any
) -> int:
    """List patterns of a database: sides, irregular vertices, and how often they were seen.

    Class by class, the fewest irregular vertices first, then the most frequent.

    \b
    patterndb list --class 5 --convex
    patterndb list --max-irregular 1 --limit 100 --db my.db --json
    """
    with limit_command(time_limit), open_database(db) as database:
        request = PatternRequest(**read_options(PatternRequest, choice))
        chosen = PatternListing(database, request, limit)
        if as_json:
            first = next(chosen, None)
            if first is None:
                raise chosen.say_none()
            documents = (one.to_json() for one in chain((first,), chosen))
            write_json_with({}, "patterns", documents, chosen.to_json)
            return 0
        listed = list(chosen)
    if not listed:
        raise chosen.say_none()
    heads = ("pattern", "sides", "irregular", "quads", "origin", "seen", "meshes", "valences")
    rows = [
        (
            one.pattern.name,
            one.pattern.n_sides,
            one.pattern.n_irregular,
            one.pattern.n_quads,
            one.pattern.origin,
            one.pattern.frequency,
            one.meshes,
            " ".join(map(str, one.pattern.valences)) or "-",
        )
        for one in listed
    ]
    write(table(heads, rows))
    if not chosen.complete:
        say("the time limit was over, so that there may be more patterns than these")
    elif chosen.truncated:
        say("there are more patterns than these (--limit)")
    return 0


class PatternListing(Iterator[ListedPattern]):
    """The chosen patterns of a database, one after another.

    truncated: are there more than ``limit``? complete: False where the time limit ended the list.
    """

    def __init__(
        self, database: Database | DatabaseUnion, request: PatternRequest, limit: int | None
    ) -> None:
        self.truncated = False
        self.complete = True
        self._source = self._list(database, request, limit)

    def __next__(self) -> ListedPattern:
        return next(self._source)

    def _list(
        self, database: Database | DatabaseUnion, request: PatternRequest, limit: int | None
    ) -> Iterator[ListedPattern]:
        try:
            for count, one in enumerate(list_chosen(database, request)):
                if count == limit:
                    self.truncated = True
                    return
                yield one
                refuse_if_late("all patterns were listed")
        except TimeLimitError:
            self.complete = False

    def to_json(self) -> dict[str, object]:
        """What is known at the end of the list."""
        return {"truncated": self.truncated or not self.complete, "complete": self.complete}

    def say_none(self) -> PatternDBError:
        """The error where nothing was listed."""
        if self.complete:
            return NotFoundError("the database has no such pattern")
        return TimeLimitError(
            "the time limit was over before the first such pattern was found, so that there may be "
            "one; allow more seconds"
        )


@click.command(
    "export",
    cls=SectionedCommand,
    sections={
        "Which patterns": (*CHOICE_OPTIONS, "--limit"),
        "How": ("--db", "--overwrite", "--time-limit"),
    },
)
@click.argument("output", metavar="OUTPUT", type=FileName(reads=False, writes=True))
@request_options(PatternRequest)
@click.option("--limit", type=Count(1), metavar="N", help="Write at most N.")
@dbs_to_read
@may_overwrite
@time_limit_option
def export(
    output: Path,
    limit: int | None,
    db: DatabaseChoice,
    time_limit: float | None,
    **choice: Any,
) -> int:
    """Write patterns of a database for other programs.

    OUTPUT says how by its suffix: .jsonl for a JSON document a line, with the quads; .csv for a
    table without them; without a suffix it is a folder, for an OBJ file of each, flat. What
    another program of this kind reads is written by 'patterndb export-ddq'.

    \b
    patterndb export five.jsonl --class 5
    patterndb export patterns.csv --db my.db
    patterndb export five/ --class 5 --convex --limit 50
    """
    write_patterns = EXPORTS.get(output.suffix.lower())
    if write_patterns is None:
        known = ", ".join(suffix for suffix in EXPORTS if suffix)
        raise click.BadParameter(
            f"{output} ends in {output.suffix}; patterns are written as {known}, or into a folder",
            param_hint="'OUTPUT'",
        )
    if output.suffix and not output.absolute().parent.is_dir():
        raise click.BadParameter(
            f"there is no folder {output.parent} to write into", param_hint="'OUTPUT'"
        )
    with limit_command(time_limit), open_database(db) as database:
        request = PatternRequest(**read_options(PatternRequest, choice))
        chosen = PatternListing(database, request, limit)
        first = next(chosen, None)
        if first is None:
            raise chosen.say_none()
        count = write_patterns(output, chain((first,), chosen))
    say(f"written: {plural(count, 'pattern')} in {output}")
    if not chosen.complete:
        say("the time limit was over, so that there may be more patterns than these")
    return 0


def export_lines(path: Path, patterns: Iterator[ListedPattern]) -> int:
    """Write a JSON document a line; return how many."""
    lines = [json.dumps(one.to_json(), separators=(",", ":")) for one in patterns]
    replace_file(path, "\n".join((*lines, "")))
    return len(lines)


def export_table(path: Path, patterns: Iterator[ListedPattern]) -> int:
    """Write a table without the quads; return how many rows.

    Lists are numbers with spaces between, the sides of a label with ``|`` between.
    """
    held = io.StringIO(newline="")
    rows = csv.writer(held, lineterminator="\n")
    count = 0
    for count, one in enumerate(patterns, 1):
        document = one.to_json()
        del document["quads"]
        document["corners"] = " ".join(map(str, one.pattern.corners))
        document["valences"] = " ".join(map(str, one.pattern.valences))
        document["label"] = "|".join(" ".join(map(str, side)) for side in one.pattern.label)
        if count == 1:
            rows.writerow(document)
        rows.writerow(
            int(value) if isinstance(value, bool) else value for value in document.values()
        )
    replace_file(path, held.getvalue())
    return count


def export_folder(folder: Path, patterns: Iterator[ListedPattern]) -> int:
    """Write a flat OBJ file of each pattern into a folder, named by the pattern."""
    from patterndb_app.cli.obj import write_flat_disk

    if folder.exists() and not folder.is_dir():
        raise click.BadParameter(f"{folder} is a file; name a folder", param_hint="'OUTPUT'")
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for one in patterns:
        path = folder / f"{one.pattern.name}.obj"
        written.append(path)
        seen = f"seen in {plural(one.pattern.frequency, 'patch', 'patches')}"
        comments = (f"pattern {one.pattern.name}, {plural(one.pattern.n_sides, 'side')}", seen)
        write_flat_disk(path, one.pattern.disk(), comments)
    tell_left_over(folder, "*.obj", written)
    return len(written)


#: What writes patterns, by the suffix of the output; the folder has none.
EXPORTS: dict[str, Callable[[Path, Iterator[ListedPattern]], int]] = {
    ".jsonl": export_lines,
    ".csv": export_table,
    "": export_folder,
}
