"""The pack of compiled kernels that comes with the package: a file for one Python and one compiler.

A file ``data/kernels/<python>.pack`` holds what the user's folder would after compiling every
kernel of ``data/kernels.jsonl``, made by ``scripts/pack_kernels.py``. It is only ever read, each
kernel checked by its hash. One check says whether it is for this Python, numba, llvmlite, platform
and processor; if it is not, kernels are compiled into the user's folder, and the reason is told
there.

``PATTERNDB_PACK`` names another pack; empty, none is used.
"""

from __future__ import annotations

import hashlib
import json
import mmap
import os
import platform
import struct
import sys
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import llvmlite.binding  # pyright: ignore[reportMissingTypeStubs]

#: The environment variable that names another pack.
PACK_VARIABLE = "PATTERNDB_PACK"

#: How a pack begins; changed when earlier ones can no longer be read.
MAGIC = b"patterndb kernels 2\n"

_SIZE = struct.Struct("<Q")


@dataclass(frozen=True, slots=True)
class KernelPack:
    """An open pack. entries: where the compressed bytes of each key begin and end, and their
    SHA-256."""

    entries: Mapping[str, tuple[int, int, str]]
    content: Any

    def read(self, key: str) -> bytes | None:
        """The bytes under a key; None where there are none, or they are damaged."""
        at = self.entries.get(key)
        if at is None:
            return None
        packed = self.content[at[0] : at[1]]
        return zlib.decompress(packed) if _digest(packed) == at[2] else None


def get_pack_path() -> Path | None:
    """Where the pack for this Python is looked for; None where none shall be."""
    named = os.environ.get(PACK_VARIABLE)
    if named is not None:
        return Path(named) if named else None
    found = files("patterndb") / "data" / "kernels" / f"{sys.implementation.cache_tag}.pack"
    return found if isinstance(found, Path) else None


@cache
def find_pack(stamp: str, triple: str) -> tuple[KernelPack | None, str]:
    """The pack that this process can use, or None and why there is none, as a part of a sentence.

    stamp: what code depends on (:func:`patterndb.system.kernels.get_stamp`). triple: the platform.
    """
    path = get_pack_path()
    if path is None:
        return None, f"{PACK_VARIABLE} says to use none that came along"
    try:
        with path.open("rb") as file:
            content = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except (OSError, ValueError):
        return None, "none came with this installation"
    try:
        head, start = _parse_head(content)
        made_for, made_on, needs = head["stamp"], head["triple"], head["needs"]
        entries = {k: (start + a, start + b, d) for k, (a, b, d) in head["entries"].items()}
    except (ValueError, KeyError, TypeError, zlib.error, struct.error):
        return None, f"{path} is damaged; reinstall patterndb"
    if made_on != triple:
        return None, f"those that came along are for {made_on}"
    if made_for != stamp:
        return None, f"those that came along are for {head['compiler']}"
    have: dict[str, bool] = dict(llvmlite.binding.get_host_cpu_features())
    missing = [name for name in needs if not have.get(name)]
    if missing:
        return None, f"those that came along need a processor with {', '.join(missing)}"
    return KernelPack(entries, content), ""


def write_pack(
    path: Path,
    kernels: Iterable[tuple[str, bytes]],
    *,
    stamp: str,
    triple: str,
    needs: Iterable[str],
) -> int:
    """Write a pack of keys and their bytes; return its size. needs: features of the processor."""
    import numba

    entries: dict[str, tuple[int, int, str]] = {}
    packed: list[bytes] = []
    end = 0
    for key, content in sorted(kernels):
        packed.append(zlib.compress(content, 9))
        entries[key] = (end, end + len(packed[-1]), _digest(packed[-1]))
        end += len(packed[-1])
    compiler = (
        f"Python {platform.python_version().rpartition('.')[0]}, numba {numba.__version__} "
        f"and llvmlite {llvmlite.__version__}"
    )
    head = {
        "stamp": stamp,
        "compiler": compiler,
        "triple": triple,
        "needs": sorted(needs),
        "entries": entries,
    }
    line = zlib.compress(json.dumps(head).encode(), 9)
    content = MAGIC + _SIZE.pack(len(line)) + line + b"".join(packed)
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name(f"{path.name}.{os.getpid()}")
    half.write_bytes(content)
    half.replace(path)
    return len(content)


def _digest(packed: bytes) -> str:
    return hashlib.sha256(packed).hexdigest()


def _parse_head(content: Any) -> tuple[dict[str, Any], int]:
    if content[: len(MAGIC)] != MAGIC:
        raise ValueError("no pack")
    first = len(MAGIC) + _SIZE.size
    (size,) = _SIZE.unpack(content[len(MAGIC) : first])
    return json.loads(zlib.decompress(content[first : first + size])), first + size
