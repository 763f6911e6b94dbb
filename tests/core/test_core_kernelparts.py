"""Kernels are compiled after what they call, each once."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.system import kernelparts
from patterndb.system.kernellist import ListedKernel, read_list
from patterndb.system.kernelparts import (
    CompileOrder,
    KernelPart,
    format_part,
    name_part,
    read_parts,
)


def kernel_of(number: int) -> ListedKernel:
    return ListedKernel("m", f"k{number}", ("int64",), (), 1)


@given(
    st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=20),
    st.sets(st.integers(0, 7)),
    st.integers(1, 3),
    st.randoms(use_true_random=False),
)
def test_every_kernel_comes_once_and_after_what_it_calls(
    pairs: list[tuple[int, int]], asked: set[int], width: int, chance: object
) -> None:
    # Who calls whom, without rings.
    calls = {n: {b for a, b in pairs if a == n and b > n} for n in range(8)}
    names = [name_part(kernel_of(n)) for n in range(8)]
    parts = {
        names[n]: KernelPart(kernel_of(n), tuple(names[c] for c in sorted(calls[n])))
        for n in range(8)
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernelparts, "read_parts", lambda: parts)
        order = CompileOrder([kernel_of(n) for n in sorted(asked)])
    reached = set(asked)
    while more := {c for n in reached for c in calls[n]} - reached:
        reached |= more
    assert len(order) == len(reached)
    done: list[str] = []
    at_work: list[str] = []
    while not order.is_over() or at_work:
        while len(at_work) < width and (taken := order.take()) is not None:
            name, kernel = taken
            assert name == name_part(kernel)
            assert {names[c] for c in calls[names.index(name)]} <= set(done)
            at_work.append(name)
        # Something can always be done.
        name = at_work.pop(chance.randrange(len(at_work)))  # type: ignore[attr-defined]
        order.finish(name)
        done.append(name)
    assert sorted(done) == sorted(names[n] for n in reached)


def test_kernels_that_call_each_other_come_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    a, b, c = (name_part(kernel_of(n)) for n in range(3))
    parts = {
        a: KernelPart(kernel_of(0), (a, b)),
        b: KernelPart(kernel_of(1), (a,)),
        c: KernelPart(kernel_of(2), (a,)),
    }
    monkeypatch.setattr(kernelparts, "read_parts", lambda: parts)
    order = CompileOrder([kernel_of(2)])
    done: list[str] = []
    while (taken := order.take()) is not None:
        order.finish(taken[0])
        done.append(taken[0])
    assert order.is_over() and sorted(done) == sorted([a, b, c])
    assert done[-1] == c


def test_a_kernel_that_the_parts_do_not_know_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernelparts, "read_parts", dict)
    order = CompileOrder([kernel_of(0)])
    assert order.take() == (name_part(kernel_of(0)), kernel_of(0))
    assert order.take() is None and order.is_over()


def test_lines_come_back_and_stand_in_order() -> None:
    """If they do not: python scripts/record_parts.py."""
    parts = read_parts()
    path = Path(kernelparts.__file__).parents[1] / "data" / kernelparts.PARTS_NAME
    assert [format_part(part) for part in parts.values()] == path.read_text().splitlines()
    keys = [part.kernel.key for part in parts.values()]
    assert keys == sorted(set(keys))
    for name, part in parts.items():
        assert name == name_part(part.kernel)
        assert set(part.calls) <= set(parts), json.dumps(part.kernel.key)


def test_nearly_all_kernels_of_the_list_have_their_parts() -> None:
    """If they do not: python scripts/record_parts.py."""
    listed = read_list()
    known = read_parts()
    assert sum(name_part(kernel) in known for kernel in listed) >= 0.8 * len(listed)
