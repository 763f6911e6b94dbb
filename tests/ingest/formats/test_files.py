"""What holds of every format: which files are opened, and how they are refused."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ingest.formats import (
    FORMATS,
    SUPPORTED_SUFFIXES,
    ReadLimits,
    find_format,
    load_file,
    parse,
    read_mesh,
)
from ingest.formats.files import DEFAULT_LIMITS
from patterndb.errors import MeshFileError, UnsupportedFormatError

ROOT = Path(__file__).parents[3]
SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"


def test_reads_a_file_by_path_or_string(tmp_path: Path) -> None:
    path = tmp_path / "a.OBJ"
    path.write_bytes(SQUARE)
    for spelling in (path, str(path)):
        assert read_mesh(spelling).corners.tolist() == [0, 1, 2, 3]
    data = load_file(path)
    assert data == SQUARE
    assert parse(data, path).n_faces == 1


def test_follows_a_link_to_a_regular_file(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(SQUARE)
    (tmp_path / "b.obj").symlink_to("a")
    assert read_mesh(tmp_path / "b.obj").n_faces == 1


@pytest.mark.parametrize("suffix", SUPPORTED_SUFFIXES)
class TestEveryFormat:
    def test_missing(self, tmp_path: Path, suffix: str) -> None:
        _refused(tmp_path / f"a{suffix}", "No such file")

    def test_dangling_link(self, tmp_path: Path, suffix: str) -> None:
        (tmp_path / f"a{suffix}").symlink_to("nowhere")
        _refused(tmp_path / f"a{suffix}", "No such file")

    def test_directory(self, tmp_path: Path, suffix: str) -> None:
        (tmp_path / f"a{suffix}").mkdir()
        _refused(tmp_path / f"a{suffix}", "directory")

    def test_empty(self, tmp_path: Path, suffix: str) -> None:
        (tmp_path / f"a{suffix}").touch()
        _refused(tmp_path / f"a{suffix}", "empty")

    def test_pipe(self, tmp_path: Path, suffix: str) -> None:
        os.mkfifo(tmp_path / f"a{suffix}")
        _refused(tmp_path / f"a{suffix}", "not a regular file")

    def test_device(self, tmp_path: Path, suffix: str) -> None:
        (tmp_path / f"a{suffix}").symlink_to("/dev/zero")
        _refused(tmp_path / f"a{suffix}", "not a regular file")

    def test_too_large(self, tmp_path: Path, suffix: str) -> None:
        (tmp_path / f"a{suffix}").write_bytes(SQUARE)
        limits = ReadLimits(max_bytes=len(SQUARE) - 1)
        _refused(tmp_path / f"a{suffix}", "over the limit", limits)

    def test_larger_than_memory(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / f"a{suffix}"
        path.touch()
        os.truncate(path, 2**40)  # sparse: it takes no room
        _refused(path, "over the limit")

    @pytest.mark.parametrize("junk", [b"\n", b"\0" * 100, bytes(range(255, 0, -1))])
    def test_junk(self, tmp_path: Path, suffix: str, junk: bytes) -> None:
        path = tmp_path / f"a{suffix}"
        path.write_bytes(junk)
        _refused(path, "")

    def test_name_with_nul(self, tmp_path: Path, suffix: str) -> None:
        _refused(Path(f"a\0b{suffix}"), "cannot be read")


def _refused(path: Path, part: str, limits: ReadLimits = DEFAULT_LIMITS) -> None:
    with pytest.raises(MeshFileError) as caught:
        read_mesh(path, limits=limits)
    assert part in str(caught.value)
    assert str(path) in str(caught.value)
    assert caught.value.path == path


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="POSIX permissions")
def test_unreadable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(*args: object) -> int:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "a.obj").write_bytes(SQUARE)
    monkeypatch.setattr(os, "open", denied)  # chmod would not keep root out
    _refused(tmp_path / "a.obj", "Permission denied")


@pytest.mark.parametrize(
    ("name", "format_"), [("a.stl", "STL"), ("a.GLB", "glTF"), ("a.gltf", "glTF")]
)
def test_formats_without_quads_are_refused_for_that_reason(name: str, format_: str) -> None:
    with pytest.raises(UnsupportedFormatError, match=f"{format_} holds triangles only.*export"):
        read_mesh(name)


@pytest.mark.parametrize("name", ["a.blend", "a.fbx", "a", "a.obj.gz", ".obj"])
def test_unknown_formats_are_told_the_known(name: str) -> None:
    with pytest.raises(UnsupportedFormatError, match=r"unknown.*\.obj \.ply \.vtk") as caught:
        read_mesh(name)
    assert " ".join(SUPPORTED_SUFFIXES) in str(caught.value)


def test_the_registry_says_what_each_format_is() -> None:
    assert len(set(SUPPORTED_SUFFIXES)) == len(SUPPORTED_SUFFIXES)
    assert len({entry.name for entry in FORMATS}) == len(FORMATS)
    for entry in FORMATS:
        assert entry.help and "\n" not in entry.help
        assert all(find_format(f"a{suffix.upper()}") is entry for suffix in entry.suffixes)
        assert all(suffix == suffix.lower() and suffix[0] == "." for suffix in entry.suffixes)


def test_the_heavy_libraries_are_imported_only_for_their_formats(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_bytes(SQUARE)
    script = (
        "import sys; from ingest.formats import read_mesh; read_mesh(sys.argv[1]); "
        "print([m for m in ('pyvista', 'vtkmodules', 'pxr') if m in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "a.obj")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == "[]"


def test_a_few_thousand_damaged_files() -> None:
    run = subprocess.run(
        [
            sys.executable,
            "-m",
            "benchmarks.fuzz_readers",
            "--files",
            "8000",
            "--seed",
            "7",
            "--jobs",
            "2",
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    summary = json.loads(run.stdout)
    # Slowness is left to the benchmark: a busy machine is no failure of the reader.
    failures = [failure for failure in summary["failures"] if "s to read" not in failure["wrong"]]
    assert failures == []
    assert summary["files"] == 8000
    assert summary["accepted"] > 500
    assert summary["refused"] > 500
