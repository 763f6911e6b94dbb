"""The width problem by OR-Tools CP-SAT: a second solver that the compiled core is held to.

:class:`query.solving.widths.WidthSolver` calls it where it is asked for. Every model runs with one
worker: enumerate_all_solutions with several workers loses and repeats solutions, and reports
OPTIMAL all the same. Systems run side by side instead.
"""

from __future__ import annotations

import itertools
import os
import threading
from bisect import bisect_right
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.label import split_word
from patterndb.system.deadline import LOOK_SECONDS, begin_task
from patterndb.system.extras import require_extra
from query.cancellation import CancelFlag, raise_if_cancelled, wait_unless_cancelled
from query.errors import SolverError
from query.solving.problem import OFF, BestWidths, Labels, WidthProblem


def _cp_model() -> Any:
    """OR-Tools, imported only when this solver is asked for."""
    require_extra("sketch", 'solver="cp-sat" (not the default, "kernel")')
    from ortools.sat.python import cp_model

    return cp_model


#: Systems that threads are given at a time.
HANDED_OVER = 256


@dataclass(frozen=True, slots=True)
class _Pattern:
    """The open polychords of one pattern, in label order.

    edges: the polychord that crosses each edge of the boundary when all widths are 1, side by side.
    side_start: where each side begins in ``edges``, and where the last ends.
    ends:  the two edges, ascending, of each polychord.
    """

    edges: list[int]
    side_start: list[int]
    ends: list[tuple[int, int]]

    @classmethod
    def of_row(cls, labels: Labels, row: int) -> _Pattern:
        """From the label of a row."""
        word = labels.words[labels.start[row] : labels.start[row + 1]]
        label = split_word(word, labels.n_sides)
        edges = [chord for side in label for chord in side]
        at: dict[int, list[int]] = {}
        for place, chord in enumerate(edges):
            at.setdefault(chord, []).append(place)
        ends = [(at[chord][0], at[chord][1]) for chord in range(len(at))]
        return cls(edges, [0, *itertools.accumulate(map(len, label))], ends)

    def side_of(self, edge: int) -> int:
        """The side that an edge is on."""
        return bisect_right(self.side_start, edge) - 1

    @property
    def sides(self) -> list[tuple[int, int]]:
        """The two sides that each polychord joins."""
        return [(self.side_of(first), self.side_of(second)) for first, second in self.ends]


@dataclass(frozen=True, slots=True)
class Carrier:
    """The polychord that carries a stroke.

    first, second: the edges of the pattern's boundary where the stroke's ends leave it.
    rank, of: the stroke is number ``rank`` of the ``of`` on this polychord, in the order in
              which its end with the smaller number sees them.
    """

    first: int
    second: int
    rank: int
    of: int


class _Model:
    """Widths of the open polychords, with the sides' lengths as constraints."""

    def __init__(self, pattern: _Pattern, lengths: list[int], cancelled: CancelFlag) -> None:
        self.pattern = pattern
        self.lengths = lengths
        self.cancelled = cancelled
        self.cp = _cp_model()
        self.model = self.cp.CpModel()
        sides = pattern.sides
        most = [max(1, lengths[i]) for i, _ in sides]
        self.x = [self.model.new_int_var(1, top, f"x{c}") for c, top in enumerate(most)]
        ends: list[list[Any]] = [[] for _ in lengths]
        for x, (i, j) in zip(self.x, sides, strict=True):
            ends[i].append(x)
            ends[j].append(x)
        for side, length in zip(ends, lengths, strict=True):
            self.model.add(sum(side) == length)

    def add_strokes(
        self, strokes: Int32Array, tolerance: int, carriers: tuple[Carrier, ...]
    ) -> None:
        """Strands 1 wide on the strokes: the paper's x_q = x_q0 + 1 + x_q1, and what follows.

        The edges that each end is off become variables after the widths.
        """
        parts: dict[int, list[Any]] = {}
        off: list[Any] = []
        model, edges, most = self.model, self.pattern.edges, max(self.lengths)
        for s, (carrier, row) in enumerate(zip(carriers, strokes.tolist(), strict=True)):
            chord = edges[carrier.first]
            if chord not in parts:
                parts[chord] = [
                    model.new_int_var(0, most, f"u{s}-{t}") for t in range(carrier.of + 1)
                ]
                model.add(self.x[chord] == sum(parts[chord]) + carrier.of)
            for at, side, edge in zip(
                (carrier.first, carrier.second), row[::2], row[1::2], strict=True
            ):
                # The end with the greater number sees the strokes in reverse.
                reverse = at == max(carrier.first, carrier.second)
                rank = carrier.of - 1 - carrier.rank if reverse else carrier.rank
                own = parts[chord][::-1] if reverse else parts[chord]
                before = sum(self.x[c] for c in edges[self.pattern.side_start[side] : at])
                d = model.new_int_var(-tolerance, tolerance, f"d{s}-{at}")
                model.add(before + sum(own[: rank + 1]) + rank - d == edge)
                off.append(d)
        self.x = [*self.x, *off]

    def enumerate(self) -> list[tuple[int, ...]]:
        """All solutions."""
        found: list[tuple[int, ...]] = []
        variables = self.x

        class Collect(self.cp.CpSolverSolutionCallback):
            def on_solution_callback(self) -> None:
                found.append(tuple(self.value(x) for x in variables))

        self._solve(Collect(), every=True)
        return found

    def is_feasible(self) -> bool:
        """Is there any solution?"""
        return self._solve(None, every=False)[1] != self.cp.INFEASIBLE

    def _solve(self, callback: Any, *, every: bool) -> tuple[Any, Any]:
        solver = self.cp.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.enumerate_all_solutions = every
        # Python shall see Ctrl-C: OR-Tools would end the one system and go on with the next.
        solver.parameters.catch_sigint_signal = False
        solving = begin_task(partial(solver.solve, self.model, callback))
        try:
            cancelled = not wait_unless_cancelled(solving, self.cancelled)
        except BaseException:
            _leave(solver, solving)
            raise
        if cancelled:
            _leave(solver, solving)
        raise_if_cancelled(self.cancelled)
        status = solving.result()
        if status not in (self.cp.OPTIMAL, self.cp.FEASIBLE, self.cp.INFEASIBLE):
            raise SolverError(f"CP-SAT stopped with status {solver.status_name(status)}")
        return solver, status


def _leave(solver: Any, solving: Future[Any]) -> None:
    """Have a system that nobody waits for any more come to its end: it looks whether it was stopped
    between two of its steps, of which the first may take half a second."""
    if solving.cancel():
        return

    def stop() -> None:
        # What has not begun yet does not hear it.
        while not solving.done():
            solver.stop_search()
            wait([solving], LOOK_SECONDS)

    threading.Thread(target=stop, name="patterndb-stop", daemon=True).start()


def _list_assignments(pattern: _Pattern, strokes: Int32Array) -> Iterator[tuple[Carrier, ...]]:
    """Every way to give each stroke a polychord that joins its sides, and each polychord an
    order of its strokes."""
    choices = [
        [
            (first, second)
            for pair in pattern.ends
            for first, second in (pair, pair[::-1])
            if (pattern.side_of(first), pattern.side_of(second)) == (a, b)
        ]
        for a, _, b, _ in strokes.tolist()
    ]
    for chosen in itertools.product(*choices):
        pairs = sorted({(min(pair), max(pair)) for pair in chosen})
        groups = [
            [s for s, pair in enumerate(chosen) if (min(pair), max(pair)) == both] for both in pairs
        ]
        for orders in _list_orders(groups):
            carriers: list[Carrier] = []
            for s, pair in enumerate(chosen):
                own = next(order for order in orders if s in order)
                carriers.append(Carrier(pair[0], pair[1], own.index(s), len(own)))
            yield tuple(carriers)


def _list_orders(groups: list[list[int]]) -> Iterator[tuple[tuple[int, ...], ...]]:
    """An order for each of the groups, in every way; one at a time, for there are factorials."""
    if not groups:
        yield ()
        return
    for order in itertools.permutations(groups[0]):
        for others in _list_orders(groups[1:]):
            yield (order, *others)


def _list_models(
    pattern: _Pattern, problem: WidthProblem, orientation: int, cancelled: CancelFlag
) -> Iterator[_Model]:
    """A model for every assignment of the strokes to strands; one where there are no strokes."""
    lengths, strokes = problem.lengths[orientation].tolist(), problem.strokes[orientation]
    if not len(strokes):
        yield _Model(pattern, lengths, cancelled)
        return
    for carriers in _list_assignments(pattern, strokes):
        raise_if_cancelled(cancelled)
        model = _Model(pattern, lengths, cancelled)
        model.add_strokes(strokes, problem.tolerance, carriers)
        yield model


def filter_feasible(
    problem: WidthProblem,
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    cancelled: CancelFlag,
    threads: int | None,
) -> NDArray[np.bool_]:
    """Do :meth:`query.solving.widths.WidthSolver.find_feasible`; about a millisecond a system.

    allowed: (r, o) bool.

    Cancelled, it raises QueryCancelledError.
    """

    def fits(at: tuple[int, int]) -> bool:
        raise_if_cancelled(cancelled)
        row, orientation = at
        pattern = _Pattern.of_row(labels, int(rows[row]))
        models = _list_models(pattern, problem, orientation, cancelled)
        return any(model.is_feasible() for model in models)

    result = allowed.copy()
    places = [(r, o) for r, o in np.argwhere(allowed).tolist()]
    found: list[bool] = []
    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        try:
            # All at once would take long to hand over, and to take back.
            while len(found) < len(places):
                found += pool.map(fits, places[len(found) : len(found) + HANDED_OVER])
        except BaseException:
            cancelled[0] = 1
            raise
    result[allowed] = found
    return result


def list_best(
    problem: WidthProblem,
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    keep: int,
    cancelled: CancelFlag,
) -> BestWidths:
    """Do :meth:`query.solving.widths.WidthSolver.find_best`, by a list of every solution.

    Cancelled, it raises QueryCancelledError.
    """
    found: list[tuple[int, int, tuple[int, ...], int]] = []
    for r, row in enumerate(rows.tolist()):
        pattern = _Pattern.of_row(labels, row)
        sides = pattern.sides
        of_row: list[tuple[int, tuple[int, ...], int]] = []
        for o in np.flatnonzero(allowed[r]).tolist():
            weights = [int(problem.weights[o, i, j]) for i, j in sides]
            # The fewest edges that each of the widths is off.
            least: dict[tuple[int, ...], int] = {}
            for model in _list_models(pattern, problem, o, cancelled):
                for values in model.enumerate():
                    widths, off = values[: len(sides)], sum(map(abs, values[len(sides) :]))
                    least[widths] = min(off, least.get(widths, off))
            for widths, off in least.items():
                squares = (w * x * x for w, x in zip(weights, widths, strict=True))
                of_row.append((off * OFF + sum(squares), widths, o))
        found += [(r, key, widths, o) for key, widths, o in sorted(of_row)[:keep]]
    longest = max((len(widths) for _, _, widths, _ in found), default=0)
    table = np.zeros((len(found), longest), np.int32)
    for at, (_, _, widths, _) in enumerate(found):
        table[at, : len(widths)] = widths
    return BestWidths(
        row=np.array([r for r, _, _, _ in found], np.int64),
        key=np.array([key for _, key, _, _ in found], np.int64),
        orientation=np.array([o for _, _, _, o in found], np.int32),
        widths=table,
    )
