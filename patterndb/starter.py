"""The starter database: learned from CC0 and public-domain meshes, shipped compressed.

It comes as one xz file, which the first use unpacks into the user's cache folder; that copy
is opened as immutable, and its name tells the content, so a newer package brings a new one.
"""

from __future__ import annotations

import hashlib
import lzma
import os
import sys
import tempfile
from importlib.resources import files
from pathlib import Path

from patterndb.errors import DatabaseError
from patterndb.files import replace_file

PACKED_NAME = "starter.db.xz"


def starter_path() -> Path:
    """The unpacked starter database.

    Raises DatabaseError if the package was built without one, or it is damaged.
    """
    packed = files("patterndb") / "data" / PACKED_NAME
    if not packed.is_file():
        raise DatabaseError(
            "this installation has no starter database; give --db FILE, or reinstall patterndb"
        )
    data = packed.read_bytes()
    name = f"starter-{hashlib.sha256(data).hexdigest()[:16]}.db"
    for folder in _cache_folders():
        path = folder / name
        if path.is_file():
            return path
        try:
            folder.mkdir(parents=True, exist_ok=True)
            replace_file(path, _unpacked(data))
        except OSError:
            continue
        return path
    raise DatabaseError(
        "no folder to unpack the starter database into; set PATTERNDB_CACHE to one that "
        "can be written"
    )


def _unpacked(data: bytes) -> bytes:
    try:
        return lzma.decompress(data)
    except lzma.LZMAError as error:
        raise DatabaseError(
            f"the starter database is damaged ({error}); reinstall patterndb"
        ) from error


def _cache_folders() -> list[Path]:
    """Where to unpack, best first."""
    named = os.environ.get("PATTERNDB_CACHE")
    if named:
        return [Path(named)]
    folders: list[Path] = []
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        folders += [Path(local) / "patterndb" / "cache"] if local else []
    elif sys.platform == "darwin":
        folders.append(Path("~/Library/Caches/patterndb").expanduser())
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
        folders.append(Path(base).expanduser() / "patterndb")
    return [*folders, Path(tempfile.gettempdir()) / f"patterndb-{_user()}"]


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
