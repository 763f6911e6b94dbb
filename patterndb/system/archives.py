"""Reading zip files of documents and arrays that come from anyone."""

from __future__ import annotations

import io
import zipfile
import zlib
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import PatternDBError

#: What zipfile and its decompressors raise for files that are none, damaged, encrypted, packed by
#: methods that are not known, or whose sizes are a lie.
_UNREADABLE = (
    zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, LookupError, RuntimeError,
    NotImplementedError, OverflowError, MemoryError,
)  # fmt: skip


def read_members(
    data: bytes,
    error: type[PatternDBError],
    what: str,
    *,
    max_bytes: int,
    max_members: int | None = None,
) -> dict[str, bytes]:
    """Read the members of a zip file by name.

    what: what it should be, such as "a session", for messages. Raises ``error`` if it is no zip
    file, is damaged, has two members of one name, more members than max_members, or more than
    max_bytes when it is unpacked.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len({one.filename for one in members}) < len(members):
                raise error(f"{what} has two entries of one name in its zip")
            if max_members is not None and len(members) > max_members:
                raise error(
                    f"{what} has {len(members):,} entries in its zip; the limit is {max_members:,}"
                )
            if sum(one.file_size for one in members) > max_bytes:
                raise error(f"{what} has more than {max_bytes:,} bytes in its zip")
            return {one.filename: archive.read(one) for one in members}
    except PatternDBError:
        raise
    except _UNREADABLE as reason:
        raise error(f"this is not {what}, which is a zip file: {reason}") from None


def read_array(content: bytes, error: type[PatternDBError], what: str) -> NDArray[Any]:
    """Read a NumPy array as ``numpy.save`` writes it, without pickles.

    what: what the array is, for messages. Raises ``error`` if it is damaged.
    """
    try:
        return np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    except (ValueError, EOFError, OSError, MemoryError, OverflowError, TypeError) as reason:
        raise error(f"{what} are damaged: {reason}") from None
    except (SyntaxError, TokenError, RecursionError) as reason:
        # The header is an expression of Python, and read as one.
        raise error(f"{what} are damaged: the header cannot be read ({reason})") from None
