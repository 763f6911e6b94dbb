"""Files of work that is in no session yet: what a window that has no sessions keeps in case of a
crash (:mod:`patterndb_sketch.autosave`). JSON:

    {"format": "patterndb unsaved work", "version": 1, "kind": "surface", "of": "5ef2c0d9...",
     "work": {...}}

``of`` tells what was worked on from others: a digest of it. What ``work`` has is the kind's.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.errors import PatternDBError
from patterndb.system.documents import JsonModel, JsonValue, name_file, parse_json, read_limited

FORMAT, VERSION = "patterndb unsaved work", 1

#: Bytes that a file may have: a network of a million points has some 60 million.
MAX_BYTES = 256_000_000


class InvalidWorkError(PatternDBError, ValueError):
    """A file of unsaved work cannot be read."""


class WorkEntries(JsonModel):
    """What every such file has."""

    format: str
    version: int
    kind: str
    of: str
    work: Any


def digest_arrays(*arrays: ArrayLike) -> str:
    """Make a short text that is the same for the same arrays alone."""
    found = hashlib.blake2b(digest_size=16)
    for one in map(np.ascontiguousarray, arrays):
        found.update(f"{one.shape}{one.dtype.str}".encode())
        found.update(one.tobytes())
    return found.hexdigest()


def work_bytes(kind: str, of: str, work: dict[str, object]) -> bytes:
    """Give the content of a file; :func:`read_work` gives back what it is made of."""
    whole = {"format": FORMAT, "version": VERSION, "kind": kind, "of": of, "work": work}
    return (json.dumps(whole, separators=(",", ":"), allow_nan=False) + "\n").encode()


def read_work(path: Path, kind: str) -> tuple[str, JsonValue]:
    """Read a file: what its work is of, and the work.

    Raises InvalidWorkError that names the file and what is wrong with it; OSError as reading does.
    """
    with name_file(path, InvalidWorkError):
        content = read_limited(path, MAX_BYTES, InvalidWorkError, "give less")
        document = parse_json(content, InvalidWorkError, "unsaved work")
        found = document.read(WorkEntries)
        if (found.format, found.kind) != (FORMAT, kind):
            document.fail(f"this is no unsaved work of {kind}")
        if found.version != VERSION:
            document.fail(f"version {found.version} is none that this program reads, {VERSION}")
        return found.of, document.at("work")
