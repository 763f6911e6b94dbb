"""Kernels that came with the package: found without compiling, or not used and told why."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from shared import CHECKOUT

from patterndb.system import kernelpack
from patterndb.system.caches import KERNELS_VARIABLE
from patterndb.system.compiling import COMPILED, read_work_clock
from patterndb.system.kernellist import (
    find_kernel,
    format_kernel,
    parse_kernel,
    read_list,
)
from patterndb.system.kernelpack import PACK_VARIABLE, find_pack, write_pack
from patterndb.system.kerneltypes import make_type, spell_type
from patterndb.system.warming import compile_listed

#: Runs a kernel on what it is given, and tells how it came by it.
SCRIPT = """
import json, sys
import numpy as np
from patterndb.system.caches import kernel_folder
from patterndb.system.compiling import COMPILED
from patterndb.system.kernels import find_shipped
from patterndb.core.polychord import trace
from patterndb.core.label import label_word
chord, sides = trace(np.array([-1, -1, -1, -1], np.int32))[:2]
pack, reason = find_shipped()
print(json.dumps([COMPILED.kernels, pack is not None, reason, str(kernel_folder() or "")]))
"""

#: A kernel that calls no other, of the types that the list has for it.
NAME = "patterndb.core.polychord:trace"


def run(environment: dict[str, str], before: str = "") -> tuple[int, bool, str, str]:
    done = subprocess.run(
        [sys.executable, "-c", before + SCRIPT],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    compiled, used, reason, folder = json.loads(done.stdout)
    return compiled, used, reason, folder


@pytest.fixture(scope="module")
def pack(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pack of one kernel, made for the plainest processor of this kind."""
    folder = tmp_path_factory.mktemp("pack")
    listed = [kernel for kernel in read_list() if f"{kernel.module}:{kernel.name}" == NAME]
    lines = "".join(format_kernel(kernel) + "\n" for kernel in listed)
    (folder / "list.jsonl").write_text(lines)
    script = CHECKOUT / "scripts" / "pack_kernels.py"
    made = folder / "kernels.pack"
    subprocess.run(
        [sys.executable, script, "--list", folder / "list.jsonl", "-o", made],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        check=True,
        capture_output=True,
    )
    return made


def test_a_packed_kernel_is_not_compiled(pack: Path, tmp_path: Path) -> None:
    empty = str(tmp_path / "kernels")
    shipped = {PACK_VARIABLE: str(pack), KERNELS_VARIABLE: empty}
    assert run(shipped) == (0, True, "", empty)
    assert not list(Path(empty).iterdir())
    compiled, used, reason, _ = run({PACK_VARIABLE: "", KERNELS_VARIABLE: empty})
    assert compiled > 0 and not used and PACK_VARIABLE in reason
    # What was compiled here is found again; the pack is not needed for it.
    assert run({PACK_VARIABLE: "", KERNELS_VARIABLE: empty})[0] == 0


def test_for_another_compiler_kernels_are_compiled(pack: Path, tmp_path: Path) -> None:
    shipped = {PACK_VARIABLE: str(pack), KERNELS_VARIABLE: str(tmp_path)}
    compiled, used, reason, _ = run(shipped, "import numba; numba.__version__ = '0.1.2'\n")
    assert compiled > 0 and not used and "are for Python" in reason


@pytest.mark.parametrize(
    ("stamp", "triple", "words"),
    [("other", "t", "are for Python"), ("s", "other", "are for t"), ("s", "t", "")],
)
def test_what_a_pack_is_for(
    stamp: str, triple: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "kernels.pack"
    write_pack(path, [("a", b"code")], stamp="s", triple="t", needs=[])
    monkeypatch.setenv(PACK_VARIABLE, str(path))
    found, reason = find_pack.__wrapped__(stamp, triple)
    assert words in reason and (found is None) == bool(words)


@pytest.mark.parametrize(
    ("needs", "content", "words"),
    [
        (["no-such-feature"], None, "need a processor with no-such-feature"),
        ([], b"", "none came"),
        ([], b"no pack at all", "damaged"),
        ([], kernelpack.MAGIC, "damaged"),
        ([], kernelpack.MAGIC + bytes(40), "damaged"),
        ([], None, ""),
    ],
)
def test_why_a_pack_is_not_used(
    needs: list[str],
    content: bytes | None,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "kernels.pack"
    write_pack(path, [("a", b"code"), ("b", b"")], stamp="s", triple="t", needs=needs)
    if content is not None:
        path.write_bytes(content)
    monkeypatch.setenv(PACK_VARIABLE, str(path))
    found, reason = find_pack.__wrapped__("s", "t")
    assert words in reason and (found is None) == bool(words)
    if found is not None:
        assert (found.read("a"), found.read("b"), found.read("c")) == (b"code", b"", None)


def test_a_damaged_entry_is_as_if_it_were_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "kernels.pack"
    write_pack(path, [("a", b"code" * 99)], stamp="s", triple="t", needs=[])
    path.write_bytes(path.read_bytes()[:-3] + b"\0\0\0")
    monkeypatch.setenv(PACK_VARIABLE, str(path))
    found, _ = find_pack.__wrapped__("s", "t")
    assert found is not None and found.read("a") is None


class TestList:
    def test_names_kernels_that_there_are(self) -> None:
        """If it does not: python scripts/record_kernels.py."""
        for kernel in read_list():
            found = find_kernel(kernel)
            assert found is not None, f"{kernel.module}.{kernel.name} is no more"
            dispatcher, types = found
            count = dispatcher.py_func.__code__.co_argcount
            assert len(types) == count, f"{kernel.module}.{kernel.name} has {count} arguments"

    def test_lines_and_types_come_back(self) -> None:
        for kernel in read_list():
            assert parse_kernel(format_kernel(kernel)) == kernel
            for spelled in kernel.types:
                assert json.dumps(spell_type(make_type(spelled))) == json.dumps(spelled)

    def test_is_in_order_without_doubles(self) -> None:
        keys = [kernel.key for kernel in read_list()]
        assert keys == sorted(set(keys))

    def test_a_kernel_that_is_no_more_is_passed_over(self, tmp_path: Path) -> None:
        listed = next(k for k in read_list() if f"{k.module}:{k.name}" == NAME)
        lines = [
            format_kernel(listed),
            format_kernel(listed).replace(":trace", ":no_such"),
            format_kernel(listed).replace("polychord", "no_such_module"),
            format_kernel(listed).replace("int32 1C", "float64"),
        ]
        kernels = [parse_kernel(line) for line in lines]
        told: list[tuple[int, int]] = []
        made = compile_listed(
            kernels,
            processes=2,
            progress=lambda done, total, left: told.append((done, total)),
            environment={KERNELS_VARIABLE: str(tmp_path), PACK_VARIABLE: ""},
        )
        assert made.there == [kernels[0]]
        assert sorted(made.gone, key=lambda k: k.key) == sorted(kernels[1:3], key=lambda k: k.key)
        assert [kernel for kernel, _ in made.failed] == [kernels[3]]
        assert told == [(k, 4) for k in (1, 2, 3, 4)]
        assert any(path.is_file() for path in tmp_path.rglob("*"))


def test_the_clock_stands_still_while_something_is_compiled() -> None:
    begun = read_work_clock()
    COMPILED.begin()
    try:
        held = read_work_clock()
        COMPILED.begin()
        assert read_work_clock() == held >= begun
        COMPILED.end(0)
        assert COMPILED.is_compiling()
        assert read_work_clock() == held
    finally:
        COMPILED.end(0)
    assert not COMPILED.is_compiling()
    assert read_work_clock() >= held


def test_what_is_done_ahead_is_done_until_it_says_that_it_is_done(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calls: list[bool] = []

    def ahead() -> bool:
        calls.append(COMPILED.is_compiling())
        return len(calls) < 2

    monkeypatch.setattr(COMPILED, "ahead", ahead)
    assert COMPILED.compile_ahead()
    assert COMPILED.compile_ahead()
    assert not COMPILED.compile_ahead()
    assert calls == [True, True]
