"""Files that are worked on: one that somebody else has changed is not replaced."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from patterndb.errors import PatternDBError
from patterndb.system.files import replace_file
from patterndb.system.knownfiles import FileChangedError, KnownFiles


def save(known: KnownFiles, path: Path, text: str, **options: bool) -> None:
    known.save(path, lambda: replace_file(path, text), **options)


@pytest.mark.parametrize("begun", ["", "before"])
def test_a_file_that_another_has_saved_is_not_replaced(tmp_path: Path, begun: str) -> None:
    path = tmp_path / "work.session"
    if begun:
        path.write_text(begun)
    one, other = KnownFiles(), KnownFiles()
    one.note(path)
    other.note(path)
    save(one, path, "one")
    save(one, path, "one again")
    with pytest.raises(FileChangedError, match=r"reload it.*another file.*overwrite") as caught:
        save(other, path, "other")
    assert isinstance(caught.value, PatternDBError) and isinstance(caught.value, OSError)
    assert caught.value.path == path and str(path) in str(caught.value)
    assert path.read_text() == "one again"
    assert other.refused is not None and other.refused.path == path
    # Each of the three ways.
    save(other, tmp_path / "elsewhere.session", "other")
    assert (tmp_path / "elsewhere.session").read_text() == "other"
    save(other, path, "other", overwrite=True)
    assert path.read_text() == "other" and other.refused is None
    with pytest.raises(FileChangedError):
        save(one, path, "one")
    one.note(path)
    save(one, path, "one, after it was read again")
    assert path.read_text() == "one, after it was read again"


def test_the_content_counts_and_not_the_time(tmp_path: Path) -> None:
    path = tmp_path / "work.session"
    path.write_text("same")
    known = KnownFiles()
    known.note(path)
    path.write_text("same")
    os.utime(path, (1.0, 1.0))
    save(known, path, "next")
    times = path.stat().st_mtime_ns
    path.write_text("text")
    os.utime(path, ns=(times, times))
    with pytest.raises(FileChangedError):
        save(known, path, "again")


def test_a_file_is_known_by_all_its_names(tmp_path: Path) -> None:
    path, link = tmp_path / "work.session", tmp_path / "link.session"
    path.write_text("first")
    link.symlink_to(path)
    known = KnownFiles()
    known.note(link)
    path.write_text("second")
    with pytest.raises(FileChangedError):
        save(known, path, "third")
    assert path.read_text() == "second"


def test_a_file_that_was_deleted_or_made_meanwhile_has_changed(tmp_path: Path) -> None:
    path = tmp_path / "work.session"
    known = KnownFiles()
    known.note(path)
    path.write_text("made")
    with pytest.raises(FileChangedError, match="has changed"):
        save(known, path, "mine")
    known.note(path)
    path.unlink()
    with pytest.raises(FileChangedError, match="was deleted"):
        save(known, path, "mine")
    # One that is not known was just chosen by the user.
    known.forget(path)
    save(known, path, "mine")
    assert path.read_text() == "mine"


def test_what_cannot_be_written_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "work.session"
    known = KnownFiles()
    known.note(path)

    def fail() -> None:
        raise OSError("the disk is full")

    with pytest.raises(OSError, match="full"):
        known.save(path, fail)
    assert known.refused is None
    save(known, path, "mine")
