"""The linear systems that widths solve, of all signatures of a class of patterns.

For every side s the widths of the polychords that end on it add up to the edges asked
for; a polychord with both ends on s counts twice (Marcias et al. 2015, section 4). The
polychords of one pattern that join the same two sides form a *class*: only the sum of
their widths matters to the sides. With slack = edges asked for - base length, the sums
solve an uncapacitated b-matching on the sides (rust/query/src/solving/matching.rs).

Every signature stands for one system, a graph whose nodes are the sides and whose edges are the
classes of polychords that join them. :class:`Systems` has those of a class ready for testing.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.solving.systems import list_systems
from patterndb.core.halfedge import Int32Array
from patterndb.core.patternclass import PatternClass

Int16Array = NDArray[np.int16]


@dataclass(frozen=True, slots=True, eq=False)
class Systems:
    """The systems of s signatures of w sides, with c classes in all.

    The compiled core takes it whole.

    first:      (s + 1,) int32 system r has the classes first[r]..first[r + 1] - 1.
    class_i, class_j: (c,) int16 the sides that a class joins, in the order in which
                the flow fills them.
    claim:      (s, w) int32 what a side asks of its neighbours: a *claim* is a side and the sides
                that it is joined to. There are far fewer of them than sides of all systems.
    claimant:   (k,) int16 the side that makes a claim.
    near_first: (k + 1,) int32 the sides of claim q are near[near_first[q] : near_first[q + 1]].
    near:       (d,) int16; a side joined to itself is listed once.
    base:       (s, w) int16 base length of every side.
    pairs:      (s, ceil(w / 2)) uint8 the base lengths of each two sides in one number, see
                rust/query/src/solving/sieve.rs.
    perimeter:  (s,) int32 sum of the base lengths.
    surplus:    (s, w) uint8 one more than what the base lengths of a side's neighbours have beyond
                its own, cut off at 127: a weaker sieve, no other answer; 0 where the side is joined
                to itself and asks no other.
    component, colour: (s, w) int16 the first side of each side's component, and its colour where
                classes join unlike ones: 1, -1, or 0 where there is no such colouring.
    parity:     (s,) bool can parity reject an even perimeter? Not in a graph that is in one
                piece and has an odd cycle.
    graph, hall_first, hall: (s,), (g + 1,), (h,) int32: the Hall conditions of system r are
                hall[hall_first[graph[r]] : hall_first[graph[r] + 1]].
    """

    first: Int32Array
    class_i: Int16Array
    class_j: Int16Array
    claim: Int32Array
    claimant: Int16Array
    near_first: Int32Array
    near: Int16Array
    base: Int16Array
    pairs: NDArray[np.uint8]
    perimeter: Int32Array
    surplus: NDArray[np.uint8]
    component: Int16Array
    colour: Int16Array
    parity: NDArray[np.bool_]
    graph: Int32Array
    hall_first: Int32Array
    hall: Int32Array

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


#: The systems of the classes in use, by the identity of their joins, and what keeps them
#: apart from a later array at the same address.
_known: dict[int, tuple[weakref.ref[NDArray[np.integer]], Systems]] = {}

#: The name of systems among the arrays cached with a class; changed whenever their arrays are.
SHELVED_SYSTEMS = "systems-4"


class SignatureRows(Protocol):
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
    def lengths(self) -> NDArray[np.integer]: ...
    @property
    def joins(self) -> NDArray[np.integer]: ...


def systems_of(patterns: SignatureRows) -> Systems:
    """The systems of the rows; made at the first call, and kept as long as the rows are."""
    key = id(patterns.joins)
    known = _known.get(key)
    if known is not None and known[0]() is patterns.joins:
        return known[1]
    cache = patterns.cache if isinstance(patterns, PatternClass) else None
    if cache is None:
        made = make_systems(patterns.lengths, patterns.joins)
    else:
        made = Systems(
            **cache.find_or_make(
                f"{patterns.lengths.shape[1]}-{SHELVED_SYSTEMS}",
                lambda: make_systems(patterns.lengths, patterns.joins, with_hall=True).to_arrays(),
            )
        )

    def forget(gone: weakref.ref[NDArray[np.integer]]) -> None:
        if _known.get(key, (None,))[0] is gone:
            del _known[key]

    _known[key] = weakref.ref(patterns.joins, forget), made
    return made


def make_systems(
    lengths: NDArray[np.integer], joins: NDArray[np.integer], *, with_hall: bool = False
) -> Systems:
    """The systems of (s, w) base lengths and (s, w, w) joins; see :class:`SignatureRows`.

    with_hall: with the Hall conditions of up to 15 sides, which take longer to list than all else
    and pay where they are kept.
    """
    # Longer than any boundary is long enough.
    base = np.minimum(lengths.astype(np.int32), np.iinfo(np.int16).max).astype(np.int16)
    return Systems(
        base=base,
        perimeter=lengths.sum(axis=1, dtype=np.int32),
        **list_systems(base, joins > 0, with_hall),
    )
