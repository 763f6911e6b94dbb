"""Make counts even: the least change after which every patch has an even boundary.

Parity is all that binds the chains of a network together, and it is a minimum-weight T-join: nodes
are the patches and one node outside, edges the chains, T the odd patches, and an edge costs what
the next best count of the other parity does. Costs are convex in the count, so that no other count
need be looked at. A strip is odd only in the patches at its two ends, and is one edge.

The T-join is exact (Edmonds and Johnson, "Matching, Euler tours and the Chinese postman", 1973):
the nodes of T are paired along shortest paths by a minimum-weight perfect matching, in which all
pairs are looked at. The matching is that of the compiled core, because of its speed in large
networks: ``rustworkx.max_weight_matching`` 0.18 came to the same joins in all of 784 problems of
benchmarks/retopo_counts.py, in 30 ms for 10 where 106 patches of 200 are odd, but in 7.9 s for 0.5
where 512 of 1000 are (on a machine that others used too).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from patterndb._native.retopo.counts.evening import tie_sides
from patterndb._native.retopo.counts.tjoin import match
from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools, Floats
from patterndb_sketch.retopo.counts.problem import MIN_PERIMETER, CountsProblem
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: Joins take whole numbers: so many for a cost of 1, as many as leave room for a million chains.
COST_UNITS = 10**9

#: No path; small enough that matching takes it as a weight.
UNREACHED = 1 << 56

#: Weights are doubled, and so are sums of two: above this they might not fit in 63 bits.
MOST_WEIGHT = 1 << 58

#: What a change of one chain costs where few changes matter first, and errors break ties.
CHANGE = 10**12


def label_strips(problem: CountsProblem) -> Int32Array:
    """Label every chain by the strip it is in: (c,) int32, the smallest chain of the strip.

    A strip is chains across 4-sided patches from one another, tied to one count.

    Opposite sides of a 4-sided patch are tied where each is a single chain: a strip ends where a
    side has more of them. Nor are chains tied that the user has pinned to different counts, or to
    one below what the other needs at least.
    """
    least = np.where(problem.pinned > 0, 1, problem.least).astype(np.int32)
    return tie_sides(problem.first_side, problem.first_chain, problem.chains, problem.pinned, least)


@dataclass(frozen=True, slots=True)
class Stuck:
    """Patches that no counts suit, because of counts that the user has pinned.

    patches: the patches in question. odd: their boundaries together are odd; else there is one,
             and it has fewer than MIN_PERIMETER edges.
    pinned:  the chains to blame: another count of one of them, or none, mends it.
    """

    patches: tuple[int, ...]
    odd: bool
    pinned: tuple[int, ...]

    def __str__(self) -> str:
        where = f"patch {self.patches[0]}"
        if len(self.patches) > 1:
            where = f"the {len(self.patches)} patches about patch {self.patches[0]}"
        names = ", ".join(map(str, self.pinned[:8])) + (" ..." if len(self.pinned) > 8 else "")
        chains = f"chain {names}" if len(self.pinned) == 1 else f"chains {names}"
        if self.odd:
            return (
                f"the counts pinned around {where} add up to an odd number, and no quad mesh has "
                f"an odd boundary; change one of {chains} by 1, or free it"
            )
        return (
            f"{where} has fewer than {MIN_PERIMETER} edges around it, all pinned; "
            f"raise {chains} or free it"
        )


@dataclass(frozen=True, slots=True, eq=False)
class EvenCounts:
    """Counts with an even boundary of four edges or more around every patch but the stuck ones.

    counts: (c,) int32.
    stuck:  where there are no such counts; one patch of each stays as it is.
    bound:  the error of the T-join's counts: no even ones have less, if it was about single chains.
    """

    counts: Int32Array
    bound: float
    stuck: tuple[Stuck, ...]


def even_by_least_errors(problem: CountsProblem) -> EvenCounts:
    """Find the even counts of least error: the exact optimum without regularity."""
    each = np.arange(problem.n_chains, dtype=np.int32)
    nearest, other, costs = _find_nearest_counts(problem, each)
    return _join_odd_patches(problem, nearest, other, costs, each)


def even_along_strips(problem: CountsProblem, strip: Int32Array) -> EvenCounts:
    """Find, of all even counts that are the same along every strip, those of least error.

    strip: see :func:`label_strips`. Where strips leave a patch odd, as one
    of pinned chains may, single chains are changed then.
    """
    nearest, other, costs = _find_nearest_counts(problem, strip)
    made = _join_odd_patches(problem, nearest, other, costs, strip)
    return even_by_fewest_changes(problem, made.counts) if made.stuck else made


def even_by_fewest_changes(problem: CountsProblem, counts: Int32Array) -> EvenCounts:
    """Make given counts even: as few chains changed as can be, each by 1, errors breaking ties.

    Pinned chains get their counts, and others as many edges as they need at least, before.
    """
    n = np.maximum(counts, problem.least)
    n = np.where(problem.pinned > 0, problem.pinned, n).astype(np.int32)
    below, above = (problem.weights * np.abs(n + by - problem.targets) for by in (-1, 1))
    down = (below <= above) & (n > problem.least)
    worse = np.where(down, below, above) - problem.errors(n)
    # Errors of a chain are bounded; a million of them weigh less than one change.
    tie = np.clip(np.round((worse + problem.weights) * (COST_UNITS / 1000)), 0, CHANGE // 1000)
    costs = CHANGE + tie.astype(np.int64)
    costs[problem.pinned > 0] = UNREACHED
    other = np.where(down, n - 1, n + 1).astype(np.int32)
    each = np.arange(problem.n_chains, dtype=np.int32)
    return _join_odd_patches(problem, n, other, costs, each)


def _find_nearest_counts(
    problem: CountsProblem, group: Int32Array
) -> tuple[Int32Array, Int32Array, Int64Array]:
    """Find for every chain, for its whole group: best count, best of other parity, what that costs
    more.

    The cost is UNREACHED where the group is pinned.
    """
    n = problem.n_chains
    least = np.zeros(n, np.int32)
    np.maximum.at(least, group, problem.least)
    pin = np.zeros(n, np.int32)
    np.maximum.at(pin, group, problem.pinned)
    # The sum of weighted errors is least at the weighted median of the targets.
    order = np.lexsort((problem.targets, group))
    summed = np.cumsum(problem.weights[order])
    ends = np.searchsorted(group[order], np.arange(n), "right")
    before = np.searchsorted(group[order], np.arange(n), "left")
    edges = np.concatenate([[0.0], summed])
    half = (edges[before] + edges[ends]) / 2
    at = np.clip(np.searchsorted(summed, half), before, np.maximum(ends - 1, before))
    median = problem.targets[order[np.minimum(at, n - 1)]] if n else np.zeros(0)

    def cost(counts: Int32Array) -> Floats:
        errors = problem.weights * np.abs(counts[group] - problem.targets)
        return np.bincount(group, errors, n).astype(np.float64)

    below = np.maximum(np.floor(median).astype(np.int32), least)
    above = np.maximum(np.ceil(median).astype(np.int32), least)
    best = np.where(cost(above) < cost(below), above, below)
    less = np.where(best > least, cost(np.maximum(best - 1, least)), np.inf)
    more = cost(best + 1)
    other = np.where(less < more, best - 1, best + 1)
    worse = np.minimum(less, more) - cost(best)
    costs = np.clip(np.round(worse * COST_UNITS), 0, None).astype(np.int64)
    best, other = (np.where(pin > 0, pin, counts).astype(np.int32) for counts in (best, other))
    costs[pin > 0] = UNREACHED
    return best[group], other[group], costs[group]


def _join_odd_patches(
    problem: CountsProblem,
    counts: Int32Array,
    other: Int32Array,
    costs: Int64Array,
    group: Int32Array,
) -> EvenCounts:
    """Change those groups to their other count that make every patch even, as cheaply as can be."""
    usable = np.flatnonzero((costs < UNREACHED) & (group == np.arange(problem.n_chains)))
    ends = _find_group_ends(problem, group)[usable]
    odd = np.append(problem.perimeters(counts) % 2 == 1, False)
    # The node outside is even or odd as the others want it.
    component = label_components(problem.n_patches + 1, ends)
    odd[-1] = odd[component == component[-1]].sum() % 2 == 1
    join = find_cheapest_join(problem.n_patches + 1, ends, costs[usable], odd)
    change = np.zeros(problem.n_chains, np.bool_)
    change[usable[join.edges]] = True
    made = np.where(change[group], other, counts).astype(np.int32)
    stuck = [_explain_odd(problem, int(patch)) for patch in join.left]
    bound = float(problem.errors(made).sum())
    return EvenCounts(made, bound, tuple(stuck + _raise_small(problem, made)))


def _find_group_ends(problem: CountsProblem, group: Int32Array) -> Int32Array:
    """Find the nodes in which groups are odd: (c, 2) by the chain that names a group; the last node
    is outside.

    A group that is odd nowhere gets a loop.
    """
    n = problem.n_chains
    pairs = np.stack([np.repeat(group, 2), problem.ends.ravel()], axis=1)
    pairs, times = np.unique(pairs, axis=0, return_counts=True)
    pairs = pairs[times % 2 == 1]
    ends = np.zeros((n, 2), np.int32)
    # Chains have two ends, and each tie joins two: what is left are two ends or none.
    first = np.flatnonzero(np.r_[True, pairs[1:, 0] != pairs[:-1, 0]]) if len(pairs) else []
    for side in range(2):
        ends[pairs[first, 0], side] = pairs[np.asarray(first, np.int64) + side, 1]
    return ends


def _explain_odd(problem: CountsProblem, patch: int) -> Stuck:
    """Name the patches that free chains join to an odd one, and the pinned chains around them."""
    free = problem.pinned == 0
    component = label_components(problem.n_patches + 1, problem.ends[free])
    inside: Bools = component == component[patch]
    rim = inside[problem.ends].sum(axis=1) == 1
    return Stuck(
        tuple(np.flatnonzero(inside).tolist()), True, tuple(np.flatnonzero(rim & ~free).tolist())
    )


def _raise_small(problem: CountsProblem, counts: Int32Array) -> list[Stuck]:
    """Give patches of fewer than MIN_PERIMETER edges two more, on the chain where it costs least.

    Two more keep all patches as even as they are. counts: updated. Returns what is pinned.
    """
    stuck: list[Stuck] = []
    perimeters = problem.perimeters(counts)
    for patch in np.flatnonzero((perimeters < MIN_PERIMETER) & (perimeters % 2 == 0)):
        if problem.perimeters(counts)[patch] >= MIN_PERIMETER:
            continue
        around = np.unique(problem.patch_chains(int(patch)))
        free = around[problem.pinned[around] == 0]
        if not len(free):
            stuck.append(Stuck((int(patch),), False, tuple(around.tolist())))
            continue
        more = counts.copy()
        more[free] += 2
        worse = (problem.errors(more) - problem.errors(counts))[free]
        counts[free[np.argmin(worse)]] += 2
    return stuck


@dataclass(frozen=True, slots=True, eq=False)
class Join:
    """A minimum-weight T-join.

    edges: (e,) bool, the edges in it.
    left:  nodes of T in components of the graph with an odd number of such nodes, one each:
           no join can serve all of them. The join is the best one for the others.
    """

    edges: Bools
    left: Int32Array


def find_cheapest_join(n_nodes: int, ends: Int32Array, costs: Int64Array, odd: Bools) -> Join:
    """Find the cheapest edges that change the parity of exactly the odd nodes.

    ends: (e, 2) int32 nodes of every edge, parallel edges and loops (which do nothing) allowed;
    costs: (e,) int64 >= 0, their sum below UNREACHED and that along a path below 2^53; odd:
    (n_nodes,) bool. Of several least joins it is always the same one.
    """
    component = label_components(n_nodes, ends)
    wanted = np.flatnonzero(odd)
    alone = np.bincount(component[wanted], minlength=n_nodes)[component[wanted]] % 2 == 1
    # The last node of T in a component that has an odd number of them.
    _, first = np.unique(component[wanted][::-1], return_index=True)
    last = np.zeros(len(wanted), np.bool_)
    last[len(wanted) - 1 - first] = True
    left = wanted[alone & last].astype(np.int32)
    wanted = wanted[~(alone & last)]
    chosen = np.zeros(len(ends), np.bool_)
    if not len(wanted):
        return Join(chosen, left)
    # Of parallel edges the cheapest, and the first of these.
    low, high = ends.min(axis=1).astype(np.int64), ends.max(axis=1)
    name = low * n_nodes + high
    order = np.lexsort((costs, name))
    edges = order[np.r_[True, np.diff(name[order]) != 0] & (low != high)[order]]
    # 32 bits: before SciPy 1.15 its shortest paths take no others.
    places = low[edges].astype(np.int32), high[edges].astype(np.int32)
    graph = csr_array((costs[edges].astype(np.float64), places), (n_nodes, n_nodes))
    lengths, before = dijkstra(graph, directed=False, indices=wanted, return_predecessors=True)
    weights = np.where(np.isfinite(lengths), lengths, UNREACHED).astype(np.int64)
    edge_of = dict(zip(name[edges].tolist(), edges.tolist(), strict=True))
    for i, j in enumerate(pair_cheaply(weights[:, wanted])):
        if i < j:
            node = int(wanted[j])
            while node != wanted[i]:
                previous = int(before[i, node])
                edge = edge_of[min(node, previous) * n_nodes + max(node, previous)]
                # Two paths that share an edge need it neither way.
                chosen[edge] = not chosen[edge]
                node = previous
    return Join(chosen, left)


def label_components(n_nodes: int, ends: Int32Array) -> Int32Array:
    """(n_nodes,) of every node the smallest node that edges (e, 2) join it to."""
    edges = coo_array((np.ones(len(ends), np.bool_), (ends[:, 0], ends[:, 1])), (n_nodes, n_nodes))
    count, group = connected_components(edges, directed=False)
    smallest = np.full(count, n_nodes, np.int32)
    np.minimum.at(smallest, group, np.arange(n_nodes, dtype=np.int32))
    return smallest[group]


def pair_cheaply(weights: Int64Array) -> Int32Array:
    """Pair vertices such that the sum of weights is least: (n,) int32, of every vertex its partner.

    weights: (n, n) int64, symmetric, >= 0 and at most MOST_WEIGHT; the diagonal counts for
    nothing. Of several least matchings it is always the same one. Raises InvalidRetopoError for
    an odd n and for other weights.
    """
    n = len(weights)
    if n % 2:
        raise InvalidRetopoError(f"{n} vertices cannot be paired; their number must be even")
    if n == 0:
        return np.empty(0, np.int32)
    if weights.min() < 0 or weights.max() > MOST_WEIGHT:
        raise InvalidRetopoError("a weight is below 0 or above MOST_WEIGHT; scale the weights")
    return match(np.ascontiguousarray(weights, np.int64))
