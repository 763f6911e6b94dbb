"""The systems of a class, ready for testing: what does not depend on the boundary.

Every signature stands for one system, a graph whose nodes are the sides and whose edges
are the classes of polychords that join them; see :mod:`query.solving.matching`.
"""

from __future__ import annotations

import weakref
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from query.solving.colouring import two_colour

Int16Array = NDArray[np.int16]


class Graphs(NamedTuple):
    """The graphs of s systems of w sides and of c classes in all.

    A named tuple and no dataclass, since kernels take it whole.

    first:      (s + 1,) int32 graph r has the classes first[r]..first[r + 1] - 1.
    class_i, class_j: (c,) int16 the sides that a class joins, in the order in which
                :func:`query.solving.halves.meet` fills them.
    near_first: (s, w + 1) int32 side i of graph r is joined to the sides
                near[near_first[r, i] : near_first[r, i + 1]].
    near:       (d,) int16; a side joined to itself is listed once.
    """

    first: Int32Array
    class_i: Int16Array
    class_j: Int16Array
    near_first: Int32Array
    near: Int16Array


class Systems(NamedTuple):
    """All that a query needs of s signatures.

    graphs:     the sides that their polychords join.
    base:       (s, w) int16 base length of every side.
    perimeter:  (s,) int32 sum of the base lengths.
    looped:     (s, w) bool is the side joined to itself?
    component, colour: (s, w) int16 of :func:`query.solving.colouring.two_colour`.
    parity:     (s,) bool can parity refuse an even perimeter? Not in a graph that is in one
                piece and has an odd cycle.
    """

    graphs: Graphs
    base: Int16Array
    perimeter: Int32Array
    looped: NDArray[np.bool_]
    component: Int16Array
    colour: Int16Array
    parity: NDArray[np.bool_]


#: The systems of the classes in use, by the identity of their joins, and what keeps them
#: apart from a later array at the same address.
_known: dict[int, tuple[weakref.ref[NDArray[np.int32]], Systems]] = {}


class Signed(Protocol):
    """Rows with signatures: patterns of a class, or marked patterns of as many sides.

    The fields are those of :class:`patterndb.core.patternclass.PatternClass`.
    """

    @property
    def signature(self) -> Int32Array: ...
    @property
    def rotation(self) -> Int32Array: ...
    @property
    def reflected(self) -> NDArray[np.bool_]: ...
    @property
    def lengths(self) -> Int32Array: ...
    @property
    def joins(self) -> Int32Array: ...


def systems_of(patterns: Signed) -> Systems:
    """The systems of the rows; made at the first call, and kept as long as the rows are."""
    key = id(patterns.joins)
    known = _known.get(key)
    if known is not None and known[0]() is patterns.joins:
        return known[1]
    made = make_systems(patterns.lengths, patterns.joins)

    def forget(gone: weakref.ref[NDArray[np.int32]]) -> None:
        if _known.get(key, (None,))[0] is gone:
            del _known[key]

    _known[key] = weakref.ref(patterns.joins, forget), made
    return made


def make_systems(lengths: Int32Array, joins: Int32Array) -> Systems:
    """The systems of (s, w) base lengths and (s, w, w) joins; see :class:`Signed`."""
    s, w = lengths.shape
    joined = joins > 0
    n_near = int(joined.sum())
    n_loops = int(np.diagonal(joined, axis1=1, axis2=2).sum())
    n_classes = (n_near + n_loops) // 2
    graphs = Graphs(
        first=np.zeros(s + 1, np.int32),
        class_i=np.empty(n_classes, np.int16),
        class_j=np.empty(n_classes, np.int16),
        near_first=np.zeros((s, w + 1), np.int32),
        near=np.empty(n_near, np.int16),
    )
    made = Systems(
        graphs,
        # Longer than any boundary is long enough.
        base=np.minimum(lengths, np.iinfo(np.int16).max).astype(np.int16),
        perimeter=lengths.sum(axis=1, dtype=np.int32),
        looped=np.ascontiguousarray(np.diagonal(joined, axis1=1, axis2=2)),
        component=np.empty((s, w), np.int16),
        colour=np.empty((s, w), np.int16),
        parity=np.empty(s, np.bool_),
    )
    _fill(made, joined)
    return made


@kernel
def _fill(made: Systems, joined: NDArray[np.bool_]) -> None:
    """Write all but the lengths; joined: (s, w, w) bool, symmetric."""
    first, class_i_of, class_j_of, near_first, near = made.graphs
    n, w = made.base.shape
    most = w * (w + 1) // 2
    class_i = np.empty(most, np.int32)
    class_j = np.empty(most, np.int32)
    closed = np.zeros(most, np.bool_)
    component = np.empty(w, np.int32)
    colour = np.empty(w, np.int32)
    stack = np.empty(w, np.int32)
    at = 0
    c = 0
    for r in range(n):
        at = list_neighbours(joined[r], near_first[r], near, at)
        m = order_classes(joined[r], class_i, class_j, stack)
        first[r] = c
        for k in range(m):
            class_i_of[c] = class_i[k]
            class_j_of[c] = class_j[k]
            c += 1
        two_colour(class_i, class_j, m, closed, component, colour, stack)
        made.parity[r] = False
        for i in range(w):
            made.component[r, i] = component[i]
            made.colour[r, i] = colour[i]
            made.parity[r] |= component[i] > 0 or colour[i] != 0
    first[n] = c


@kernel
def list_neighbours(
    joined: NDArray[np.bool_], near_first: Int32Array, near: Int16Array, at: int
) -> int:
    """Write one graph's lists of neighbours from ``near[at]`` on; return where they end.

    joined: (w, w) bool, symmetric; near_first: (w + 1,).
    """
    w = len(joined)
    for i in range(w):
        near_first[i] = at
        for j in range(w):
            if joined[i, j]:
                near[at] = j
                at += 1
    near_first[w] = at
    return at


@kernel
def order_classes(
    joined: NDArray[np.bool_],
    class_i: Int32Array | Int16Array,
    class_j: Int32Array | Int16Array,
    left: Int32Array,
) -> int:
    """List the classes, those of the side with the fewest first, and return their number.

    A side that has one class leaves it no choice, so taking as much as possible of each
    in this order often meets every side. What a side sends to itself is its last resort.
    joined: (w, w) bool, symmetric; left: (w,) int32 scratch.
    """
    w = len(joined)
    for i in range(w):
        left[i] = 0
        for j in range(w):
            left[i] += joined[i, j]
    m = 0
    for _ in range(w):
        side = -1
        for i in range(w):
            if left[i] >= 0 and (side < 0 or left[i] < left[side]):
                side = i
        for j in range(w):
            if joined[side, j] and j != side and left[j] >= 0:
                class_i[m] = side
                class_j[m] = j
                m += 1
                left[j] -= 1
        if joined[side, side]:
            class_i[m] = side
            class_j[m] = side
            m += 1
        left[side] = -1
    return m
