"""The same systems by OR-Tools CP-SAT: the second opinion that the compiled core is held to.

Every model runs with one worker: enumerate_all_solutions with several workers loses and
repeats solutions, and reports OPTIMAL all the same. Systems run side by side instead.
"""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.label import split_word
from patterndb.system.deadline import LOOK_SECONDS, begin_task
from patterndb.system.extras import require_extra
from query.ending import NEVER, EndFlag, refuse_if_ended, wait_unless_ended
from query.errors import InvalidQueryError, SolverError
from query.solving.batch import OFF, BestFits, Labels, Question
from query.solving.solve import NO_FLOWS, OrientedStrokes, Solutions
from query.solving.systems import Chords


def _cp_model() -> Any:
    """OR-Tools, imported only when this solver is asked for."""
    require_extra("sketch", 'solver="cp-sat" (not the default, "kernel")')
    from ortools.sat.python import cp_model

    return cp_model


#: Systems that threads are given at a time.
HANDED_OVER = 256


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

    def __init__(
        self, chords: Chords, lengths: NDArray[np.int64], cancelled: EndFlag = NEVER
    ) -> None:
        self.cancelled = cancelled
        self.cp = _cp_model()
        self.model = self.cp.CpModel()
        self.most = [max(1, int(lengths[i])) for i, _ in chords.sides]
        self.x = [self.model.new_int_var(1, top, f"x{c}") for c, top in enumerate(self.most)]
        ends: list[list[Any]] = [[] for _ in range(chords.n_sides)]
        for x, (i, j) in zip(self.x, chords.sides, strict=True):
            ends[i].append(x)
            ends[j].append(x)
        for side, length in zip(ends, lengths.tolist(), strict=True):
            self.model.add(sum(side) == length)

    def add_strokes(
        self,
        chords: Chords,
        lengths: list[int],
        flows: OrientedStrokes,
        carriers: tuple[Carrier, ...],
    ) -> None:
        """Strands 1 wide on the strokes: the paper's x_q = x_q0 + 1 + x_q1, and what follows.

        The edges that each end is off become variables after the widths.
        """
        parts: dict[int, list[Any]] = {}
        off: list[Any] = []
        model, edges, most = self.model, chords.edges.tolist(), max(lengths)
        for s, (carrier, row) in enumerate(zip(carriers, flows.rows.tolist(), strict=True)):
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
                before = sum(self.x[c] for c in edges[chords.side_start[side] : at])
                d = model.new_int_var(-flows.tolerance, flows.tolerance, f"d{s}-{at}")
                model.add(before + sum(own[: rank + 1]) + rank - d == edge)
                off.append(d)
        self.x = [*self.x, *off]

    def add_key(self) -> Any:
        """A variable for the sum of the squared widths."""
        squares: list[Any] = []
        for c, (x, top) in enumerate(zip(self.x, self.most, strict=True)):
            square = self.model.new_int_var(1, top**2, f"s{c}")
            self.model.add_multiplication_equality(square, [x, x])
            squares.append(square)
        key = self.model.new_int_var(0, sum(top**2 for top in self.most), "key")
        self.model.add(key == sum(squares))
        return key

    def enumerate(self, limit: int | None) -> list[tuple[int, ...]]:
        """All solutions, or the first ``limit`` that turn up."""
        found: list[tuple[int, ...]] = []
        variables = self.x

        class Collect(self.cp.CpSolverSolutionCallback):
            def on_solution_callback(self) -> None:
                found.append(tuple(self.value(x) for x in variables))
                if limit is not None and len(found) >= limit:
                    self.stop_search()

        self._solve(Collect(), every=True)
        return found

    def value_of(self, objective: Any) -> int | None:
        """The least value of the objective, or None where there is no solution."""
        self.model.minimize(objective)
        solver, status = self._solve(None, every=False)
        self.model.clear_objective()
        return None if status == self.cp.INFEASIBLE else solver.value(objective)

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
            ended = not wait_unless_ended(solving, self.cancelled)
        except BaseException:
            _leave(solver, solving)
            raise
        if ended:
            _leave(solver, solving)
        refuse_if_ended(self.cancelled)
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


def find_solutions(
    chords: Chords, lengths: ArrayLike, limit: int | None = None, flows: OrientedStrokes = NO_FLOWS
) -> Solutions:
    """As :func:`query.solving.solve.find_solutions`, solution for solution.

    Where there are more than ``limit``, all solutions of each key are listed, smallest
    key first, until there are enough: slow where many solutions are equally even. With
    strokes all solutions are listed always, once for every assignment.
    """
    if limit is not None and limit < 1:
        raise InvalidQueryError(f"limit is {limit}; ask for at least 1, or None for all")
    wanted = np.asarray(lengths, np.int64)
    if len(flows.rows):
        return _with_flows(chords, wanted, limit, flows)
    found = _Model(chords, wanted).enumerate(None if limit is None else limit + 1)
    truncated = False
    if limit is not None and len(found) > limit:
        truncated = True
        found = []
        above = 0
        while len(found) < limit:
            model = _Model(chords, wanted)
            key = model.add_key()
            model.model.add(key > above)
            least = model.value_of(key)
            assert least is not None, "more solutions than the limit were found before"
            model.model.add(key == least)
            found += model.enumerate(None)
            above = least
    found.sort(key=lambda widths: (sum(x * x for x in widths), widths))
    rows = np.array(found[:limit], np.int32).reshape(-1, chords.n)
    return Solutions(rows, truncated)


def _with_flows(
    chords: Chords, lengths: NDArray[np.int64], limit: int | None, flows: OrientedStrokes
) -> Solutions:
    """The best of the solutions, by edges off, then evenness."""
    least = _least_off(chords, lengths, flows)
    ranked = sorted(least, key=lambda widths: (least[widths], sum(x * x for x in widths), widths))
    rows = np.array(ranked[:limit], np.int32).reshape(-1, chords.n)
    return Solutions(rows, limit is not None and len(ranked) > limit)


def _least_off(
    chords: Chords,
    lengths: NDArray[np.int64],
    flows: OrientedStrokes,
    cancelled: EndFlag = NEVER,
) -> dict[tuple[int, ...], int]:
    """The solutions of every assignment of strokes to strands, with the fewest edges off."""
    least: dict[tuple[int, ...], int] = {}
    n = chords.n
    for carriers in _assignments(chords, flows):
        refuse_if_ended(cancelled)
        model = _Model(chords, lengths, cancelled)
        model.add_strokes(chords, lengths.tolist(), flows, carriers)
        for values in model.enumerate(None):
            off = sum(map(abs, values[n:]))
            least[values[:n]] = min(off, least.get(values[:n], off))
    return least


def _assignments(chords: Chords, flows: OrientedStrokes) -> Iterator[tuple[Carrier, ...]]:
    """Every way to give each stroke a polychord that joins its sides, and each polychord an
    order of its strokes."""
    side_of = np.repeat(np.arange(chords.n_sides), np.diff(chords.side_start)).tolist()
    ends: list[list[int]] = [[] for _ in range(chords.n)]
    for at, chord in enumerate(chords.edges.tolist()):
        ends[chord].append(at)
    choices = [
        [
            (first, second)
            for pair in ends
            for first, second in (pair, pair[::-1])
            if (side_of[first], side_of[second]) == (a, b)
        ]
        for a, _, b, _ in flows.rows.tolist()
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


def is_feasible(
    chords: Chords,
    lengths: ArrayLike,
    flows: OrientedStrokes = NO_FLOWS,
    cancelled: EndFlag = NEVER,
) -> bool:
    """As :func:`query.solving.solve.is_feasible`.

    Raises QueryEndedError once the flag ``cancelled`` (1,) is 1.
    """
    wanted = np.asarray(lengths, np.int64)
    if not len(flows.rows):
        return _Model(chords, wanted, cancelled).is_feasible()
    for carriers in _assignments(chords, flows):
        refuse_if_ended(cancelled)
        model = _Model(chords, wanted, cancelled)
        model.add_strokes(chords, wanted.tolist(), flows, carriers)
        if model.is_feasible():
            return True
    return False


def keep_carriers(
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    question: Question,
    cancelled: EndFlag,
    threads: int | None = None,
) -> NDArray[np.bool_]:
    """As :func:`query.solving.batch.keep_carriers`; a millisecond or so for every system.

    Cancelled, it raises QueryEndedError.
    """

    def fits(at: tuple[int, int]) -> bool:
        refuse_if_ended(cancelled)
        r, o = at
        chords = _chords(labels, int(rows[r]))
        return is_feasible(
            chords,
            question.lengths[o],
            OrientedStrokes(question.flows[o], question.tolerance),
            cancelled,
        )

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


def solve_rows(
    labels: Labels,
    rows: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    question: Question,
    keep: int,
    cancelled: EndFlag,
) -> BestFits:
    """As :func:`query.solving.batch.solve_rows`; lists every solution before it takes the best.

    Cancelled, it raises QueryEndedError.
    """
    found: list[tuple[int, int, tuple[int, ...], int]] = []
    for r, row in enumerate(rows.tolist()):
        chords = _chords(labels, row)
        of_row: list[tuple[int, tuple[int, ...], int]] = []
        for o in np.flatnonzero(allowed[r]).tolist():
            flows = OrientedStrokes(question.flows[o], question.tolerance)
            weight = question.weights[o][chords.sides[:, 0], chords.sides[:, 1]].tolist()
            wanted = question.lengths[o].astype(np.int64)
            for widths, off in _all(chords, wanted, flows, cancelled):
                key = off * OFF + sum(w * x * x for w, x in zip(weight, widths, strict=True))
                of_row.append((key, widths, o))
        found += [(r, key, widths, o) for key, widths, o in sorted(of_row)[:keep]]
    longest = max((len(widths) for _, _, widths, _ in found), default=0)
    table = np.zeros((len(found), longest), np.int32)
    for at, (_, _, widths, _) in enumerate(found):
        table[at, : len(widths)] = widths
    return BestFits(
        row=np.array([r for r, _, _, _ in found], np.int64),
        key=np.array([key for _, key, _, _ in found], np.int64),
        orientation=np.array([o for _, _, _, o in found], np.int32),
        widths=table,
    )


def _all(
    chords: Chords,
    lengths: NDArray[np.int64],
    flows: OrientedStrokes,
    cancelled: EndFlag,
) -> list[tuple[tuple[int, ...], int]]:
    """All widths, and the edges that each is off the strokes."""
    if len(flows.rows):
        return list(_least_off(chords, lengths, flows, cancelled).items())
    return [(widths, 0) for widths in _Model(chords, lengths, cancelled).enumerate(None)]


def _chords(labels: Labels, row: int) -> Chords:
    word = labels.words[labels.start[row] : labels.start[row + 1]]
    return Chords.from_label(split_word(word, labels.n_sides))
