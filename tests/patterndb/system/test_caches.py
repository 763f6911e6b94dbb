"""Whose cache folders are trusted: what another user made, or could exchange, is passed over."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from patterndb.store import starter
from patterndb.system import caches
from patterndb.system.caches import is_trusted, make_trusted
from patterndb.system.files import UNFINISHED, remove_unfinished, replace_file
from patterndb.system.mappedarrays import ArrayCache

#: Another user, and a group that is nobody's own.
OTHER = 65534

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owners here")
as_root = pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="needs to make files of another user"
)


@pytest.fixture
def shared(tmp_path: Path) -> Path:
    """A folder that all share, as /tmp is."""
    folder = tmp_path / "tmp"
    folder.mkdir()
    folder.chmod(0o1777)
    return folder


@pytest.fixture
def theirs(shared: Path) -> Path:
    """A folder that another user has made there, under our name."""
    folder = shared / f"patterndb-{os.getuid()}"
    folder.mkdir(mode=0o755)
    os.chown(folder, OTHER, OTHER)
    return folder


def put(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("mode", "trusted"),
    [(0o700, True), (0o755, True), (0o777, False), (0o1777, False), (0o757, False)],
)
def test_a_folder_that_others_may_write_into_is_not_trusted(
    shared: Path, mode: int, trusted: bool
) -> None:
    folder = shared / "cache"
    folder.mkdir()
    folder.chmod(mode)
    assert is_trusted(folder) == trusted


@pytest.mark.parametrize("group_is_own", [True, False])
def test_a_group_may_write_only_if_it_is_the_user_s_own(
    shared: Path, group_is_own: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(caches, "_is_private", lambda group: group_is_own)
    folder = shared / "cache"
    folder.mkdir()
    folder.chmod(0o770)
    assert is_trusted(folder) == group_is_own


@pytest.mark.parametrize(("mode", "trusted"), [(0o777, False), (0o1777, True), (0o755, True)])
def test_who_may_rename_a_folder_above_may_exchange_it(
    tmp_path: Path, mode: int, trusted: bool
) -> None:
    above = tmp_path / "above"
    folder = above / "between" / "cache"
    folder.mkdir(parents=True, mode=0o700)
    above.chmod(mode)
    assert is_trusted(folder) == trusted
    # As well where a link that is ours leads there.
    link = tmp_path / "link"
    link.symlink_to(folder)
    assert is_trusted(link) == trusted
    assert is_trusted(link / ".." / "cache") == trusted


def test_a_link_counts_as_what_it_leads_to(shared: Path, tmp_path: Path) -> None:
    (tmp_path / "own").mkdir(mode=0o700)
    link = shared / "link"
    link.symlink_to(tmp_path / "own")
    assert is_trusted(link)
    (tmp_path / "file").touch()
    link.unlink()
    link.symlink_to(tmp_path / "file")
    assert not is_trusted(link)
    link.unlink()
    link.symlink_to(link)
    assert not is_trusted(link) and not is_trusted(shared / "none")


def test_what_is_made_is_for_its_owner_alone(shared: Path) -> None:
    old = os.umask(0)
    try:
        assert make_trusted(shared / "cache")
    finally:
        os.umask(old)
    assert stat.S_IMODE((shared / "cache").stat().st_mode) == 0o700


def keep_arrays(
    folder: Path, cache: ArrayCache, monkeypatch: pytest.MonkeyPatch, planted: int = 0
) -> list[Path]:
    """Files of arrays in a cache folder."""
    monkeypatch.setattr("patterndb.system.mappedarrays.cache_folders", lambda: [folder])
    assert cache.keep("class", {"ids": np.full(2, planted)})
    return list((folder / "arrays").iterdir())


@as_root
class TestAnotherUser:
    """What another user of the machine plants is not used, and does not stand in the way."""

    @pytest.fixture(autouse=True)
    def _one_folder(self, theirs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.delenv("PATTERNDB_CACHE", raising=False)
        monkeypatch.setattr(caches, "cache_folders", lambda: [theirs])
        for module in ("patterndb.store.starter", "patterndb.system.mappedarrays"):
            monkeypatch.setattr(f"{module}.cache_folders", lambda: [theirs])

    def test_their_link_to_our_folder_is_not_followed(self, theirs: Path, tmp_path: Path) -> None:
        (tmp_path / "own").mkdir(mode=0o700)
        theirs.rmdir()
        theirs.symlink_to(tmp_path / "own")
        os.chown(theirs, OTHER, OTHER, follow_symlinks=False)
        assert not is_trusted(theirs) and not make_trusted(theirs)

    def test_a_folder_of_ours_within_theirs_is_not_trusted(self, theirs: Path) -> None:
        ours = theirs / "arrays"
        ours.mkdir(mode=0o700)
        assert not is_trusted(ours) and not make_trusted(ours)

    def test_their_arrays_are_not_mapped(
        self, theirs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        cache, arrays = ArrayCache("a database", "a content"), {"ids": np.arange(4)}
        own = tmp_path / "own"
        monkeypatch.setattr("patterndb.system.mappedarrays.cache_folders", lambda: [own])
        assert cache.keep("class", arrays) and cache.find("class") is not None
        own.rename(theirs.with_name("kept"))
        theirs.rmdir()
        theirs.with_name("kept").rename(theirs)
        os.chown(theirs, OTHER, OTHER)
        monkeypatch.setattr("patterndb.system.mappedarrays.cache_folders", lambda: [theirs])
        assert cache.find("class") is None and not cache.keep("class", arrays)

    def test_their_starter_is_not_opened(
        self, theirs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        packed = b"what the package has"
        asked: list[Path] = []

        def make(data: bytes, path: Path, progress: object) -> None:
            asked.append(path)
            path.write_bytes(b"sound")

        monkeypatch.setattr(starter.compact, "load", make)
        with pytest.raises(starter.DatabaseError, match="PATTERNDB_CACHE"):
            starter.unpack_starter(packed)
        own = tmp_path / "own"
        monkeypatch.setattr("patterndb.store.starter.cache_folders", lambda: [theirs, own])
        made = starter.unpack_starter(packed)
        assert made.parent == own and len(asked) == 1
        # A database of theirs, with the hash that belongs to it.
        for beside in own.iterdir():
            put(theirs / beside.name, beside.read_bytes())
        assert starter.unpack_starter(packed) == made and len(asked) == 1

    def test_a_hard_link_to_a_file_of_ours_brings_nothing(
        self, theirs: Path, shared: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """They may link a file of ours into their folder where the system lets them: its owner
        is right, its folder is not."""
        cache = ArrayCache("a database", "a content")
        (kept,) = keep_arrays(shared / "own", cache, monkeypatch)
        (theirs / "arrays").mkdir()
        os.link(kept, theirs / "arrays" / kept.name)
        os.chown(theirs / "arrays", OTHER, OTHER)
        monkeypatch.setattr("patterndb.system.mappedarrays.cache_folders", lambda: [theirs])
        assert cache.find("class") is None

    @pytest.mark.parametrize("step", ["rename", "link"])
    def test_a_folder_is_not_exchanged_between_looking_and_reading(
        self, tmp_path: Path, step: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """In a folder without the sticky bit another user could: nothing there is trusted."""
        open_to_all = tmp_path / "open"
        open_to_all.mkdir()
        open_to_all.chmod(0o777)
        ours = open_to_all / "cache"
        cache = ArrayCache("a database", "a content")
        keep_arrays(tmp_path / "own", cache, monkeypatch)
        keep_arrays(tmp_path / "evil", cache, monkeypatch, planted=1)
        (tmp_path / "own").rename(ours)
        monkeypatch.setattr("patterndb.system.mappedarrays.cache_folders", lambda: [ours])
        look: Callable[[Path], bool] = caches.is_trusted

        def look_and_lose(folder: Path) -> bool:
            said = look(folder)
            if folder == ours and ours.is_dir():
                ours.rename(open_to_all / "aside")
                (tmp_path / "evil").rename(open_to_all / "evil")
                if step == "rename":
                    (open_to_all / "evil").rename(ours)
                else:
                    ours.symlink_to(open_to_all / "evil")
            return said

        monkeypatch.setattr("patterndb.system.mappedarrays.is_trusted", look_and_lose)
        found = cache.find("class")
        assert found is None or found["ids"].tolist() == [0, 0]


class TestLeftovers:
    """Only what a write of ours has left is taken away, whatever has its name."""

    def leave(self, folder: Path, mode: int = 0o700) -> Path:
        left = folder / f"{UNFINISHED}abcdefgh"
        left.mkdir(mode=mode)
        left.chmod(mode)
        put(left / "half.obj", b"v 0 0 0")
        return left

    def test_what_was_left_goes(self, tmp_path: Path) -> None:
        left = self.leave(tmp_path)
        (left / "link").symlink_to(tmp_path)
        assert left.is_dir()
        (left / "link").unlink()
        remove_unfinished(tmp_path)
        assert not left.exists()

    @pytest.mark.parametrize("kind", ["mode", "folder", "link"])
    def test_a_folder_that_only_has_the_name_stays(self, tmp_path: Path, kind: str) -> None:
        left = self.leave(tmp_path, 0o755 if kind == "mode" else 0o700)
        if kind == "folder":
            put(left / "work" / "model.obj", b"a week's work")
        elif kind == "link":
            (left / "link").symlink_to(tmp_path)
        before = sorted(left.rglob("*"))
        remove_unfinished(tmp_path)
        replace_file(tmp_path / "other", b"new")
        assert sorted(left.rglob("*")) == before

    @as_root
    def test_another_user_s_stays(self, tmp_path: Path) -> None:
        left = self.leave(tmp_path)
        os.chown(left, OTHER, OTHER)
        remove_unfinished(tmp_path)
        assert (left / "half.obj").exists()


@as_root
def test_two_users_have_each_a_folder_that_the_other_does_not_take() -> None:
    def ask(uid: int, question: Callable[[], Any]) -> str:
        mine, other = os.pipe()
        pid = os.fork()
        if pid == 0:
            said = "raised"
            try:
                os.setgid(uid)
                os.setuid(uid)
                said = repr(question())
            finally:
                os.write(other, said.encode())
                os._exit(0)
        os.waitpid(pid, 0)
        os.close(other)
        with os.fdopen(mine, "rb") as pipe:
            return pipe.read().decode()

    with tempfile.TemporaryDirectory() as made:
        Path(made).chmod(0o1777)
        shared = Path(made).resolve()
        folder = shared / "patterndb-4001"
        assert ask(4001, lambda: make_trusted(folder)) == "True"
        assert folder.stat().st_uid == 4001
        assert ask(4002, lambda: (is_trusted(folder), make_trusted(folder))) == "(False, False)"
        assert ask(4002, lambda: make_trusted(shared / "patterndb-4002")) == "True"
        # Root's is trusted by both: root can change theirs.
        make_trusted(shared / "roots")
        (shared / "roots").chmod(0o755)
        assert ask(4001, lambda: is_trusted(shared / "roots")) == "True"
