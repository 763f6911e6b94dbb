"""The exhaustive search for the chords that cut a cycle into the flattest pieces."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.chords.flatness import (
    N_MOMENTS,
    Flatness,
    add_moments,
    find_determinant,
    standardise,
    sum_moments,
)
from patterndb_sketch.surfacing.chords.subcycles import (
    MOST_COUNTED,
    Subcycles,
    number_subcycles,
    part_number,
    path_of,
    step_offset,
)
from patterndb_sketch.surfacing.network import InvalidNetworkError

#: Costs that differ by no more than this share of S(whole cycle) + alpha are equal. They are sums
#: of some tens of terms, each with an error in the 16th digit.
TIE = 1e-12


@dataclass(frozen=True, slots=True)
class ChordCuts:
    """The best cuts of a cycle.

    chosen:  (k,) int64, which of the chords were chosen, ascending.
    pieces:  k + 1 closed loops of positions int64, in the loop's own sense. A step between
             positions that are no neighbours in the loop is a chosen chord.
    cost:    Sub(whole cycle).
    n_subproblems: how many sub-problems were solved, each once.
    seconds: how long that took.
    """

    chosen: Int64Array = field(repr=False)
    pieces: tuple[Int64Array, ...] = field(repr=False)
    cost: float
    n_subproblems: int
    seconds: float


def search_cuts(
    points: Points, chords: Int64Array, alpha: float = 0.1, form: Flatness = "relative"
) -> ChordCuts:
    """Choose chords so that the cost of the pieces and of the cuts is least.

        Sub(K) = min(S(K), min over chords c in K: Sub(left) + Sub(right) + alpha len(c) / len(K))

    where S is :func:`.flatness.measure_flatness` and K runs over all sub-cycles that cuts by the
    chords lead to. Of equal costs (TIE) the one with fewer chords wins, then the one cut by the
    chord that comes first. A planar cycle is never cut.

    points: (n, 3) a closed loop. chords: (m, 2) positions i < j, not neighbours, no two alike.
    All sub-problems are solved, whatever alpha; each takes 16 bytes and less than 1 us.
    :func:`n_subproblems` tells how many they are.

    Raises InvalidNetworkError for an alpha below 0 or not finite, chords that are not as above,
    and sub-problems too many to number.
    Source: Abbasinejad et al. 2013, section 3.2, Equations 1 to 3 and Algorithm 1.
    Differs from the paper: sub-problems are numbered and solved from the smallest up, see
    :mod:`patterndb_sketch.surfacing.chords.subcycles`, where the paper recurses with a hash table.
    """
    points = np.ascontiguousarray(points, np.float64)
    chords = _check_chords(len(points), chords)
    if not (math.isfinite(alpha) and alpha >= 0):
        raise InvalidNetworkError(f"alpha is {alpha}; give a number >= 0")
    started = perf_counter()
    own, determinant = standardise(points)
    whole = np.arange(len(points))
    if determinant == 0.0 or not len(chords):
        # A planar cycle is a problem of its own, solved at a glance.
        scale = determinant if form == "printed" else float(determinant > 0.0)
        return ChordCuts(np.zeros(0, np.int64), (whole,), scale, 1, perf_counter() - started)
    scale = determinant if form == "printed" else 1.0
    count, cost, chosen, bounds, positions = _solve(
        points, own, chords, alpha / scale, form == "printed"
    )
    if count >= MOST_COUNTED:
        raise InvalidNetworkError(
            f"{len(chords)} chords make {MOST_COUNTED} sub-problems or more; give fewer chords"
        )
    seconds = perf_counter() - started
    pieces = tuple(np.split(positions, bounds))
    return ChordCuts(np.sort(chosen), pieces, cost * scale, count, seconds)


def _check_chords(n: int, chords: Int64Array) -> Int64Array:
    pairs = np.ascontiguousarray(chords, np.int64).reshape(-1, 2)
    first, last = pairs[:, 0], pairs[:, 1]
    wrong = (first < 0) | (last >= n) | (last - first < 2) | (last - first > n - 2)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        raise InvalidNetworkError(
            f"chord {i} joins the positions {first[i]} and {last[i]}; give i < j in a loop of {n} "
            "vertices that are not neighbours"
        )
    if len(np.unique(first * n + last)) < len(pairs):
        raise InvalidNetworkError("two chords join the same positions; give each once")
    return pairs


@kernel
def _solve(
    points: Floats, own: Floats, chords: Int64Array, alpha: float, printed: bool
) -> tuple[int, float, Int64Array, Int64Array, Int64Array]:
    """Number of sub-problems, cost relative to S(whole), chosen chords, and the pieces' positions
    one after the other with the bounds between them."""
    nothing = np.zeros(0, np.int64)
    numbering = number_subcycles(len(points), chords)
    if numbering.n_all >= MOST_COUNTED:
        return numbering.n_all, 0.0, nothing, nothing, nothing
    m = len(chords)
    k = len(numbering.ends)
    measures = measure_ends(points, own, chords, numbering.ends, printed)
    size = numbering.base[m] + numbering.paths[k, 0]
    solutions = SubcycleSolutions(
        np.empty(size), np.empty(size, np.int32), np.empty(size, np.int32)
    )
    # Wraps inside another end before it, or with it and begin later.
    for wrap in numbering.ending:
        evaluate(wrap, numbering, measures, alpha, solutions)
    evaluate(m, numbering, measures, alpha, solutions)
    n_chosen = int(solutions.fewest[size - 1])
    chosen, bounds, positions = trace_pieces(len(points), numbering, solutions.choice, n_chosen)
    return numbering.n_all, float(solutions.value[size - 1]), chosen, bounds, positions


class SubcycleMoments(NamedTuple):
    """What sub-cycles are summed up from.

    corner: (k, 10) moments of every end. up_to: (k + 1, 10) moments of the vertices from end 0
    to before every end. arc_to: (k + 1,) lengths of the cycle from end 0 to every end.
    chord: (m,) lengths. printed: which form of S. whole: the whole cycle's determinant.
    """

    corner: Floats
    up_to: Floats
    arc_to: Floats
    chord: Floats
    printed: bool
    whole: float


class SubcycleSolutions(NamedTuple):
    """What is known of every sub-cycle, by its number.

    value: its cost. fewest: how many chords cut it. choice: the chord that cuts it first, or -1.
    """

    value: Floats
    fewest: NDArray[np.int32]
    choice: NDArray[np.int32]


@kernel
def measure_ends(
    points: Floats, own: Floats, chords: Int64Array, ends: Int64Array, printed: bool
) -> SubcycleMoments:
    """The measures of a loop of points (n, 3), which are ``own`` in standardised axes."""
    n, k = len(points), len(ends)
    corner = np.zeros((k, N_MOMENTS))
    up_to = np.zeros((k + 1, N_MOMENTS))
    arc_to = np.zeros(k + 1)
    for i in range(k):
        add_moments(corner[i], own[ends[i]])
        up_to[i + 1] = up_to[i]
        arc_to[i + 1] = arc_to[i]
        stop = ends[i + 1] if i + 1 < k else ends[0] + n
        for v in range(ends[i], stop):
            add_moments(up_to[i + 1], own[v % n])
            arc_to[i + 1] += _distance(points, v % n, (v + 1) % n)
    chord = np.empty(len(chords))
    for c in range(len(chords)):
        chord[c] = _distance(points, chords[c, 0], chords[c, 1])
    return SubcycleMoments(
        corner, up_to, arc_to, chord, printed, find_determinant(sum_moments(own))
    )


@kernel
def _distance(points: Floats, a: int, b: int) -> float:
    x = points[a, 0] - points[b, 0]
    y = points[a, 1] - points[b, 1]
    z = points[a, 2] - points[b, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def evaluate(
    wrap: int,
    numbering: Subcycles,
    measures: SubcycleMoments,
    alpha: float,
    solutions: SubcycleSolutions,
) -> None:
    """Solve all sub-cycles with one wrap (m for none), in the order of their numbers.

    A path is its jumps, with arcs between them and after the last. Each path's extensions by one
    more jump are walked before it is solved itself. Chords that could cut are found once the
    path is settled up to where they end, and are then known to all extensions.
    """
    # Tuples of arrays are taken apart once: handed on in the loops, every array's references
    # would be counted each time, which takes longer than the work.
    first, last = numbering.first, numbering.last
    paths, offsets, bases = numbering.paths, numbering.offsets, numbering.base
    corner, up_to, arc_to, chord = (
        measures.corner,
        measures.up_to,
        measures.arc_to,
        measures.chord,
    )
    value, fewest, choice = solutions.value, solutions.fewest, solutions.choice
    m, k = len(first), len(numbering.ends)
    start, stop, base = 0, k, bases[wrap]
    if wrap < m:
        start, stop = first[wrap], last[wrap]
    to_stop, offset = paths[stop], offsets[stop]
    whole = 1.0 / measures.whole
    tie = TIE * (1.0 + alpha)
    by_first, first_at, by_last, last_at = _inside(wrap, start, stop, numbering)
    n_inside = len(by_first)

    # By depth: a jump, from where to where it goes, the path's number, length and moments up to
    # there, how many chords could cut it, and which jumps and chords to look at next.
    most = stop - start + 1
    jump = np.empty(most, np.int64)
    enter = np.empty(most, np.int64)
    leave = np.empty(most, np.int64)
    number = np.empty(most, np.int64)
    length = np.empty(most)
    moments = np.zeros((most, N_MOMENTS))
    n_cuts = np.empty(most, np.int64)
    next_first = np.empty(most, np.int64)
    next_last = np.empty(most, np.int64)
    # The chords that could cut: the number of the part under it, and what the number of the
    # path changes by if that part is replaced by a jump.
    cut = np.empty(n_inside, np.int64)
    cut_left = np.empty(n_inside, np.int64)
    cut_shift = np.empty(n_inside, np.int64)
    cut_value = np.empty(n_inside)
    cut_length = np.empty(n_inside)
    total = np.empty(n_inside)
    sums = np.empty(N_MOMENTS)

    jump[0], enter[0], leave[0], number[0], length[0] = -1, start, start, 0, 0.0
    n_cuts[0], next_first[0], next_last[0] = 0, 0, 0
    if wrap < m:
        length[0] = chord[wrap]
        for i in range(N_MOMENTS):
            moments[0, i] = corner[stop, i]
    depth = 0
    while depth >= 0:
        at = leave[depth]
        s = next_first[depth]
        ahead = first[by_first[s]] if s < n_inside else stop

        # The chords that end from here to where the next jump begins. ``inside`` is the number
        # of the part from ``behind`` on, among the paths to where the chord ends.
        n, previous, inside, behind, t = n_cuts[depth], -1, 0, 0, 0
        for i in range(next_last[depth], last_at[ahead + 1]):
            c = by_last[i]
            begin, end = first[c], last[c]
            if end != previous:
                previous, inside, behind, t = end, 0, end, depth
            while leave[t] > begin:
                inside += paths[end, leave[t]] - paths[end, behind] + offsets[end, jump[t]]
                behind = enter[t]
                t -= 1
            # It begins under a jump.
            if behind < begin:
                continue
            under = inside + paths[end, begin] - paths[end, behind]
            # Number 0 is the chord itself: it is on the boundary.
            if under > 0:
                up_to_begin = number[t] + to_stop[leave[t]] - to_stop[begin]
                up_to_end = number[depth] + to_stop[at] - to_stop[end]
                cut[n] = c
                cut_left[n] = bases[c] + under
                cut_shift[n] = up_to_begin + offset[c] - up_to_end
                cut_value[n] = value[bases[c] + under]
                cut_length[n] = alpha * chord[c]
                n += 1
        n_cuts[depth] = n
        next_last[depth] = last_at[ahead + 1]

        if s < n_inside:
            c = by_first[s]
            next_first[depth] = s + 1
            end = last[c]
            jump[depth + 1], enter[depth + 1], leave[depth + 1] = c, ahead, end
            number[depth + 1] = number[depth] + to_stop[at] - to_stop[ahead] + offset[c]
            length[depth + 1] = length[depth] + arc_to[ahead] - arc_to[at] + chord[c]
            for i in range(N_MOMENTS):
                moments[depth + 1, i] = (
                    moments[depth, i] + (up_to[ahead, i] - up_to[at, i]) + corner[ahead, i]
                )
            n_cuts[depth + 1] = n
            next_first[depth + 1], next_last[depth + 1] = first_at[end], last_at[end]
            depth += 1
            continue

        # No jump is left: leave the sub-cycle whole, or make the best of its cuts.
        own = base + number[depth] + to_stop[at] - 1
        for i in range(N_MOMENTS):
            sums[i] = moments[depth, i] + (up_to[stop, i] - up_to[at, i])
        flat = find_determinant(sums) * whole
        if not measures.printed:
            flat = math.sqrt(flat)
        least = flat
        share = 1.0 / (length[depth] + arc_to[stop] - arc_to[at])
        for i in range(n):
            total[i] = cut_value[i] + value[own + cut_shift[i]] + share * cut_length[i]
            least = min(least, total[i])
        value[own], fewest[own], choice[own] = flat, 0, -1
        if flat > least + tie:
            best = -1
            for i in range(n):
                if total[i] > least + tie:
                    continue
                n_chords = 1 + fewest[cut_left[i]] + fewest[own + cut_shift[i]]
                if (
                    best < 0
                    or n_chords < fewest[own]
                    or (n_chords == fewest[own] and cut[i] < cut[best])
                ):
                    best = i
                    value[own], fewest[own], choice[own] = total[i], n_chords, cut[i]
        depth -= 1


@kernel
def _inside(
    wrap: int, start: int, stop: int, numbering: Subcycles
) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
    """The chords between two ends but for the wrap, by their first end and by their last, and
    where in these orders those of every end begin."""
    starting, start_at = numbering.starting, numbering.start_at
    ending, end_at = numbering.ending, numbering.end_at
    by_first = np.empty(len(starting), np.int64)
    by_last = np.empty(len(starting), np.int64)
    first_at = np.empty(stop + 2, np.int64)
    last_at = np.empty(stop + 2, np.int64)
    n_first, n_last = 0, 0
    for v in range(start, stop + 1):
        first_at[v], last_at[v] = n_first, n_last
        for s in range(start_at[v], start_at[v + 1]):
            c = starting[s]
            if numbering.last[c] <= stop and c != wrap:
                by_first[n_first] = c
                n_first += 1
        for s in range(end_at[v], end_at[v + 1]):
            c = ending[s]
            if numbering.first[c] >= start and c != wrap:
                by_last[n_last] = c
                n_last += 1
    first_at[stop + 1], last_at[stop + 1] = n_first, n_last
    return by_first[:n_first], first_at, by_last[:n_last], last_at


@kernel
def trace_pieces(
    n: int, numbering: Subcycles, choice: NDArray[np.int32], n_chosen: int
) -> tuple[Int64Array, Int64Array, Int64Array]:
    """The chosen chords, and the pieces' positions with the bounds between the pieces."""
    m, k = len(numbering.first), len(numbering.ends)
    chosen = np.empty(n_chosen, np.int64)
    bounds = np.empty(n_chosen + 1, np.int64)
    positions = np.empty(n + 2 * n_chosen, np.int64)
    path = np.empty(k + 1, np.int64)
    steps = np.empty(k + 1, np.int64)
    open_wraps = np.empty(n_chosen + 1, np.int64)
    open_numbers = np.empty(n_chosen + 1, np.int64)
    open_wraps[0], open_numbers[0] = m, numbering.paths[k, 0] - 1
    n_open, n_cuts, n_pieces, n_positions = 1, 0, 0, 0
    while n_open:
        n_open -= 1
        wrap, number = open_wraps[n_open], open_numbers[n_open]
        n_steps = path_of(numbering, wrap, number, path, steps)
        c = choice[numbering.base[wrap] + number]
        if c < 0:
            n_positions = _write_piece(
                n, numbering, wrap, path, steps, n_steps, positions, n_positions
            )
            bounds[n_pieces] = n_positions
            n_pieces += 1
            continue
        chosen[n_cuts] = c
        n_cuts += 1
        a = 0
        while path[a] < numbering.first[c]:
            a += 1
        b = a
        while path[b] < numbering.last[c]:
            b += 1
        stop = path[n_steps]
        without = 0
        for t in range(a, b):
            without += step_offset(numbering, path[t], steps[t], stop)
        open_wraps[n_open], open_numbers[n_open] = c, part_number(numbering, path, steps, a, b)
        n_open += 1
        open_wraps[n_open] = wrap
        open_numbers[n_open] = number - without + numbering.offsets[stop, c]
        n_open += 1
    return chosen, bounds[: n_pieces - 1], positions


@kernel
def _write_piece(
    n: int,
    numbering: Subcycles,
    wrap: int,
    path: Int64Array,
    steps: Int64Array,
    n_steps: int,
    positions: Int64Array,
    at: int,
) -> int:
    """Write a piece's positions from ``at`` on; returns where they stop."""
    ends = numbering.ends
    for t in range(n_steps):
        begin = ends[path[t]]
        stop = begin + 1
        if steps[t] < 0:
            stop = ends[path[t] + 1] if path[t] + 1 < len(ends) else ends[0] + n
        for v in range(begin, stop):
            positions[at] = v % n
            at += 1
    if wrap < len(numbering.first):
        positions[at] = ends[path[n_steps]]
        at += 1
    return at
