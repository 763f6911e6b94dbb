"""Choose the best counts of a neighbourhood of patches, all others fixed, by CP-SAT.

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


def grow_neighbourhood(near: Sequence[Int32Array], seed: int, size: int) -> list[int]:
    """Grow a neighbourhood: the patches first met from a seed, breadth-first, at most so many."""
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


def solve_neighbourhood(
    problem: CountsProblem, counts: Int32Array, patches: Sequence[int], most_work: float
) -> Int32Array:
    """Return the best counts (c,) of the chains within a neighbourhood, the others as they are.

    A chain is within if there is no patch outside of the neighbourhood next to it. Counts are those
    within WINDOW of the target, and the present one, from which the solver starts. most_work: a
    limit in the solver's deterministic seconds.
    """
    require_extra("sketch", "choosing the edge counts of patches")
    from ortools.sat.python import cp_model

    model = _CountsModel(cp_model.CpModel(), problem, counts, {}, [])
    inside = np.zeros(problem.n_patches + 1, np.bool_)
    inside[list(patches)] = True
    inside[-1] = True
    around = np.unique(np.concatenate([problem.patch_chains(f) for f in patches]))
    free = around[inside[problem.ends[around]].all(axis=1) & (problem.pinned[around] == 0)]
    for chain in free.tolist():
        model.add_chain(chain)
    for patch in patches:
        model.add_patch(patch)
    if not model.literals:
        return counts
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
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return counts
    made = counts.copy()
    for chain, literals in model.literals.items():
        made[chain] = next(n for n, one in literals.items() if solver.boolean_value(one))
    return made


@dataclass(frozen=True, slots=True, eq=False)
class _CountsModel:
    """A model in the making; literals[chain][n] says that the chain has n edges."""

    cp: Any
    problem: CountsProblem
    counts: Int32Array
    literals: dict[int, dict[int, Any]]
    costs: list[tuple[int, Any]]

    def add_chain(self, chain: int) -> None:
        """Add a chain with its counts and their costs."""
        p = self.problem
        nearest, now = round(float(p.targets[chain])), int(self.counts[chain])
        least = int(p.least[chain])
        window = {max(n, least) for n in range(nearest - WINDOW, nearest + WINDOW + 1)}
        options = {n: self.cp.new_bool_var("") for n in sorted(window | {now})}
        self.cp.add_exactly_one(options.values())
        costs = [p.weights[chain] * abs(n - p.targets[chain]) for n in options]
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

    def add_patch(self, patch: int) -> None:
        """Add a patch's evenness and regularity."""
        p = self.problem
        sides = [
            p.chains[p.first_chain[k] : p.first_chain[k + 1]].tolist()
            for k in range(p.first_side[patch], p.first_side[patch + 1])
        ]
        around = [c for side in sides for c in side]
        if not any(c in self.literals for c in around):
            return
        self._add_even(around)
        if len(around) < MIN_PERIMETER:
            self.cp.add(self.length(around) >= MIN_PERIMETER)
        if p.regularity <= 0 or len(sides) <= 2:
            return
        irregular = self.cp.new_bool_var("")
        self.costs.append((round(p.regularity * COST_UNITS), irregular))
        if len(sides) == 4:
            self._add_equal(sides[0], sides[2], irregular)
            self._add_equal(sides[1], sides[3], irregular)
        else:
            self._add_room(sides, irregular)

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
