"""A place for compiled kernels.

numba keeps them beside the source or in the user's cache folder, and fails to import where
neither can be written: a package installed read-only, run by a user without a home.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"


def find_kernel_cache() -> None:
    """Name a temporary folder to numba if it would find no other place."""
    if os.environ.get(VARIABLE):
        return
    beside = Path(__file__).parent
    home = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    if _can_be_written(beside) or _can_be_written(home):
        return
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    os.environ[VARIABLE] = str(Path(tempfile.gettempdir()) / f"patterndb-kernels-{user}")


def _can_be_written(folder: Path) -> bool:
    """May files be made in the folder, or in the nearest one above it that exists?"""
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
