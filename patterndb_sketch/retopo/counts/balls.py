"""Choose the counts of a ball anew, neighbouring patches, all others fixed, by CP-SAT.

One literal a count, and evenness as clauses: numbers with halves are beyond the solver at this
size, and a whole network is either way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.system.extras import require_extra
from patterndb_sketch.retopo.counts.problem import MIN_PERIMETER, CountsProblem

#: A chain may get so many edges more or fewer than nearest to its target.
WINDOW = 3

#: The solver takes whole numbers: so many for a cost of 1.
COST_UNITS = 10_000

#: Odd sums of so many chains are forbidden one by one; beyond, the solver's own constraint does.
MOST_FORBIDDEN = 7

#: Lengths of a patch's sides that a rule of the caller's is asked about, for one ball.
MOST_ASKED = 700


@dataclass(frozen=True, slots=True, eq=False)
class BallSolution:
    """Counts after a ball was solved.

    counts:  (c,) int32, of the whole network.
    gap:     how much less other counts in the ball's windows may cost at most, 0 where it is proven
             that none do. Patches unasked are not looked at.
    unasked: patches with so many side lengths that the caller's rule was not asked about them.
    """

    counts: Int32Array
    gap: float
    unasked: tuple[int, ...]


def grow_ball(near: Sequence[Int32Array], seed: int, size: int) -> list[int]:
    """Grow a ball: the patches first met from a seed, breadth-first, at most so many."""
    found = [seed]
    seen = {seed}
    for patch in found:
        for other in near[patch]:
            if len(found) == size:
                return found
            if int(other) not in seen:
                seen.add(int(other))
                found.append(int(other))
    return found


def list_neighbours(problem: CountsProblem) -> list[Int32Array]:
    """List of every patch those across its chains, in order, itself left out."""
    sets: list[set[int]] = [set() for _ in range(problem.n_patches)]
    for a, b in problem.ends.tolist():
        if a != b and b < problem.n_patches:
            sets[a].add(b)
            sets[b].add(a)
    return [np.array(sorted(one), np.int32) for one in sets]


def solve_ball(
    problem: CountsProblem,
    counts: Int32Array,
    patches: Sequence[int],
    most_work: float,
    changed_from: Int32Array | None = None,
    change: float = 0.0,
) -> BallSolution:
    """Find the best counts of the chains within a ball, the others as they are.

    A chain is within if there is no patch outside of the ball beside it. Counts are those
    within WINDOW of the target, and the present one, from which the solver starts. most_work: a
    limit in the solver's deterministic seconds. changed_from: chains that have other counts
    than these cost ``change`` each beside their error.
    """
    require_extra("sketch", "choosing the edge counts of patches")
    from ortools.sat.python import cp_model

    model = _BallModel(cp_model.CpModel(), problem, counts, {}, [])
    inside = np.zeros(problem.n_patches + 1, np.bool_)
    inside[list(patches)] = True
    inside[-1] = True
    around = np.unique(np.concatenate([problem.patch_chains(f) for f in patches]))
    free = around[inside[problem.ends[around]].all(axis=1) & (problem.pinned[around] == 0)]
    for chain in free.tolist():
        model.add_chain(chain, None if changed_from is None else int(changed_from[chain]), change)
    unasked = tuple(patch for patch in patches if not model.add_patch(patch))
    if not model.literals:
        return BallSolution(counts, 0.0, unasked)
    model.cp.minimize(sum(cost * literal for cost, literal in model.costs))
    solver = cp_model.CpSolver()
    # One worker and a limit in operations: the same network always has the same counts.
    solver.parameters.num_workers = 1
    # OR-Tools would take Ctrl-C for itself, and leave it to end the process without a word.
    solver.parameters.catch_sigint_signal = False
    solver.parameters.random_seed = 0
    # All clauses in the relaxation: five times as fast, and less is left open.
    solver.parameters.linearization_level = 2
    solver.parameters.max_deterministic_time = most_work
    status = solver.solve(model.cp)
    made, gap = counts, float("inf")
    if status in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        made = counts.copy()
        for chain, literals in model.literals.items():
            made[chain] = next(n for n, one in literals.items() if solver.boolean_value(one))
        gap = (solver.objective_value - solver.best_objective_bound) / COST_UNITS
    return BallSolution(made, 0.0 if status == cp_model.OPTIMAL else gap, unasked)


@dataclass(frozen=True, slots=True, eq=False)
class _BallModel:
    """A model in the making; literals[chain][n] says that the chain has n edges."""

    cp: Any
    problem: CountsProblem
    counts: Int32Array
    literals: dict[int, dict[int, Any]]
    costs: list[tuple[int, Any]]

    def add_chain(self, chain: int, former: int | None, change: float) -> None:
        p = self.problem
        nearest, now = round(float(p.targets[chain])), int(self.counts[chain])
        least = int(p.least[chain])
        window = {max(n, least) for n in range(nearest - WINDOW, nearest + WINDOW + 1)}
        options = {n: self.cp.new_bool_var("") for n in sorted(window | {now})}
        self.cp.add_exactly_one(options.values())
        costs = [p.weights[chain] * abs(n - p.targets[chain]) for n in options]
        costs = [
            c + change * (former not in (None, n)) for c, n in zip(costs, options, strict=True)
        ]
        lowest = min(costs)
        for (n, literal), cost in zip(options.items(), costs, strict=True):
            self.cp.add_hint(literal, n == now)
            if cost > lowest:
                self.costs.append((round((cost - lowest) * COST_UNITS), literal))
        self.literals[chain] = options

    def length(self, chains: Sequence[int]) -> Any:
        """Sum the chains' counts: an expression or a number."""
        return sum(
            sum(n * one for n, one in self.literals[c].items())
            if c in self.literals
            else int(self.counts[c])
            for c in chains
        )

    def add_patch(self, patch: int) -> bool:
        """Add a patch's evenness and regularity; False if a caller's rule could not be asked."""
        p = self.problem
        sides = [
            p.chains[p.first_chain[k] : p.first_chain[k + 1]].tolist()
            for k in range(p.first_side[patch], p.first_side[patch + 1])
        ]
        around = [c for side in sides for c in side]
        if not any(c in self.literals for c in around):
            return True
        self._add_even(around)
        if len(around) < MIN_PERIMETER:
            self.cp.add(self.length(around) >= MIN_PERIMETER)
        if p.regularity <= 0:
            return True
        if p.cheap is not None:
            return self._add_asked(sides)
        if len(sides) > 2:
            irregular = self.cp.new_bool_var("")
            self.costs.append((round(p.regularity * COST_UNITS), irregular))
            if len(sides) == 4:
                self._add_equal(sides[0], sides[2], irregular)
                self._add_equal(sides[1], sides[3], irregular)
            else:
                self._add_room(sides, irregular)
        return True

    def _add_room(self, sides: list[list[int]], irregular: Any) -> None:
        """Let no side, nor two neighbours, be longer than what lies across, or it is irregular."""
        around = self.length([c for side in sides for c in side])
        lengths = [self.length(side) for side in sides]
        for i, here in enumerate(lengths):
            if len(sides) == 3:
                self._add_unless(irregular, around >= 2 * here)
                continue
            before, after = lengths[i - 1], lengths[(i + 1) % len(sides)]
            self._add_unless(irregular, around >= 2 * (here + after))
            if len(sides) > 5:
                # For 5 sides it follows from the other.
                self._add_unless(irregular, around >= before + 2 * here + after)

    def _add_unless(self, literal: Any, claim: Any) -> None:
        if isinstance(claim, (bool, np.bool_)):
            if not claim:
                self.cp.add_bool_or([literal])
        else:
            self.cp.add(claim).only_enforce_if(~literal)

    def _add_even(self, around: list[int]) -> None:
        """Forbid odd perimeters: chains that occur twice add nothing to them."""
        base = 0
        odd: list[Any] = []
        for chain in {c for c in around if around.count(c) % 2}:
            options = self.literals.get(chain)
            kinds = {n % 2 for n in options} if options else set()
            if options is None or len(kinds) == 1:
                base += int(self.counts[chain])
                continue
            is_odd = self.cp.new_bool_var("")
            self.cp.add_hint(is_odd, int(self.counts[chain]) % 2 == 1)
            for n, literal in options.items():
                self.cp.add_implication(literal, is_odd if n % 2 else ~is_odd)
            odd.append(is_odd)
        if not odd:
            return
        if len(odd) > MOST_FORBIDDEN:
            self.cp.add_bool_xor([*odd, (base + 1) % 2 == 1])
            return
        for values in product((False, True), repeat=len(odd)):
            if (base + sum(values)) % 2:
                self.cp.add_bool_or(
                    [~one if value else one for one, value in zip(odd, values, strict=True)]
                )

    def _add_equal(self, one: list[int], other: list[int], irregular: Any) -> None:
        """Let the two sides be equally long, or the patch is irregular."""
        if one == other:
            return
        if len(one) > 1 or len(other) > 1:
            self._add_unless(irregular, self.length(one) == self.length(other))
            return
        fixed = [{int(self.counts[c]): True} for c in (one[0], other[0])]
        mine = self.literals.get(one[0], fixed[0])
        theirs = self.literals.get(other[0], fixed[1])
        for n in mine:
            # mine[n] -> theirs[n], unless irregular; a fixed chain has its count for certain.
            clause = [irregular]
            if mine[n] is not True:
                clause.append(~mine[n])
            if n in theirs:
                if theirs[n] is True:
                    continue
                clause.append(theirs[n])
            self.cp.add_bool_or(clause)

    def _add_asked(self, sides: list[list[int]]) -> bool:
        """Add regularity by the caller's rule, asked about all lengths that the sides may have."""
        assert self.problem.cheap is not None
        ranges = [sorted(self._lengths(side)) for side in sides]
        if np.prod([len(one) for one in ranges]) > 2 * MOST_ASKED:
            return False
        known = [
            (*lengths, not self.problem.cheap(lengths))
            for lengths in product(*ranges)
            if sum(lengths) % 2 == 0
        ]
        variables: list[Any] = []
        for side, options in zip(sides, ranges, strict=True):
            variable = self.cp.new_int_var(options[0], options[-1], "")
            self.cp.add(variable == self.length(side))
            variables.append(variable)
        irregular = self.cp.new_bool_var("")
        self.costs.append((round(self.problem.regularity * COST_UNITS), irregular))
        self.cp.add_allowed_assignments([*variables, irregular], known)
        return True

    def _lengths(self, side: list[int]) -> set[int]:
        sums = {0}
        for chain in side:
            options = self.literals.get(chain) or [int(self.counts[chain])]
            sums = {total + n for total in sums for n in options}
        return sums
