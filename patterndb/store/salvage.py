"""Save what is sound in a damaged database into a new one.

A page that a bad disk spoiled takes its rows with it, and those of other pages with it where
SQLite reads the table from end to end. So rows are sought by their keys, around what cannot be
read. Of what is read, that is saved which can be checked: patterns whose code is the canonical one
of a reduced disk (all else of a pattern follows from it), meshes that keep the schema's rules, and
the occurrences and uses that belong to saved ones. What is not saved is told.
"""

from __future__ import annotations

import contextlib
import sqlite3
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from patterndb.core.patternclass import ORIGINS
from patterndb.core.shortcode import lengthen
from patterndb.errors import DatabaseError, PatternDBError
from patterndb.store import writing
from patterndb.store.checksums import SUMMED, find_changed_tables, sum_tables
from patterndb.store.connection import atomic, connect, connect_unchecked
from patterndb.store.contents import (
    EXAMPLES_AT_ONCE,
    READ_AT_ONCE,
    SHA256_SIZE,
    are_examples_sound,
    describe_sound,
)
from patterndb.store.reading import options_of
from patterndb.store.tallies import tally_anew
from patterndb.system.files import write_beside

#: How often a range of keys in which nothing could be read is halved: rows between two spoiled
#: pages are found where their keys make up a 4096th of the range.
HALVINGS = 12

#: Patterns whose codes are written in one step.
WRITTEN_AT_ONCE = 1000

#: The least and the greatest key that SQLite has.
KEYS = (-(1 << 63), (1 << 63) - 1)

#: The tables of which rows are saved.
TABLES = ("mesh", "pattern", "occurrence", "usage")

#: Values that are not of their column's type or range.
_UNSOUND = (TypeError, ValueError, LookupError, OverflowError, PatternDBError)


def _count_by_table() -> dict[str, Counter[str]]:
    return {table: Counter() for table in TABLES}


@dataclass
class Salvage:
    """What was saved of a damaged database.

    saved:      rows of each table that stand in the new file.
    lost:       of each table, rows that were read and are not sound, by what is wrong.
    unreadable: tables in which some rows could not be read at all.
    changed:    tables whose rows do not add up to their checksum: some were lost or are changed.
    incomplete: names of meshes that lost patches; learning them anew makes them whole.
    """

    saved: dict[str, int] = field(default_factory=dict[str, int])
    lost: dict[str, Counter[str]] = field(default_factory=_count_by_table)
    unreadable: list[str] = field(default_factory=list[str])
    changed: list[str] = field(default_factory=list[str])
    incomplete: list[str] = field(default_factory=list[str])

    @property
    def whole(self) -> bool:
        """Was everything saved?"""
        return not (any(self.lost.values()) or self.unreadable or self.changed or self.incomplete)

    def lose(self, table: str, why: str) -> None:
        """Count a row that is not saved."""
        self.lost[table][why] += 1


def salvage_database(path: Path, into: Path) -> Salvage:
    """Save what is sound in a damaged database into a new file.

    path: read only; it stays as it is. into: must not be there yet; it appears when it is whole,
    and is sound as :meth:`Database.verify` has it.

    Raises DatabaseError if nothing of the file can be read, or ``into`` is there or cannot be
    written.
    """
    if into.exists():
        raise DatabaseError(f"{into} is there already; name a new file")
    found = Salvage()
    with contextlib.closing(connect_unchecked(path)) as source:
        tables = _list_tables(source, path)
        sound = _read_sound(source, tables, found)
        with (
            write_beside(into) as fresh,
            contextlib.closing(connect(fresh, "create")) as target,
            atomic(target),
        ):
            _write(target, sound, found)
        if "checksum" in tables:
            try:
                found.changed = find_changed_tables(source)
            except (sqlite3.DatabaseError, *_UNSOUND):
                # Some of its rows cannot be read, which is told already.
                found.changed = []
    return found


class _SoundPattern(NamedTuple):
    """A pattern whose code is sound: the short code, and what occurrences must fit."""

    code: bytes
    n_quads: int
    chiral: bool


@dataclass(frozen=True)
class _Sound:
    """Rows that may be written, each belonging to others that are.

    meshes: the columns of ``writing.INSERT_MESH`` by id. patterns: by id.
    """

    meshes: dict[int, list[Any]]
    patterns: dict[int, _SoundPattern]
    occurrences: list[tuple[int, int, int, int, bytes]]
    uses: list[tuple[int, int, str]]


def _list_tables(source: sqlite3.Connection, path: Path) -> set[str]:
    try:
        tables = {row[0] for row in source.execute("SELECT name FROM sqlite_schema")}
    except sqlite3.DatabaseError as error:
        raise DatabaseError(
            f"nothing of {path} can be read ({error}); restore it from a copy, or ingest its "
            "meshes anew"
        ) from error
    if not {"mesh", "pattern", "occurrence"} <= tables:
        raise DatabaseError(f"{path} has not the tables of a pattern database")
    columns = {row[1] for row in source.execute("PRAGMA table_info(mesh)")}
    if not set(SUMMED["mesh"].split(", ")) <= columns:
        raise DatabaseError(
            f"{path} has another schema than this patterndb; bring a copy of it to the present "
            "one first: 'patterndb verify --migrate --db COPY'"
        )
    return tables


def _read_sound(source: sqlite3.Connection, tables: set[str], found: Salvage) -> _Sound:
    def read(table: str, columns: str, key: str) -> Iterator[tuple[Any, ...]]:
        rows = _RowsByKey(source, f"SELECT {columns} FROM {table}", key)  # noqa: S608
        yield from rows.read()
        if rows.unreadable:
            found.unreadable.append(table)

    meshes: dict[int, list[Any]] = {}
    for number, *values in read("mesh", f"id, {writing.MESH}", "id"):
        try:
            _check_mesh(values)
        except _UNSOUND as error:
            found.lose("mesh", str(error))
            continue
        if any(values[0] == other[0] for other in meshes.values()):
            found.lose("mesh", "another has the same SHA-256")
        else:
            meshes[number] = values

    patterns: dict[int, _SoundPattern] = {}
    coded = read("pattern", "id, code", "id")
    while some := list(islice(coded, READ_AT_ONCE)):
        for (number, _), told in zip(some, describe_sound([row[1] for row in some]), strict=True):
            if isinstance(told, Exception):
                found.lose("pattern", str(told))
                continue
            expected, (short, _, _, n_quads, _, chiral, _) = told
            if number == expected:
                patterns[number] = _SoundPattern(short, n_quads, bool(chiral))
            else:
                found.lose("pattern", "the id does not follow from the code")

    occurrences: list[tuple[int, int, int, int, bytes]] = []
    columns = "pattern_id, mesh_id, patches, mirrored_patches, example"
    held = read("occurrence", columns, "pattern_id")
    while some := list(islice(held, EXAMPLES_AT_ONCE)):
        whys = [_find_fault(row, meshes, patterns) for row in some]
        for why in filter(None, whys):
            found.lose("occurrence", why)
        belonging = [row for row, why in zip(some, whys, strict=True) if why is None]
        fewest = [_count_fewest(row, meshes, patterns) for row in belonging]
        if are_examples_sound([row[4] for row in belonging], fewest):
            occurrences += belonging  # pyright: ignore[reportArgumentType]
            continue
        for row, least in zip(belonging, fewest, strict=True):
            if are_examples_sound([row[4]], [least]):
                occurrences.append(row)  # pyright: ignore[reportArgumentType]
            else:
                found.lose("occurrence", "its example is none, or has too few quads")

    uses: list[tuple[int, int, str]] = []
    if "usage" in tables:
        for number, count, origin in read("usage", "pattern_id, uses, origin", "pattern_id"):
            if number in patterns and type(count) is int and count >= 1 and origin in ORIGINS:
                uses.append((number, count, origin))
            else:
                found.lose("usage", "of no pattern that was saved, or no count of uses")
    return _Sound(meshes, patterns, occurrences, uses)


def _check_mesh(values: list[Any]) -> None:
    """Check that the columns of a mesh can be such. Raises one of _UNSOUND where they cannot."""
    sha256, name, *said = values[:5]
    options = writing.pick_options(values)
    counts = values[9:15]
    if type(sha256) is not bytes or len(sha256) != SHA256_SIZE:
        raise ValueError("no SHA-256")
    if type(name) is not str or not name or any(type(x) not in (str, type(None)) for x in said):
        raise TypeError("no name, or no text where texts belong")
    if any(type(x) is not int or x < 0 for x in (*options, *counts, values[17])):
        raise TypeError("no count where counts belong")
    options_of(*options)
    if values[15] not in ("learned", "imported"):
        raise ValueError("neither learned nor imported")
    if counts[0] < counts[1]:
        raise ValueError("more quads used than read")


def _find_fault(
    row: tuple[Any, ...], meshes: dict[int, list[Any]], patterns: dict[int, _SoundPattern]
) -> str | None:
    """What is wrong with an occurrence but for its example, in words; None where nothing is."""
    number, mesh_id, patches, mirrored, _ = row
    pattern = patterns.get(number)
    if pattern is None:
        return "its pattern is not saved"
    if mesh_id not in meshes:
        return "its mesh is not saved"
    if type(patches) is not int or type(mirrored) is not int or not 0 <= mirrored <= patches:
        return "no counts of patches"
    if patches < 1 or (mirrored and not pattern.chiral):
        return "no patches, or mirrored ones of a pattern that is its own mirror image"
    return None


def _count_fewest(
    row: tuple[Any, ...], meshes: dict[int, list[Any]], patterns: dict[int, _SoundPattern]
) -> int:
    """Quads that the example of an occurrence has at least: those of its pattern, if learned."""
    return patterns[row[0]].n_quads if meshes[row[1]][15] == "learned" else 0


def _write(target: sqlite3.Connection, sound: _Sound, found: Salvage) -> None:
    """Write all of it; what the new file's rules refuse is told."""
    numbers = list(sound.patterns)
    held = {row[0] for row in (*sound.occurrences, *sound.uses)}
    for number in numbers:
        if number not in held:
            found.lose("pattern", "no mesh that is saved has it, and it was never used")
    patches: Counter[int] = Counter()
    for _, mesh_id, count, *_ in sound.occurrences:
        patches[mesh_id] += count
    for mesh_id, values in sound.meshes.items():
        distinct, modes = patches[mesh_id], values[11:14]
        # Each pattern that was left out has a patch at least.
        is_cut = values[17] > 0 and distinct + values[17] <= values[14]
        whole = is_cut or values[14] == distinct
        if not whole or not max(modes) <= values[14] <= sum(modes):
            found.incomplete.append(values[1])
            values[11:15] = *_fit_modes(modes, distinct), distinct
            values[17] = 0
        target.execute(writing.INSERT_MESH_WITH_ID, (mesh_id, *values))
    kept = [number for number in numbers if number in held]
    for at in range(0, len(kept), WRITTEN_AT_ONCE):
        some = kept[at : at + WRITTEN_AT_ONCE]
        codes = lengthen([sound.patterns[number].code for number in some])
        writing.add_patterns(target, some, codes)
    target.executemany(writing.INSERT_OCCURRENCE, sound.occurrences)
    target.executemany("INSERT INTO usage (pattern_id, uses, origin) VALUES (?, ?, ?)", sound.uses)
    # As the database keeps it: what it was used as, where no mesh has it.
    target.execute(
        "UPDATE pattern SET origin = (SELECT origin FROM usage WHERE pattern_id = pattern.id) "
        "WHERE frequency = 0"
    )
    sum_tables(target)
    tally_anew(target)
    found.saved = {
        "mesh": len(sound.meshes),
        "pattern": len(kept),
        "occurrence": len(sound.occurrences),
        "usage": len(sound.uses),
    }


def _fit_modes(modes: list[int], distinct: int) -> list[int]:
    """Counts of patches by modes that so many distinct ones can have."""
    modes = [min(count, distinct) for count in modes]
    # Each is found by one mode or more.
    return modes if sum(modes) >= distinct else [distinct, *modes[1:]]


class _RowsByKey:
    """The rows of a table by its key, around those that cannot be read.

    unreadable: were there such? Known once all were read.
    """

    def __init__(self, source: sqlite3.Connection, select: str, key: str) -> None:
        self.unreadable = False
        self._source = source
        self._select = select
        self._key = key
        self._seen: set[tuple[Any, ...]] = set()

    def read(self) -> Iterator[tuple[Any, ...]]:
        """Read them, each once."""
        yield from self._read(*KEYS, HALVINGS)

    def _read(self, low: int, high: int, halvings: int) -> Iterator[tuple[Any, ...]]:
        """The rows with keys from low to high, from both ends to what cannot be read, and in the
        halves of what lies between."""
        before = low
        for row in self._read_until_fault(low, high, "ASC"):
            if row is None:
                break
            low = max(low, row[0])
            yield from self._pass_on(row)
        else:
            return
        self.unreadable = True
        progress = low > before
        top = high
        for row in self._read_until_fault(low, high, "DESC"):
            if row is None:
                break
            top = min(top, row[0])
            yield from self._pass_on(row)
        progress = progress or top < high
        # A range in which something could be read is worth as many halvings as before.
        left = halvings if progress else halvings - 1
        if left <= 0 or top - low < 2:
            return
        middle = (low + top) // 2
        yield from self._read(low, middle, left)
        yield from self._read(middle + 1, top, left)

    def _read_until_fault(
        self, low: int, high: int, direction: str
    ) -> Iterator[tuple[Any, ...] | None]:
        """The rows of a range in order, and None where one cannot be read."""
        statement = (
            f"{self._select} WHERE {self._key} BETWEEN ? AND ? ORDER BY {self._key} {direction}"
        )
        try:
            yield from self._source.execute(statement, (low, high))
        except sqlite3.DatabaseError:
            yield None

    def _pass_on(self, row: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
        try:
            fresh = row[:2] not in self._seen
        except TypeError:
            return
        if fresh:
            self._seen.add(row[:2])
            yield row
