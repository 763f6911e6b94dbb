"""Small operations on arrays for kernels, which numba's own would make slow to compile.

The first assignment of one slice to another costs every process that compiles four seconds, for
the text of an error of unequal shapes; ``np.sort`` and ``np.argsort`` cost two each. These cost a
tenth, and do the same.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from patterndb.core.halfedge import Index
from patterndb.system.kernels import kernel


@kernel
def copy_items(source: NDArray[Any], n: Index, target: NDArray[Any], at: Index) -> None:
    """Copy the first n items of ``source`` (k,) to ``target[at:]``; the two may not overlap."""
    for i in range(n):
        target[at + i] = source[i]


@kernel
def copy_rows(source: NDArray[Any], n: Index, target: NDArray[Any]) -> None:
    """Copy the first n rows of ``source`` (k, w) to those of ``target`` (l, w or wider)."""
    for i in range(n):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@kernel
def sort_few(items: NDArray[Any], first: Index, last: Index) -> None:
    """Sort ``items[first:last]`` in place, ascending; meant for some dozens, by insertion."""
    for i in range(first + 1, last):
        item = items[i]
        j = i
        while j > first and items[j - 1] > item:
            items[j] = items[j - 1]
            j -= 1
        items[j] = item
