"""Sessions: what a sketch tool works on, as one JSON file.

    {"kind": "retopology", "version": 1, "of": "", "content": {...}}

All tools share this envelope, one reader and one writer; the content is the struct or
dataclass that a tool names in its :class:`SessionFormat`. Large arrays are packed, see
:mod:`patterndb.system.documents`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from patterndb.errors import PatternDBError
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    encode_json,
    name_file,
    parse_json,
    read_limited,
)
from patterndb.system.files import replace_file

VERSION = 1

#: Bytes that a session may have: those of a surface of some 15 million triangles.
MAX_BYTES = 1_000_000_000

Work = TypeVar("Work")
Content = TypeVar("Content")


class Envelope(JsonModel):
    """What every session has. of: a digest of what is worked on, "" where the content has it."""

    kind: str
    version: int
    content: Any
    of: str = ""


@dataclass(frozen=True, slots=True)
class SessionFormat(Generic[Work, Content]):
    """How a tool's work is kept.

    kind: its name. error: what is raised about a file. content: the type that is written and read.
    save: makes the content of the work. open: makes the work of a content, at its
    place in the document; raises ``error``.
    """

    kind: str
    error: type[PatternDBError]
    content: type[Content]
    save: Callable[[Work], Content]
    open: Callable[[Content, JsonValue], Work]

    def encode(self, work: Work, of: str = "") -> bytes:
        """Return the bytes of a session; the same work gives the same bytes."""
        return encode_json(Envelope(self.kind, VERSION, self.save(work), of), packed=True)

    def decode(self, data: bytes) -> Work:
        """Return the work in the bytes of a session; raises ``error`` with the place in them."""
        return self._decode(data)[0]

    def read(self, path: Path | str) -> Work:
        """Return the work in a file, bit for bit as it was written.

        Raises ``error`` with the file and the place in it; OSError.
        """
        return self.read_with_origin(path)[0]

    def read_with_origin(self, path: Path | str) -> tuple[Work, str]:
        """Return as :meth:`read` the work, and the digest of what it is on, "" for none."""
        path = Path(path)
        with name_file(path, self.error):
            return self._decode(read_limited(path, MAX_BYTES, self.error, "split the surface"))

    def _decode(self, data: bytes) -> tuple[Work, str]:
        try:
            document = parse_json(data, self.error, f"a session of {self.kind}")
        except self.error as reason:
            raise self.error(f"this is not a session of {self.kind}: {reason}") from None
        if not document.is_object or "kind" not in document.entries():
            document.fail(f'this is not a session of {self.kind}, which has "kind" and "version"')
        found = document.read(Envelope)
        if (found.kind, found.version) != (self.kind, VERSION):
            document.fail(
                f"this is {found.kind!r} version {found.version}; {self.kind!r} version {VERSION} "
                "is needed here"
            )
        place = document.at("content")
        content = place.read(self.content)
        with place.named():
            return self.open(content, place), found.of

    def write(self, path: Path | str, work: Work, of: str = "") -> None:
        """Write a session in one step; :meth:`read` gives it back bit for bit. Raises OSError."""
        replace_file(Path(path), self.encode(work, of))


def digest_arrays(*arrays: ArrayLike) -> str:
    """Return a short text that is the same for the same arrays alone."""
    found = hashlib.blake2b(digest_size=16)
    for one in map(np.ascontiguousarray, arrays):
        found.update(f"{one.shape}{one.dtype.str}".encode())
        found.update(one.tobytes())
    return found.hexdigest()
