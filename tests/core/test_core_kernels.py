"""Compiled kernels that are kept: what their key depends on, and what a cache may not break."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import struct
import sys
import textwrap
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba.core import types
from numba.core.errors import TypingError

from patterndb.geometry.tree import make_walk, measure_backwards
from patterndb.system import kernels
from patterndb.system.caches import KERNELS_VARIABLE
from patterndb.system.compiledform import load_compiled
from patterndb.system.kernellist import read_list
from patterndb.system.kernels import ContentCache, kernel
from patterndb.system.kerneltypes import OWN_PACKAGES, make_type, spell_type

SOURCE = """
from patterndb.system.kernels import kernel

FACTOR = 2.0


@kernel
def scale(x):
    "Scale a number."
    return FACTOR * x


@kernel
def total(x):
    "Add three."
    result = 0.0
    for i in range(3):
        result += scale(x) + i
    return result
"""


def run_source(text: str, name: str = "given") -> Any:
    """The names that a module of this text would have."""
    names: dict[str, Any] = {"__name__": name}
    exec(compile(textwrap.dedent(text), f"{name}.py", "exec"), names)
    return SimpleNamespace(**names)


def digest_of(function: Any) -> bytes:
    return function._cache.digest()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder of kernels, and nothing loaded of another."""
    monkeypatch.setenv(KERNELS_VARIABLE, str(tmp_path))
    monkeypatch.setattr(kernels, "_loaded", {})
    return tmp_path


def files_in(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


class TestKey:
    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("FACTOR * x", "FACTOR + x"),  # a kernel that is called
            ("FACTOR = 2.0", "FACTOR = 3.0"),  # a constant that one reads
            ("FACTOR = 2.0", "FACTOR = 2"),  # its type
            ("range(3)", "range(4)"),  # a constant in the code
            ("scale(x) + i", "scale(x) - i"),  # the code
            ("@kernel\ndef total", "@kernel(fastmath=True)\ndef total"),  # an option
            ("@kernel\ndef scale", "@kernel(fastmath=True)\ndef scale"),
        ],
    )
    def test_changes_with_what_a_kernel_is_made_of(self, old: str, new: str) -> None:
        assert SOURCE.replace(old, new) != SOURCE
        changed = run_source(SOURCE.replace(old, new))
        assert digest_of(changed.total) != digest_of(run_source(SOURCE).total)

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("Scale a number.", "Say something else."),
            ("Add three.", "Say something else, and more of it."),
            ("scale", "multiply"),
            ("FACTOR", "SHARE"),
            ("FACTOR = 2.0", "OTHER = 1.0\n# Why.\nFACTOR = 2.0"),
        ],
    )
    def test_does_not_change_with_names_and_docstrings(self, old: str, new: str) -> None:
        assert SOURCE.replace(old, new) != SOURCE
        changed = run_source(SOURCE.replace(old, new), "elsewhere")
        assert digest_of(changed.total) == digest_of(run_source(SOURCE).total)

    def test_changes_with_the_kernels_that_a_made_one_holds(self) -> None:
        @kernel
        def is_beyond(boxes: Any, b: Any, far: Any, asked: Any, bound: Any) -> bool:
            return False

        @kernel
        def is_near(boxes: Any, b: Any, far: Any, asked: Any, bound: Any) -> bool:
            return far > bound

        walks = [make_walk(measure_backwards, f) for f in (is_beyond, is_near, is_beyond)]
        one, other, again = (digest_of(walk) for walk in walks)
        assert one != other
        assert one == again

    @pytest.mark.parametrize("package", sorted(OWN_PACKAGES))
    def test_changes_with_a_constant_of_a_module_of_the_project(self, package: str) -> None:
        assert self._digest_with(f"{package}.given") != self._digest_with(f"{package}.given", 3.0)

    def test_counts_a_module_of_others_by_its_name(self) -> None:
        assert self._digest_with("numpy") == self._digest_with("numpy", 3.0)
        # A name that only begins as one of ours is another's.
        assert self._digest_with("query2") == self._digest_with("query2", 3.0)
        assert self._digest_with("query2") != self._digest_with("numpy")

    @staticmethod
    def _digest_with(module: str, factor: float = 2.0) -> bytes:
        """The digest of a kernel that reads the constant of a module of this name."""
        text = """
        from patterndb.system.kernels import kernel

        @kernel
        def scale(x):
            return held.FACTOR * x
        """
        scale = run_source(text).scale
        scale.py_func.__globals__["held"] = held = ModuleType(module)
        held.__dict__["FACTOR"] = factor
        return digest_of(scale)

    def test_a_kernel_may_call_itself(self) -> None:
        text = """
        from patterndb.system.kernels import kernel

        @kernel
        def count(n):
            return 1 if n == 0 else 1 + count(n - 1)
        """
        assert digest_of(run_source(text).count) == digest_of(run_source(text).count)
        assert digest_of(run_source(text).count) != digest_of(
            run_source(text.replace("1 + count", "2 + count")).count
        )


class TestFolder:
    def test_a_second_kernel_of_the_same_content_is_read(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        assert run_source(SOURCE).total(1.0) == 9.0
        kept = files_in(folder)
        assert kept
        monkeypatch.setattr(kernels, "_loaded", {})
        again = run_source(SOURCE, "elsewhere").total
        assert again(1.0) == 9.0
        assert files_in(folder) == kept
        assert sum(again.stats.cache_hits.values()) == 1

    def test_another_type_is_another_file(self, folder: Path) -> None:
        total = run_source(SOURCE).total
        total(1.0)
        kept = len(files_in(folder))
        assert total(np.float32(1.0)) == 9.0
        assert len(files_in(folder)) > kept

    @pytest.mark.parametrize("damage", [b"", b"no kernel", None])
    def test_a_damaged_file_is_compiled_again(
        self, folder: Path, damage: bytes | None, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        run_source(SOURCE).total(1.0)
        sound = {path: path.read_bytes() for path in files_in(folder)}
        for path, content in sound.items():
            # None: the last byte is lost, as where a disk is full.
            path.write_bytes(content[:-1] if damage is None else damage)
        monkeypatch.setattr(kernels, "_loaded", {})
        again = run_source(SOURCE).total
        assert again(1.0) == 9.0
        assert not again.stats.cache_hits
        monkeypatch.setattr(kernels, "_loaded", {})
        third = run_source(SOURCE).total
        assert third(1.0) == 9.0
        assert third.stats.cache_hits

    def test_without_a_folder_that_can_be_written_kernels_work(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        # A file where the folder should be: nobody can write there, whoever runs the test.
        blocked = folder / "file"
        blocked.write_text("no folder")
        monkeypatch.setenv(KERNELS_VARIABLE, str(blocked / "kernels"))
        assert run_source(SOURCE).total(1.0) == 9.0
        assert files_in(folder) == [blocked]

    def test_a_folder_that_can_only_be_read_is_read(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        run_source(SOURCE).total(1.0)
        kept = files_in(folder)
        monkeypatch.setattr(kernels, "_loaded", {})

        def refuse(*_: object) -> None:
            raise PermissionError

        monkeypatch.setattr(Path, "write_bytes", refuse)
        read = run_source(SOURCE).total
        assert read(1.0) == 9.0
        assert read.stats.cache_hits
        assert run_source(SOURCE.replace("range(3)", "range(2)")).total(1.0) == 5.0
        assert files_in(folder) == kept


class Planted:
    """What unpickles to a call that leaves a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.path),)


def seal(content: bytes) -> bytes:
    """A file of the user's folder as whoever forges it would write it."""
    return hashlib.sha256(content).digest() + content


def change_head(content: bytes, change: Callable[[list[Any]], None]) -> bytes:
    """A compiled kernel with another description."""
    size, code_size = struct.unpack_from("<QQ", content)
    head = json.loads(content[16 : 16 + size])
    change(head)
    told = json.dumps(head).encode()
    return struct.pack("<QQ", len(told), code_size) + told + content[16 + size :]


class TestForm:
    """What is kept runs nothing by being read, whoever wrote it."""

    @pytest.fixture
    def content(self, folder: Path) -> bytes:
        scale = run_source(SOURCE).scale
        scale(1.0)
        kept = scale._cache.read_kept((types.float64,))
        assert kept is not None
        return kept

    def test_a_pickle_in_its_place_is_not_read(
        self, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        run_source(SOURCE).total(1.0)
        planted = tmp_path / "executed"
        hostile = seal(pickle.dumps(Planted(planted)))
        sound = {path: path.read_bytes() for path in files_in(folder)}
        for path in sound:
            path.write_bytes(hostile)
        monkeypatch.setattr(kernels, "_loaded", {})
        again = run_source(SOURCE).total
        assert again(1.0) == 9.0 and not again.stats.cache_hits
        assert not planted.exists()
        # What was compiled took the place of what was planted.
        assert hostile not in [path.read_bytes() for path in sound]
        pickle.loads(hostile[32:])
        assert planted.is_dir()

    @pytest.mark.parametrize(
        "spelled",
        [
            ["antigravity:fly"],
            ["os:system", "int64"],
            ["patterndb.system.caches:Path"],
            ["patterndb.no_such_module:Frames"],
            ["patterndb", "int64"],
            ["tuple", "__loader__"],
            ["literal"],
            ["literal", None],
            [],
            "Array",
            "int64 x",
            "",
            "\ud800",
        ],
    )
    def test_only_types_of_kernels_are_made(
        self, content: bytes, spelled: Any, folder: Path
    ) -> None:
        def change(head: list[Any]) -> None:
            head[7] = spelled

        target = run_source(SOURCE).scale.targetctx
        with pytest.raises(ValueError, match="no compiled kernel"):
            load_compiled(change_head(content, change), (types.float64,), "given", target)
        assert "antigravity" not in sys.modules

    def test_constants_are_types_of_numbers(self, content: bytes) -> None:
        target = run_source(SOURCE).scale.targetctx
        for constants in (["object"], ["V8"], [["f8", "f8"]], "int8", 3, None):

            def change(head: list[Any], constants: Any = constants) -> None:
                head[8] = [head[8][0] + str(constants), constants]

            with pytest.raises(ValueError, match="no compiled kernel"):
                load_compiled(change_head(content, change), (types.float64,), "given", target)

    def test_a_description_of_other_types_is_none(self, content: bytes) -> None:
        target = run_source(SOURCE).scale.targetctx
        for field in range(10):
            for value in (None, 1.5, {"a": 1}, [None], "x"):

                def change(head: list[Any], field: int = field, value: Any = value) -> None:
                    head[field] = value

                if value == "x" and field < 4:
                    continue  # a name like any other
                with pytest.raises(ValueError, match="no compiled kernel"):
                    load_compiled(change_head(content, change), (types.float64,), "given", target)

    @given(st.binary(max_size=80))
    def test_other_bytes_are_none(self, noise: bytes) -> None:
        for content in (noise, struct.pack("<QQ", len(noise), 0) + noise):
            with pytest.raises(ValueError, match="no compiled kernel"):
                load_compiled(content, (types.float64,), "given", None)

    @pytest.mark.parametrize(
        "made",
        [
            types.none,
            types.boolean,
            types.literal(0),
            types.literal(True),
            types.literal("a"),
            types.Optional(types.int64),
            types.Tuple(()),
            types.Tuple((types.literal(3), types.UniTuple(types.float64, 2), types.int8[:, ::1])),
        ],
        ids=str,
    )
    def test_types_come_back(self, made: Any) -> None:
        assert make_type(json.loads(json.dumps(spell_type(made)))) == made

    @pytest.mark.parametrize("returned", ["0", "True", "(1, x)", "None if x > 0 else x", "()"])
    def test_what_a_kernel_returns_is_kept(
        self, returned: str, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        text = f"""
        from patterndb.system.kernels import kernel

        @kernel
        def give(x):
            return {returned}
        """
        first = run_source(text).give
        expected = [first(1.0), first(-1.0)]
        monkeypatch.setattr(kernels, "_loaded", {})
        again = run_source(text).give
        assert [again(1.0), again(-1.0)] == expected
        assert sum(again.stats.cache_hits.values()) == 1
        assert again.overloads.keys() == first.overloads.keys()
        for args, made in again.overloads.items():
            assert made.signature == first.overloads[args].signature


def test_a_kernel_is_called_by_its_function_in_plain_python() -> None:
    scale = run_source(SOURCE).scale
    assert scale.py_func(3.0) == scale(3.0) == 6.0


def list_kernels() -> list[Any]:
    """All kernels of the modules that the list of kernels names."""
    modules = sorted({listed.module for listed in read_list()})
    return [
        one
        for name in modules
        for one in vars(import_module(name)).values()
        if isinstance(getattr(one, "_cache", None), ContentCache)
    ]


def test_kernels_that_borrow_arrays_return_none() -> None:
    # What they return would be given back to its owner once too often.
    borrowing = [one for one in list_kernels() if one.targetoptions.get("_nrt") is False]
    assert borrowing
    scalars = {"None", "bool", "int", "float", "Index", "np.uint64"}
    for one in borrowing:
        told = one.py_func.__annotations__["return"].removeprefix("tuple[").removesuffix("]")
        assert set(told.split(", ")) <= scalars, one.py_func.__qualname__


def test_a_kernel_that_borrows_cannot_make_arrays() -> None:
    @kernel(borrowing=True)
    def make(n: int) -> int:
        return len(np.empty(n))

    with pytest.raises(TypingError):
        make(3)
