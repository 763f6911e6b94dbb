"""A class of patterns as arrays: out of the database, the cache folder, or a block of a few bytes.

:func:`load_class` reads and checks every row: SQLite checks types on writing, but a damaged or a
foreign file was not written by us. :func:`read_class` keeps what that makes of a large class in the
cache folder, where its arrays are mapped (:mod:`patterndb.system.mappedarrays`), under the path and
the content key (:func:`patterndb.store.reading.read_content_key`) of the database. How often
patterns were used is not kept: it changes with every accepted fill, and is read each time. Handles
of one process that ask for the same class share one.

A class has one format, the arrays that :func:`list_arrays` names. The cache folder holds all of
them as they are; :func:`dump_class` leaves out what follows from the rest, orders rows so that
neighbours are alike, packs and compresses: a query has it in milliseconds without a database.
"""

from __future__ import annotations

import json
import lzma
import sqlite3
from collections.abc import Generator, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from patterndb.core import description as d
from patterndb.core.code import format_id, pattern_id
from patterndb.core.label import join_matrices
from patterndb.core.packing import PackedRows, pack, take_stretches, unpack
from patterndb.core.patternclass import ORIGINS, ClassPart, PatternClass, number_rows, shrink
from patterndb.core.shortcode import pack_symbols, restore
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store.reading import get_id_range, read_content_key
from patterndb.system.mappedarrays import ArrayCache
from patterndb.system.memory import return_freed_memory
from patterndb.system.progress import report_progress

#: The largest number of a column that becomes 32 bits.
MOST_32 = 2**31 - 1
#: The largest number that SQLite holds.
MOST_64 = 2**63 - 1


#: Columns of a pattern that follow from its code, and where its description tells them.
FOLLOWING = {
    "n_reflex": d.N_REFLEX,
    "n_quads": d.N_QUADS,
    "n_irregular": d.N_IRREGULAR,
    "chiral": d.CHIRAL,
}


def load_class(connection: sqlite3.Connection, n_sides: int) -> PatternClass:
    """All patterns of ``n_sides`` sides, in default order.

    All but the counts is made of the codes, so that nothing is indexed by what was read. Raises
    DatabaseError, which names pattern and column, where a code is not the canonical one of a disk
    of so many sides, or a column does not follow from it or holds what it cannot.
    """
    return PatternClass.from_parts(n_sides, _read_parts(connection, n_sides))


#: Patterns of a class that are read and described at a time: some ten megabytes.
READ_AT_ONCE = 10_000


class _ClassColumns(NamedTuple):
    """Columns of some patterns as the view counted_pattern has them, each with p values."""

    id: Sequence[int]
    code: Sequence[bytes]
    frequency: Sequence[int]
    n_meshes: Sequence[int]
    uses: Sequence[int]
    origin: Sequence[str]
    n_reflex: Sequence[int]
    n_quads: Sequence[int]
    n_irregular: Sequence[int]
    chiral: Sequence[int]


_SELECT_CLASS = (
    f"SELECT {', '.join(_ClassColumns._fields)} FROM counted_pattern "  # noqa: S608
    "WHERE id BETWEEN ? AND ? AND n_sides = ? ORDER BY id"
)


def _read_parts(connection: sqlite3.Connection, n_sides: int) -> Generator[ClassPart]:
    """Read the patterns of a class part by part; the next is read while one is described."""
    low, high = get_id_range(n_sides)
    cursor = connection.execute(_SELECT_CLASS, (low, high, n_sides))
    with (
        ThreadPoolExecutor(1, "patterndb-reading") as pool,
        report_progress(f"reading the patterns of {n_sides} sides, once") as report,
    ):
        ahead: Future[ClassPart] | None = None
        last: int | None = None
        while rows := cursor.fetchmany(READ_AT_ONCE):
            reject_disorder([row[0] for row in rows], last)
            last = rows[-1][0]
            one, ahead = ahead, pool.submit(_make_part, n_sides, rows)
            if one is not None:
                yield one.result()
            # Ids are hashes, and so evenly spread.
            report((rows[-1][0] - low) / (high - low))
        # SQLite's own copy of the pages is of no use to the next question.
        connection.execute("PRAGMA shrink_memory")
        if ahead is not None:
            yield ahead.result()


def _make_part(n_sides: int, rows: list[tuple[Any, ...]]) -> ClassPart:
    """Check rows of :data:`_SELECT_CLASS`, and describe their codes."""
    held = _ClassColumns._make(zip(*rows, strict=True))
    ids = held.id
    if not set(map(type, held.code)) <= {bytes}:
        at = next(i for i, code in enumerate(held.code) if type(code) is not bytes)
        raise report_damage(ids[at], "code", f"is {_shorten(held.code[at])}, not bytes")
    frequency = _read_numbers(ids, "frequency", held.frequency, MOST_64)
    uses = _read_numbers(ids, "uses", held.uses, MOST_64)
    n_meshes = _read_numbers(ids, "occurrences", held.n_meshes, MOST_32)
    number_of = {name: number for number, name in enumerate(ORIGINS)}
    origin = np.array([number_of.get(name, -1) for name in held.origin], np.int8)
    _reject(ids, "origin", origin < 0, f"is not one of {', '.join(ORIGINS)}")
    try:
        symbols, offsets = restore(held.code)
        described = d.describe_symbols(symbols, offsets)
    except InvalidCodeError as error:
        assert error.row is not None
        raise report_damage(ids[error.row], "code", f"is damaged ({error})") from error
    wrong = described.counts[:, d.N_CORNERS] != n_sides
    _reject(ids, "code", wrong, f"does not have {n_sides} sides")
    for name, at in FOLLOWING.items():
        stored = _read_numbers(ids, name, getattr(held, name), MOST_32)
        _reject(ids, name, stored != described.counts[:, at], "does not follow from its code")
    return ClassPart(
        pack_symbols(symbols, offsets),
        described,
        ids=np.array(ids, np.int64),
        frequency=frequency,
        n_meshes=n_meshes.astype(np.int32),
        uses=uses,
        origin=origin,
    )


def _reject(ids: Sequence[int], column: str, wrong: NDArray[np.bool_], why: str) -> None:
    if wrong.any():
        raise report_damage(ids[int(wrong.argmax())], column, why)


def report_damage(pattern_id: int, column: str, why: str) -> DatabaseError:
    """Return the error for a wrong value in a pattern's row."""
    return DatabaseError(
        f"pattern {format_id(pattern_id)} is damaged: {column} {why}; "
        "'patterndb verify' reports what is wrong with the whole file"
    )


def _read_numbers(
    ids: Sequence[int], column: str, values: Sequence[Any], high: int
) -> NDArray[np.int64]:
    """(p,) int64 a column of numbers in ``0..high``. Raises DatabaseError for others."""
    if set(map(type, values)) <= {int}:
        numbers = np.array(values, np.int64)
        wrong = np.flatnonzero((numbers < 0) | (numbers > high))
        if not len(wrong):
            return numbers
        at = int(wrong[0])
    else:
        at = next(i for i, value in enumerate(values) if type(value) is not int)
    raise report_damage(
        ids[at], column, f"is {_shorten(values[at])}, not a whole number of 0..{high}"
    )


def reject_disorder(ids: Iterable[int], last: int | None = None) -> None:
    """Raise DatabaseError unless the ids ascend, and all come after ``last``."""
    for number in ids:
        if last is not None and number <= last:
            raise DatabaseError(
                f"the table of patterns is damaged: pattern {format_id(number)} stands after "
                f"{format_id(last)}; 'patterndb verify' reports what is wrong with the whole file"
            )
        last = number


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:39] + "…"


#: What arrays of a class are kept as; changed whenever what they hold is.
FORMAT = "class-3"

#: Patterns from which on a class is kept: a smaller one loads in some tenth of a second.
LEAST_KEPT = 4096

#: What a class has that is not an array, or is not kept.
_APART = {"n_sides", "uses", "codes", "cache", "tables"}
_FIELDS: list[str] = [field.name for field in fields(PatternClass) if field.name not in _APART]

#: Arrays that have no row for each pattern, or stretches of rows.
_FLAT = {"words", "word_start", "lengths", "joins"}

#: Arrays that follow from the others, and are not in a block.
_DERIVED = ("ids", "lengths", "joins")

#: The mapped classes of this process, with what was made of them, by the files that they are in.
_MAPPED: WeakValueDictionary[tuple[ArrayCache, int], PatternClass] = WeakValueDictionary()


def list_arrays(patterns: PatternClass) -> dict[str, NDArray[Any]]:
    """Return the arrays of a class by name, uses aside: the codes as bytes with their ends."""
    codes = PackedRows.of(patterns.codes)
    held = {name: getattr(patterns, name) for name in _FIELDS}
    return held | {"code_bytes": codes.raw, "code_ends": codes.ends}


def _make_class(
    n_sides: int,
    arrays: Mapping[str, NDArray[Any]],
    uses: NDArray[np.int64],
    cache: ArrayCache | None = None,
) -> PatternClass:
    """Make the class of the arrays of :func:`list_arrays`."""
    return PatternClass(
        n_sides=n_sides,
        uses=uses,
        codes=PackedRows(arrays["code_bytes"], arrays["code_ends"]),
        cache=cache,
        **{name: arrays[name] for name in _FIELDS},  # pyright: ignore[reportArgumentType]
    )


def _take(arrays: Mapping[str, NDArray[Any]], rows: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    """The arrays of the patterns in these rows alone, in this order; of signatures nothing."""
    taken: dict[str, NDArray[Any]] = {}
    for name, array in arrays.items():
        if name not in _FLAT and not name.startswith("code_"):
            taken[name] = array[rows]
    codes = PackedRows(arrays["code_bytes"], arrays["code_ends"]).take(rows)
    starts = arrays["word_start"][:-1][rows]
    sizes = np.diff(arrays["word_start"])[rows]
    return taken | {
        "code_bytes": codes.raw,
        "code_ends": codes.ends,
        "words": take_stretches(arrays["words"], starts, sizes),
        "word_start": _sum_sizes(sizes),
    }


def _sum_sizes(sizes: NDArray[np.integer]) -> NDArray[np.int64]:
    return np.cumsum(np.r_[0, sizes], dtype=np.int64)


# The cache folder


def read_class(connection: sqlite3.Connection, path: Path, n_sides: int) -> PatternClass:
    """Return the class, as :func:`load_class` loads it.

    One that is mapped already, else mapped from the cache folder where its arrays are kept and of
    this content, else loaded, and kept if it is large.
    """
    what = f"{n_sides}-{FORMAT}"
    cache = _find_cache(connection, path, n_sides)
    mapped = None if cache is None else _MAPPED.get((cache, n_sides))
    if mapped is not None and np.array_equal(
        mapped.uses, _read_uses(connection, n_sides, mapped.ids)
    ):
        return mapped
    arrays = None if cache is None else cache.find(what)
    if arrays is None:
        loaded = load_class(connection, n_sides)
        if cache is None or len(loaded) < LEAST_KEPT:
            return loaded
        # What another program wrote in between would be kept under what was there before.
        if _find_cache(connection, path, n_sides) != cache or not cache.keep(
            what, list_arrays(loaded)
        ):
            return loaded
        # A large class has its arrays in memory once, not beside those that are mapped.
        del loaded
        return_freed_memory()
        arrays = cache.find(what)
        if arrays is None:  # another process has replaced it
            return load_class(connection, n_sides)
    assert cache is not None
    made = _make_class(n_sides, arrays, _read_uses(connection, n_sides, arrays["ids"]), cache)
    _MAPPED[cache, n_sides] = made
    return made


def _find_cache(connection: sqlite3.Connection, path: Path, n_sides: int) -> ArrayCache | None:
    """Where arrays of a class are kept; None while a change is underway, which may never be
    committed."""
    if connection.in_transaction:
        return None
    return ArrayCache(str(path.resolve()), read_content_key(connection, n_sides))


def _read_uses(
    connection: sqlite3.Connection, n_sides: int, ids: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(p,) int64 how often the patterns of these ids were used."""
    used = dict(
        connection.execute(
            "SELECT pattern_id, uses FROM usage WHERE pattern_id BETWEEN ? AND ?",
            get_id_range(n_sides),
        ).fetchall()
    )
    uses = np.zeros(len(ids), np.int64)
    if used:
        for row in np.flatnonzero(np.isin(ids, np.array(list(used), np.int64))).tolist():
            uses[row] = used[int(ids[row])]
    return uses


# Blocks


def dump_block(arrays: Mapping[str, NDArray[Any]], rows: object = None) -> bytes:
    """Compress arrays of integers, none negative, with what JSON holds of ``rows``.

    Bytes stay as they are, other numbers are packed. The block is xz of a line of JSON, with the
    name, the type and the number of bytes of every array, and of these.
    """
    told: list[tuple[str, str, int]] = []
    parts: list[bytes] = []
    for name, array in arrays.items():
        flat = array.ravel()
        parts.append(flat.tobytes() if flat.dtype.itemsize == 1 else pack(flat))
        told.append((name, flat.dtype.str, len(parts[-1])))
    line = json.dumps({"arrays": told, "rows": rows}, ensure_ascii=False).encode() + b"\n"
    return lzma.compress(line + b"".join(parts), preset=9)


def parse_block(block: bytes) -> tuple[dict[str, NDArray[Any]], Any]:
    """Return the arrays of a block, each flat, and its rows. Raises DatabaseError where it is
    damaged."""
    try:
        line, found, body = lzma.decompress(block).partition(b"\n")
        told = json.loads(line)
        arrays: dict[str, NDArray[Any]] = {}
        end = 0
        for name, kind, size in told["arrays"]:
            dtype, begin, end = np.dtype(kind), end, end + size
            part = body[begin:end]
            packed = np.frombuffer(part, dtype) if dtype.itemsize == 1 else unpack(part)
            arrays[name] = packed.astype(dtype, copy=False)
        if not found or end != len(body):
            raise ValueError("it is cut short")
        return arrays, told["rows"]
    except (lzma.LZMAError, EOFError, ValueError, TypeError, KeyError) as error:
        raise DatabaseError(f"a block of the compact database is damaged ({error})") from error


def dump_class(patterns: PatternClass) -> tuple[NDArray[np.int64], bytes]:
    """Return the block of the patterns of a class that occur in meshes, without uses, and their
    ids in its order: by length of code, and code."""
    met = np.flatnonzero(patterns.frequency > 0)
    codes: list[bytes] = [patterns.codes[row] for row in met.tolist()]
    order = sorted(range(len(codes)), key=lambda i: (len(codes[i]), codes[i]))
    rows = met[np.array(order, np.int64)]
    arrays = _take(list_arrays(patterns), rows)
    arrays["signature"] = number_rows(arrays["signature"][:, None])[0]
    for name in ("code_ends", "word_start"):
        arrays[name] = np.diff(arrays[name])
    for name in _DERIVED:
        arrays.pop(name, None)
    return patterns.ids[rows], dump_block(arrays)


def parse_class(n_sides: int, block: bytes) -> PatternClass:
    """Return the class of a block, in default order, as :func:`load_class` loads it from a database
    of the same. Raises DatabaseError where it is damaged."""
    arrays, _ = parse_block(block)
    try:
        return _derive_class(n_sides, arrays)
    except (ValueError, IndexError, KeyError) as error:
        raise DatabaseError(f"the class of {n_sides} sides is damaged ({error})") from error


def parse_codes(block: bytes) -> list[bytes]:
    """Return the packed codes of a block of a class, in its order."""
    arrays, _ = parse_block(block)
    return PackedRows(arrays["code_bytes"], _sum_sizes(arrays["code_ends"]))[:]


def _derive_class(n_sides: int, arrays: dict[str, NDArray[Any]]) -> PatternClass:
    """Make the class of a block's arrays: what was left out follows from them."""
    for name in ("code_ends", "word_start"):
        arrays[name] = _sum_sizes(arrays[name])
    codes = PackedRows(arrays["code_bytes"], arrays["code_ends"])
    arrays["ids"] = np.array([pattern_id(code, n_sides) for code in codes], np.int64)
    arrays["corners"] = arrays["corners"].reshape(len(codes), n_sides)
    order = np.lexsort((arrays["ids"], -arrays["frequency"], arrays["n_irregular"]))
    arrays = _take(arrays, order)
    arrays["signature"], first = number_rows(arrays["signature"][:, None])
    starts, sizes = arrays["word_start"][:-1][first], np.diff(arrays["word_start"])[first]
    lengths, joins = _join_sides(
        n_sides,
        take_stretches(arrays["words"], starts, sizes),
        _sum_sizes(sizes),
        arrays["rotation"][first],
        arrays["reflected"][first],
    )
    arrays |= {"lengths": shrink(lengths), "joins": shrink(joins)}
    return _make_class(n_sides, arrays, np.zeros(len(codes), np.int64))


def _join_sides(
    n_sides: int,
    words: NDArray[np.int16],
    starts: NDArray[np.int64],
    rotation: NDArray[np.int32],
    reflected: NDArray[np.bool_],
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Lengths and n_ij of signatures, of labels (words) that read as these from the side
    ``rotation``, backwards where ``reflected``."""
    n = len(rotation)
    width = max(n_sides, 1)
    sizes = np.empty((n, width), np.int32)
    is_edge = np.ones(len(words), np.bool_)
    at = starts[:-1].copy()
    for k in range(width):
        is_edge[at] = False
        sizes[:, k] = words[at]
        at += 1 + sizes[:, k]
    # Side s of a label is this side of its signature.
    label_sides = np.arange(width)
    turned = np.where(reflected, -1, 1)[:, None] * (label_sides - rotation[:, None])
    side = turned % width
    lengths = np.empty_like(sizes)
    np.put_along_axis(lengths, side, sizes, axis=1)
    # The two edges that a polychord crosses have one number: sorted by it, they are neighbours.
    owner = np.repeat(np.arange(n), sizes.sum(axis=1))
    sides = np.repeat(side.ravel(), sizes.ravel())
    both = np.lexsort((words[is_edge], owner)).reshape(-1, 2)
    return lengths, join_matrices(n_sides, sides[both], owner[both[:, 0]], n)
