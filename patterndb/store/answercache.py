"""Answers that take a look at every row, kept in the user's cache folder: statistics.

A million patterns take a while to count. What took long is kept, under the
database's path and its content's key (:mod:`patterndb.store.contentkey`), and is had at once until
something is learned or removed. Of a database the last answers are kept.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

from patterndb.store.contentkey import read_content_key
from patterndb.store.contents import hash_content
from patterndb.store.records import Statistics
from patterndb.store.statistics import count_by_sides, read_statistics
from patterndb.system.caches import read_cached, write_cached

#: Changed whenever what is kept has another form or meaning.
FORMAT = "answers-1"

#: Seconds that an answer must have taken to be kept.
LEAST_SECONDS = 0.3

_DIGEST_BYTES = 32

#: What of statistics is counted by number.
_COUNTS = ("by_sides", "by_irregular")


def find_statistics(connection: sqlite3.Connection, path: Path) -> Statistics:
    """The statistics, as :func:`patterndb.store.statistics.read_statistics` gives them."""

    def ask(connection: sqlite3.Connection) -> dict[str, Any]:
        told = read_statistics(connection, hash_content(connection))
        # JSON has no numbers as keys.
        return asdict(told) | {name: list(getattr(told, name).items()) for name in _COUNTS}

    told = cast("dict[str, Any]", _find_or_ask(connection, path, "statistics", ask))
    told |= {name: dict(told[name]) for name in _COUNTS}
    return Statistics(**told)


def find_sides_histogram(connection: sqlite3.Connection, path: Path) -> dict[int, int]:
    """The number of patterns by number of sides."""
    pairs = _find_or_ask(connection, path, "sides", lambda c: list(count_by_sides(c).items()))
    return {int(n): int(count) for n, count in cast("list[list[int]]", pairs)}


def _find_or_ask(
    connection: sqlite3.Connection,
    path: Path,
    what: str,
    ask: Callable[[sqlite3.Connection], object],
) -> object:
    """An answer, as JSON may hold it: kept, or asked, and kept if that took long."""
    # What is read within a change may never be committed.
    key = None if connection.in_transaction else read_content_key(connection)
    if key is None:
        return ask(connection)
    source = hashlib.blake2b(str(path.resolve()).encode("utf-8", "surrogateescape"), digest_size=12)
    name = f"{source.hexdigest()}-{what}-{FORMAT}.json"
    kept = _parse(read_cached(name), [str(path.resolve()), what, key])
    if kept is not None:
        return kept
    begun = time.perf_counter()
    answer = ask(connection)
    if time.perf_counter() - begun >= LEAST_SECONDS and read_content_key(connection) == key:
        body = json.dumps([[str(path.resolve()), what, key], answer]).encode()
        write_cached(name, _digest(body) + body)
    return answer


def _parse(data: bytes | None, key: list[str]) -> object | None:
    """The answer in a file; None where it is not whole, or of another key."""
    if data is None or _digest(data[_DIGEST_BYTES:]) != data[:_DIGEST_BYTES]:
        return None
    held, answer = json.loads(data[_DIGEST_BYTES:])
    return answer if held == key else None


def _digest(body: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=_DIGEST_BYTES).digest()
