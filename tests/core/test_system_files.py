"""Regular files alone are read; what is replaced is replaced whole, and links stay links."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from patterndb.errors import InvalidMeshError
from patterndb.system.documents import read_limited
from patterndb.system.files import open_regular, read_lines, replace_file

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


def test_lines_have_numbers_and_a_limit(tmp_path: Path) -> None:
    path = tmp_path / "lines"
    path.write_bytes(b"\xef\xbb\xbfone\n\n  \ntwo")
    assert list(read_lines(path, 8, InvalidMeshError)) == [(1, b"one\n"), (4, b"two")]
    path.write_bytes(b"short\n" + b"x" * 9 + b"\n")
    with pytest.raises(InvalidMeshError, match=r"line 2 has more than 8 bytes"):
        list(read_lines(path, 8, InvalidMeshError))
