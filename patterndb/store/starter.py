"""The starter database: learned from CC0 and public-domain meshes, shipped in compact form.

The first use unpacks it into the user's cache folder; that copy is opened as immutable, and
its name tells the content, so a newer package brings a new one.
"""

from __future__ import annotations

import contextlib
import hashlib
import tempfile
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

from patterndb.errors import DatabaseError
from patterndb.store import compact
from patterndb.store.migrations import SCHEMA_VERSION
from patterndb.system.caches import cache_folders

PACKED_NAME = "starter.xz"


def starter_path(say: Callable[[str], None] | None = None) -> Path:
    """The unpacked starter database; ``say`` is told before a first use takes its seconds.

    Raises DatabaseError if the package was built without one, if it is damaged, or if there
    is no folder to unpack it into.
    """
    packed = files("patterndb") / "data" / PACKED_NAME
    if not packed.is_file():
        raise DatabaseError(
            "this installation has no starter database; give --db FILE, or reinstall patterndb"
        )
    data = packed.read_bytes()
    name = f"starter-{hashlib.sha256(data).hexdigest()[:16]}-{SCHEMA_VERSION}.db"
    folders = cache_folders()
    failure: Exception | None = None
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    for folder in folders:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            work = Path(tempfile.mkdtemp(dir=folder, prefix=".unpacking-"))
        except OSError:
            continue
        if say is not None:
            say(f"unpacking the starter database into {folder} (once)")
        try:
            compact.load(data, work / name)
            # Another process may have been first; theirs is the same.
            (work / name).replace(folder / name)
        except (OSError, DatabaseError) as error:
            # No space left, say: the next folder may be on another disk.
            failure = error
            continue
        finally:
            for left in work.iterdir():
                left.unlink()
            with contextlib.suppress(OSError):
                work.rmdir()
        return folder / name
    reason = "" if failure is None else f" ({failure})"
    raise DatabaseError(
        f"no folder to unpack the starter database into{reason}; set PATTERNDB_CACHE to one "
        "that can be written, with 100 MB to spare"
    )
