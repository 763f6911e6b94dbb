"""Constructed fills: an answer for every boundary, put together of parts.

Four constructions: a grid laid anywhere (never fails); a fill of a table in which corners
are dropped; pentagons of one valence-5 vertex cut off until a table knows the rest; and
chords that prolong a side through a reflex corner. Each is decided on the counts of
irregular vertices that the parts need, and only then expanded.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush

import numpy as np

from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidCodeError
from query.boundary import Boundary
from query.cancellation import NEVER, CancelFlag, raise_if_cancelled
from query.construct.plan import Lookup, Plan, carry_out_plan, count_least
from query.construct.planner import Planner
from query.errors import InvalidQueryError
from query.fill import Fill
from query.recognition import (
    count_asked_quads,
    count_irregular,
    count_quads,
    hash_quads,
    read_welded_fill,
)

#: What fills and patterns that were constructed give as their origin.
ORIGIN = "constructed"


#: Quads more or fewer than asked for that a vertex may have. A grid needs 2, where its
#: corner falls on a reflex one.
MOST_OFF = 2


@dataclass(frozen=True, slots=True, order=True)
class _Outcome:
    """What a plan comes to: how its fill ranks, and which it is."""

    n_irregular: int
    n_irregular_boundary: int
    n_quads: int
    key: bytes
    plan: Plan = field(compare=False)


def construct_fills(
    boundary: Boundary,
    lookup: Lookup,
    *,
    strict: bool = False,
    limit: int | None = None,
    grid_only: bool = False,
    cancelled: CancelFlag = NEVER,
) -> Iterator[Fill]:
    """Fills that are put together for a boundary, best first.

    In order of irregular vertices, of those on the boundary, of quads, and then of the
    fills' codes, so that the list is the same every time; no fill comes twice. There is
    always one, except with ``strict``: then only fills whose corners are exactly as asked.
    The fills are those that the constructions arrive at within fixed numbers of tries, a few
    dozen at most, and the first ``limit`` of them. lookup: fills for parts with few sides.
    Its own fill of the whole boundary is not listed: whoever has the lookup has that.
    grid_only: no more than the grid, which takes no search.

    Raises InvalidQueryError for a limit below 1, QueryCancelledError while one iterates once
    ``cancelled`` is set.
    """
    if limit is not None and limit < 1:
        raise InvalidQueryError(f"limit is {limit}; ask for at least 1, or None for all")
    planner = Planner(lookup, cancelled)
    return _list_fills(boundary, planner, lookup, strict, limit, grid_only)


def _list_fills(
    boundary: Boundary,
    planner: Planner,
    lookup: Lookup,
    strict: bool,
    limit: int | None,
    grid_only: bool,
) -> Iterator[Fill]:
    # Plans are carried out only while one might still come before the best so far.
    if grid_only:
        plans = planner.plan_rectangle(boundary, strict)
    else:
        plans = planner.plans(boundary, strict)
    waiting = sorted(((count_least(plan), at, plan) for at, plan in enumerate(plans)), reverse=True)
    ready: list[_Outcome] = []
    welder = _Welder(boundary, lookup)
    seen: set[bytes] = set()
    listed = 0
    while listed != limit:
        while waiting and (not ready or waiting[-1][0] <= ready[0].n_irregular):
            raise_if_cancelled(planner.cancelled)
            outcome = _outcome(waiting.pop()[2], welder)
            if outcome is None or outcome.key in seen:
                continue
            seen.add(outcome.key)
            if not strict or outcome.n_irregular_boundary == 0:
                heappush(ready, outcome)
        if not ready:
            return
        try:
            fill = read_welded_fill(*welder.weld(heappop(ready).plan), boundary, ORIGIN)
        except InvalidCodeError:
            # Its pattern has more quads than a code can name: it cannot be told of.
            continue
        listed += 1
        yield fill


class _Welder:
    """Carries out plans for a boundary. The last is kept: mostly its fill is asked for next, and
    the quads of all together would take more memory than they save time."""

    def __init__(self, boundary: Boundary, lookup: Lookup) -> None:
        self.boundary = boundary
        self._lookup = lookup
        self._last: tuple[Plan, tuple[Int32Array, int, Int32Array], int] | None = None

    def weld(self, plan: Plan) -> tuple[Int32Array, int, Int32Array]:
        """Return quads (q, 4), the number of their vertices, and half-edges (4q,)."""
        return self._carry_out(plan)[0]

    def find_fault(self, plan: Plan) -> int:
        """What :func:`weld_quads` says of the quads; 0 where nothing is wrong."""
        return self._carry_out(plan)[1]

    def _carry_out(self, plan: Plan) -> tuple[tuple[Int32Array, int, Int32Array], int]:
        if self._last is None or self._last[0] is not plan:
            perimeter = self.boundary.perimeter
            quads, n_vertices = carry_out_plan(plan, perimeter, self._lookup)
            twin, fault = weld_quads(quads, n_vertices, perimeter)
            self._last = plan, (quads, n_vertices, twin), fault
        return self._last[1:]


def _outcome(plan: Plan, welder: _Welder) -> _Outcome | None:
    """None where the parts do not join to a mesh, or leave a doublet, or where irregular
    vertices of several parts meet in one that is off by more than MOST_OFF quads."""
    boundary = welder.boundary
    quads, n_vertices, twin = welder.weld(plan)
    count = count_quads(quads, n_vertices)
    off = np.abs(count - count_asked_quads(boundary, n_vertices))
    if welder.find_fault(plan) or (count[boundary.perimeter :] < 3).any() or off.max() > MOST_OFF:
        return None
    inner, outer = count_irregular(count, boundary)
    key = hash_quads(quads, twin, boundary.n_sides == 0)
    return _Outcome(inner + outer, outer, len(quads), key, plan)
