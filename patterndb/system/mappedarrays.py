"""Arrays in files of the user's cache folder, mapped into memory: processes share their pages.

A file holds the arrays as they lie in memory, so that nothing is read before it is used, and no
process has a copy of its own. It begins with a line of JSON that tells its key, and of each array
its name, type, shape, place and checksums; a line with the checksum of the first follows. A file
that is not whole, or whose key is another, is as good as none: its arrays are made again.

The mappings are private and can be written to, as other arrays can:
whoever writes gets pages of its own, and neither the file nor another process sees it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import mmap
import os
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from io import BufferedReader
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.caches import cache_folders, is_trusted, make_trusted
from patterndb.system.memory import return_freed_memory

Array = NDArray[Any]

#: How a file begins; the number changes when files of an earlier version can no longer be read.
MAGIC = b"patterndb arrays 1\n"

#: The folder of these files in the user's cache folder.
FOLDER = "arrays"

#: Types that a file may hold; little-endian on every machine.
DTYPES = frozenset(("|u1", "<u2", "<u4", "|i1", "<i2", "<i4", "<i8", "|b1"))

#: Bytes at a multiple of which every array begins: a line of the processor's cache.
ALIGNMENT = 64

#: Bytes of the longest head: some dozens of arrays, and a checksum for each CHUNK of them.
LONGEST_HEAD = 1 << 20

#: Bytes that one checksum is of: threads share them out.
CHUNK = 4 << 20

#: Bytes of all files together; those not used for longest go first.
MOST_BYTES = 16 << 30

#: Seconds after which a file that was begun and not finished is nobody's any more.
ABANDONED_SECONDS = 3600.0


@dataclass(frozen=True, slots=True)
class ArrayCache:
    """Where arrays made of one thing are kept.

    source: tells the thing from others, whatever it holds now, such as a file's path.
    key: tells what it holds now. Of one source the files of its last key are kept.
    """

    source: str
    key: str

    def find(self, what: str) -> dict[str, Array] | None:
        """The arrays kept under a name, mapped; None where there are none of this key that are
        whole."""
        name, key = self._name(what), self._full_key(what)
        for folder in cache_folders():
            if is_trusted(folder) and is_trusted(folder / FOLDER):
                arrays = map_arrays(folder / FOLDER / name, key)
                if arrays is not None:
                    return arrays
        return None

    def keep(self, what: str, arrays: Mapping[str, Array]) -> bool:
        """Keep arrays under a name, in place of what was there; return whether they are.

        Nothing is kept where no folder can be written: a cache may fail.
        """
        for folder in cache_folders():
            if make_trusted(folder) and make_trusted(folder / FOLDER):
                path = folder / FOLDER / self._name(what)
                try:
                    write_arrays(path, self._full_key(what), arrays)
                except OSError:
                    continue
                remove_unused(path.parent, MOST_BYTES)
                return True
        return False

    def find_or_make(
        self, what: str, make: Callable[[], Mapping[str, Array]]
    ) -> Mapping[str, Array]:
        """The arrays kept under a name; where there are none they are made, and kept."""
        found = self.find(what)
        if found is not None:
            return found
        made = make()
        if not self.keep(what, made):
            return made
        # Mapped: those just made are memory of this process alone, and would be there twice.
        del made
        return_freed_memory()
        return self.find(what) or make()

    def _name(self, what: str) -> str:
        return f"{_digest(self.source)[:24]}-{what}.arrays"

    def _full_key(self, what: str) -> str:
        return _digest(f"{self.source}\n{what}\n{self.key}")


def write_arrays(path: Path, key: str, arrays: Mapping[str, Array]) -> None:
    """Write a file of arrays in one step.

    Nothing waits for the disk: should the machine crash, what is lost does not add up to its
    checksum. Raises OSError as writing does, and ValueError for an
    array whose type is none of DTYPES."""
    held = {name: _to_plain(name, array) for name, array in arrays.items()}
    told: list[list[object]] = []
    at = 0
    for name, array in held.items():
        flat = _bytes_of(array)
        sums = [zlib.crc32(flat[a : a + CHUNK]) for a in range(0, array.nbytes, CHUNK)]
        told.append([name, array.dtype.str, list(array.shape), at, sums])
        at += -(-array.nbytes // ALIGNMENT) * ALIGNMENT
    line = json.dumps({"key": key, "arrays": told, "size": at}).encode()
    head = MAGIC + line + b"\n" + _digest_bytes(line) + b"\n"
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(head + bytes(-len(head) % ALIGNMENT))
            for array in held.values():
                file.write(_bytes_of(array))
                file.write(_padding(array))
        Path(temporary).replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(temporary).unlink()
        raise


def map_arrays(path: Path, key: str) -> dict[str, Array] | None:
    """The arrays of a file, mapped; None where there is no such file, it is not whole, or its key
    is another."""
    try:
        with path.open("rb") as file:
            head = _read_head(file)
            if head is None or head["key"] != key:
                return None
            begin = -(-file.tell() // ALIGNMENT) * ALIGNMENT
            size = os.fstat(file.fileno()).st_size
            if size != begin + head["size"] or not _add_up(file, begin, head["arrays"]):
                return None
            # An empty map cannot be made; a file has its head at least.
            mapped = mmap.mmap(file.fileno(), size, access=mmap.ACCESS_COPY)
        arrays: dict[str, Array] = {}
        for name, dtype, shape, at, _ in head["arrays"]:
            # numpy makes no empty array of a buffer's end.
            n = prod(shape)
            flat = np.frombuffer(mapped, dtype, n, begin + at) if n else np.empty(0, dtype)
            arrays[name] = flat.reshape(shape)
        # Those used last are kept longest.
        with contextlib.suppress(OSError):
            os.utime(path)
        return arrays
    except (OSError, ValueError, TypeError, KeyError):
        return None


def remove_unused(folder: Path, most: int) -> None:
    """Delete what was not used for longest, until the files have ``most`` bytes together, and
    what another process began and never finished."""
    kept: list[tuple[float, int, Path]] = []
    with contextlib.suppress(OSError):
        for path in folder.iterdir():
            with contextlib.suppress(OSError):
                found = path.stat()
                if not path.name.startswith("."):
                    kept.append((found.st_mtime, found.st_size, path))
                elif time.time() - found.st_mtime > ABANDONED_SECONDS:
                    path.unlink()
    total = sum(size for _, size, _ in kept)
    for _, size, path in sorted(kept, key=lambda one: one[0])[:-1]:
        if total <= most:
            return
        # Where it is mapped it stays until it is no more; Windows refuses.
        with contextlib.suppress(OSError):
            path.unlink()
            total -= size


def _read_head(file: BufferedReader) -> dict[str, Any] | None:
    if file.read(len(MAGIC)) != MAGIC:
        return None
    line = file.readline(LONGEST_HEAD).rstrip(b"\n")
    if file.readline(LONGEST_HEAD).rstrip(b"\n") != _digest_bytes(line):
        return None
    return json.loads(line)


def _add_up(file: BufferedReader, begin: int, told: list[Any]) -> bool:
    """Are the arrays of a file of types that it may hold, and those that were written?"""
    if any(dtype not in DTYPES for _, dtype, _, _, _ in told):
        return False
    parts: list[tuple[int, int, int]] = []
    for _, dtype, shape, at, sums in told:
        size = prod(shape) * np.dtype(dtype).itemsize
        if len(sums) != -(-size // CHUNK):
            return False
        for k, checksum in enumerate(sums):
            first = begin + at + k * CHUNK
            parts.append((first, min(first + CHUNK, begin + at + size), checksum))
    # A map of its own, which is gone afterwards, with the pages that the process may never use.
    with (
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped,
        memoryview(mapped) as view,
        ThreadPoolExecutor(os.cpu_count()) as pool,
    ):

        def is_right(part: tuple[int, int, int]) -> bool:
            first, last, checksum = part
            with view[first:last] as chunk:
                right = zlib.crc32(chunk) == checksum
            # Its pages are given back at once, where the system can be told: they may be many.
            if sys.platform != "win32":
                page = first // mmap.PAGESIZE * mmap.PAGESIZE
                mapped.madvise(mmap.MADV_DONTNEED, page, last - page)
            return right

        return all(pool.map(is_right, parts))


def _to_plain(name: str, array: Array) -> Array:
    plain = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    if plain.dtype.str not in DTYPES:
        raise ValueError(f"array {name} has the type {plain.dtype}, which no file holds")
    return plain


def _bytes_of(array: Array) -> memoryview:
    return array.reshape(-1).view(np.uint8).data


def _padding(array: Array) -> bytes:
    return bytes(-array.nbytes % ALIGNMENT)


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode("utf-8", "surrogateescape"), digest_size=16).hexdigest()


def _digest_bytes(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=16).hexdigest().encode()
