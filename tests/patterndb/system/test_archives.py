"""Zip files and arrays of anyone's are read, or refused in one way."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.errors import InvalidMeshError
from patterndb.system.archives import read_array, read_members


def make_zip(**members: bytes) -> bytes:
    told = io.BytesIO()
    with zipfile.ZipFile(told, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return told.getvalue()


def make_array(header: str) -> bytes:
    text = header.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + bytes(80)


def test_members_are_read() -> None:
    data = make_zip(a=b"one", b=b"two")
    assert read_members(data, InvalidMeshError, "a box", max_bytes=6) == {"a": b"one", "b": b"two"}


def test_limits_hold() -> None:
    data = make_zip(a=b"one", b=b"two")
    with pytest.raises(InvalidMeshError, match="a box has more than 5 bytes in its zip"):
        read_members(data, InvalidMeshError, "a box", max_bytes=5)
    with pytest.raises(InvalidMeshError, match="a box has 2 entries in its zip; the limit is 1"):
        read_members(data, InvalidMeshError, "a box", max_bytes=99, max_members=1)


@given(st.data())
def test_damaged_zips_are_read_or_refused(data: st.DataObject) -> None:
    content = bytearray(make_zip(a=b"one" * 20, b=b"two"))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    del content[data.draw(st.integers(0, 10)) : data.draw(st.integers(0, 40))]
    try:
        read_members(bytes(content), InvalidMeshError, "a box", max_bytes=10_000)
    except InvalidMeshError as error:
        assert "a box" in str(error)


def test_arrays_are_read() -> None:
    told = io.BytesIO()
    np.save(told, np.arange(5))
    assert read_array(told.getvalue(), InvalidMeshError, "numbers").tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (10,), ",
        "{'descr': '<f8', 'fortran_order': False, 'shape': ((10,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-10,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1152921504606846976, 9), }",
        "{'descr': '|O', 'fortran_order': False, 'shape': (10,), }",
        "{'descr': '<f9', 'fortran_order': False, 'shape': (10,), }",
        "{'descr': [[]], 'fortran_order': False, 'shape': (10,), }",
        "{'descr': '<f8', 'fortran_order': 1, 'shape': (10,), }",
        "(" * 100,
        "",
    ],
)
def test_damaged_arrays_are_refused(header: str) -> None:
    with pytest.raises(InvalidMeshError, match="numbers are damaged"):
        read_array(make_array(header), InvalidMeshError, "numbers")
