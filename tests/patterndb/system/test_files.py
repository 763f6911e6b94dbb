"""Regular files alone are read; what is replaced is replaced whole, and links stay links."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from patterndb.errors import InvalidMeshError
from patterndb.system.documents import read_limited
from patterndb.system.files import (
    UNFINISHED,
    open_regular,
    read_lines,
    replace_file,
    write_beside,
)

needs_pipes = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes by name here")


@needs_pipes
def test_pipes_and_devices_are_refused_at_once(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero")):
        with pytest.raises(OSError, match="pipe, socket or device") as refused:
            open_regular(path)
        assert refused.value.filename == str(path)
        with pytest.raises(OSError, match="pipe, socket or device"):
            read_limited(path, 10, InvalidMeshError, "")
        with pytest.raises(OSError, match="pipe, socket or device"):
            list(read_lines(path, 10, InvalidMeshError))
    with pytest.raises(IsADirectoryError):
        open_regular(tmp_path)


@pytest.mark.parametrize("name", ["a\0b", "\ud800", "\0"])
def test_a_name_that_no_file_can_have_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="no file can have this name"):
        open_regular(tmp_path / name)


def test_links_are_followed_when_read_and_stay_when_replaced(tmp_path: Path) -> None:
    there = tmp_path / "there"
    there.mkdir()
    (there / "file").write_text("old")
    link = tmp_path / "link"
    link.symlink_to(there / "file")
    with open_regular(link) as file:
        assert file.read() == b"old"
    replace_file(link, "new")
    assert link.is_symlink() and (there / "file").read_text() == "new"
    assert {path.name for path in tmp_path.rglob("*")} == {"there", "file", "link"}
    loose = tmp_path / "loose"
    loose.symlink_to(there / "later")
    replace_file(loose, "made")
    assert loose.is_symlink() and (there / "later").read_text() == "made"


def test_a_write_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), write_beside(path) as fresh:
        fresh.write_text("half")
        fresh.with_name("file-journal").write_text("more")
        assert fresh.parent.parent == tmp_path
        raise ZeroDivisionError
    assert path.read_text() == "old"
    # Nothing was written: the file that there is stays.
    with pytest.raises(FileNotFoundError), write_beside(path):
        pass
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
    with pytest.raises(FileNotFoundError) as refused:
        replace_file(tmp_path / "none" / "file", "new")
    assert refused.value.filename == str(tmp_path / "none" / "file")


@pytest.mark.skipif(os.name == "nt", reason="goes by time there")
def test_what_a_killed_process_left_goes_and_what_another_writes_stays(tmp_path: Path) -> None:
    left = tmp_path / f"{UNFINISHED}left"
    left.mkdir(mode=0o700)
    (left / "file").write_text("half")
    (left / "file-journal").write_text("half")
    # What only looks like it: a file, and a link to a folder of someone's.
    (tmp_path / f"{UNFINISHED}file").write_text("kept")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "kept").write_text("kept")
    (tmp_path / f"{UNFINISHED}link").symlink_to(tmp_path / "folder")
    path = tmp_path / "file"
    with write_beside(path) as one:
        assert not left.exists()
        with write_beside(path) as two:
            assert one.parent.exists() and one != two
            two.write_text("first")
        one.write_text("last")
    assert path.read_text() == "last"
    kept = {f"{UNFINISHED}file", f"{UNFINISHED}link", "folder", "file"}
    assert {one.name for one in tmp_path.iterdir()} == kept
    assert (tmp_path / "folder" / "kept").read_text() == "kept"


def test_files_have_the_mode_that_open_gives(tmp_path: Path) -> None:
    (tmp_path / "opened").write_text("")
    replace_file(tmp_path / "replaced", "")
    modes = {path.stat().st_mode for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_lines_have_numbers_and_a_limit(tmp_path: Path) -> None:
    path = tmp_path / "lines"
    path.write_bytes(b"\xef\xbb\xbfone\n\n  \ntwo")
    assert list(read_lines(path, 8, InvalidMeshError)) == [(1, b"one\n"), (4, b"two")]
    path.write_bytes(b"short\n" + b"x" * 9 + b"\n")
    with pytest.raises(InvalidMeshError, match=r"line 2 has more than 8 bytes"):
        list(read_lines(path, 8, InvalidMeshError))
