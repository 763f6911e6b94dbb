"""The same systems by OR-Tools CP-SAT: the second opinion the kernel is held to.

Every model runs with one worker: enumerate_all_solutions with several workers loses and
repeats solutions, and reports OPTIMAL all the same. Systems run side by side instead.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.errors import MissingExtraError
from patterndb.halfedge import Int32Array
from patterndb.patternclass import PatternClass
from query.boundary import Boundary
from query.chords import Chords
from query.errors import InvalidQueryError, SolverError
from query.feasibility import targets, units
from query.solve import Solutions


def _cp_model() -> Any:
    """OR-Tools, imported only when this solver is asked for."""
    try:
        from ortools.sat.python import cp_model
    except ImportError as error:
        raise MissingExtraError(
            'solver="cp-sat" needs OR-Tools: pip install ortools, or leave solver="kernel"'
        ) from error
    return cp_model


class _Model:
    """Widths of the open polychords, with the sides' lengths as constraints."""

    def __init__(self, chords: Chords, lengths: NDArray[np.int64]) -> None:
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

    def feasible(self) -> bool:
        """Is there any solution?"""
        return self._solve(None, every=False)[1] != self.cp.INFEASIBLE

    def _solve(self, callback: Any, *, every: bool) -> tuple[Any, Any]:
        solver = self.cp.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.enumerate_all_solutions = every
        status = solver.solve(self.model, callback)
        if status not in (self.cp.OPTIMAL, self.cp.FEASIBLE, self.cp.INFEASIBLE):
            raise SolverError(f"CP-SAT stopped with status {solver.status_name(status)}")
        return solver, status


def solutions(chords: Chords, lengths: ArrayLike, limit: int | None = None) -> Solutions:
    """As :func:`query.solve.solutions`, solution for solution.

    Where there are more than ``limit``, all solutions of each key are listed, smallest
    key first, until there are enough: slow where many solutions are equally even.
    """
    if limit is not None and limit < 1:
        raise InvalidQueryError(f"limit is {limit}; ask for at least 1, or None for all")
    wanted = np.asarray(lengths, np.int64)
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


def feasible(chords: Chords, lengths: ArrayLike) -> bool:
    """As :func:`query.solve.feasible`."""
    return _Model(chords, np.asarray(lengths, np.int64)).feasible()


def feasible_rows(
    patterns: PatternClass,
    boundary: Boundary,
    rows: NDArray[np.int64],
    *,
    threads: int | None = None,
) -> NDArray[np.int64]:
    """As :func:`query.feasibility.feasible_rows`; a millisecond or so for every system."""
    lengths, kinds = targets(boundary)
    signature, allowed, unit = units(patterns, boundary, rows, kinds)

    def fits(u: int) -> bool:
        base = patterns.lengths[signature[u]]
        chords = _chords_of(patterns.joins[signature[u]])
        return any(
            bool((lengths[o] >= base).all()) and feasible(chords, lengths[o])
            for o in np.flatnonzero(allowed[u])
        )

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        answers = np.array(list(pool.map(fits, range(len(signature)))), np.bool_)
    return rows[answers[unit]]


def _chords_of(joins: Int32Array) -> Chords:
    """The polychords of a signature, class by class."""
    i, j = np.nonzero(np.triu(joins))
    return Chords.from_sides(len(joins), np.repeat(np.c_[i, j], joins[i, j], axis=0))
