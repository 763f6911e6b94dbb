"""The user's cache folder: what can be made again at any time, kept between runs.

``PATTERNDB_CACHE`` names another place for it.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import platformdirs

from patterndb.system.files import replace_file

#: The environment variable that names the folder of compiled kernels.
KERNELS_VARIABLE = "PATTERNDB_KERNELS"


def cache_folders() -> list[Path]:
    """Where to keep things, best first; none of the folders need exist."""
    named = os.environ.get("PATTERNDB_CACHE")
    if named:
        return [Path(named)]
    own = platformdirs.user_cache_path("patterndb", appauthor=False)
    return [own, Path(tempfile.gettempdir()) / f"patterndb-{_user()}"]


def kernel_folder() -> Path:
    """The folder that this process keeps compiled kernels in; it need not exist."""
    named = os.environ.get(KERNELS_VARIABLE)
    folders = [Path(named)] if named else [folder / "kernels" for folder in cache_folders()]
    for folder in folders:
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return folders[-1]


def read_cached(name: str) -> bytes | None:
    """What :func:`write_cached` kept under that name; None where there is nothing.

    Whoever reads it must make sure that it is whole and theirs.
    """
    for folder in cache_folders():
        try:
            return (folder / name).read_bytes()
        except OSError:
            continue
    return None


def write_cached(name: str, content: bytes) -> bool:
    """Keep bytes under a file name, replacing in one step what was there.

    Returns False where no folder can be written: a cache may fail.
    """
    for folder in cache_folders():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            replace_file(folder / name, content)
        except OSError:
            continue
        return True
    return False


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
