"""The user's cache folder: what can be made again at any time, kept between runs.

``PATTERNDB_CACHE`` names another place for it. What is read from it is believed
(arrays, the starter's database), so a folder counts only where nobody else can have written:
it belongs to this user, and others may write neither into it nor into those above it. In a
folder that all share, such as ``/tmp``, another user may have made the name first; then it is
passed over.
"""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from functools import cache
from pathlib import Path

import platformdirs

#: Root's files are trusted as this user's own: root can change those as well.
_ROOT = 0


def cache_folders() -> list[Path]:
    """Where to keep things, best first; none of the folders need exist, or be ours."""
    named = os.environ.get("PATTERNDB_CACHE")
    if named:
        return [Path(named)]
    own = platformdirs.user_cache_path("patterndb", appauthor=False)
    return [own, Path(tempfile.gettempdir()) / f"patterndb-{_user()}"]


def is_trusted(folder: Path) -> bool:
    """Is this a folder that only this user can have written into, or put in its place?

    The folders above it count as well: whoever may rename what lies in one of them could exchange
    it at any moment. In one that all may write into, such as ``/tmp``, they may not if it has the
    sticky bit. Systems without owners of files (Windows) keep a user's folders apart by other
    means.
    """
    try:
        # lstat: a link that another user has laid is theirs, wherever it leads.
        found = folder.lstat()
        if stat.S_ISLNK(found.st_mode) and not _is_ours(found):
            return False
        whole = Path(os.path.realpath(folder))
        found = whole.lstat()
        if not stat.S_ISDIR(found.st_mode):
            return False
        if os.name == "nt":
            return True
        if not _is_ours(found) or _may_others_write(found):
            return False
        # The folder in which a link lies, too: the link could be laid elsewhere.
        for below in {folder.absolute(), whole}:
            for above in below.parents:
                found = above.stat()
                shared = _may_others_write(found) and not found.st_mode & stat.S_ISVTX
                if not _is_ours(found) or shared:
                    return False
    except OSError:
        return False
    return True


def make_trusted(folder: Path) -> bool:
    """Make a folder that only this user can read and write, with those above it; return
    whether it is there now and trusted."""
    with contextlib.suppress(OSError):
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
    return is_trusted(folder)


def _is_ours(found: os.stat_result) -> bool:
    """Does a file belong to this user, or to one who can change this user's as well?"""
    return not hasattr(os, "getuid") or found.st_uid in (os.getuid(), _ROOT, _owner_of_all())


@cache
def _owner_of_all() -> int:
    """Whose ``/`` is: in a container root may have another number."""
    return Path("/").stat().st_uid


def _may_others_write(found: os.stat_result) -> bool:
    if found.st_mode & stat.S_IWOTH:
        return True
    return bool(found.st_mode & stat.S_IWGRP) and not _is_private(found.st_gid)


@cache
def _is_private(group: int) -> bool:
    """Is this a group of one: this user's, or root's? Many systems give every user one."""
    try:
        import grp
        import pwd

        found, user = grp.getgrgid(group), pwd.getpwuid(os.getuid())
        return found.gr_name in (user.pw_name, "root") and set(found.gr_mem) <= {user.pw_name}
    except (ImportError, KeyError):
        return False


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
