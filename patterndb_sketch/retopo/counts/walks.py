"""Walks: closed ways across chains, each of them one edge more or fewer, that make counts better.

Whoever goes through a patch changes two of its chains by 1, so that it stays even. A walk is
closed, or comes from outside and goes back there. It visits no patch twice, so that what it gains
is the sum over its steps, and it is found as a shortest path of negative length. Of a cyclic
sequence with a negative sum some rotation has negative sums from its beginning to every place (Lin
and Kernighan 1973, the gain criterion): ways that have cost something are given up at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.counts.problem import MIN_PERIMETER, CountsProblem
from patterndb_sketch.retopo.counts.rules import is_cheap

Int8Array = NDArray[np.int8]

#: What a patch is after a change.
CHEAP, IRREGULAR, FORBIDDEN = 0, 1, 2

#: Patches that a walk may visit: half the gain of longer ones is had by shorter ones in a tenth
#: of the time (200 to 1000 patches), and beyond the last hardly any is left.
MOST_STEPS = (6, 12, 24)

#: Gains below this are rounding.
GAIN = 1e-6


class Maze(NamedTuple):
    """What walks are searched in: *doors* are occurrences of chains in patches.

    chain, patch, side: (k,) int32 of every door; place: (k,) its number within the patch.
    twin: (k,) the door on the other side of the chain, -1 where that is outside.
    first_door: (p + 1,) int32; first_side: (p + 1,) int32 as in the problem.
    first_after: (p + 1,) int64; after: int8, for every patch of d doors a (2 d, 2 d) table of what
        it is if a door gets one edge more (2 place + 1) or fewer (2 place) and another too; one
        door twice is a change by 2.
    state: (p,) int8 what every patch is now.
    step:  (c, 4) float64: what a chain's change by -2, -1, 1, 2 costs, inf where it may not.
    """

    chain: Int32Array
    patch: Int32Array
    side: Int32Array
    place: Int32Array
    twin: Int32Array
    first_door: Int32Array
    first_side: Int32Array
    first_after: NDArray[np.int64]
    after: Int8Array
    state: Int8Array
    step: Floats


def maze_of(problem: CountsProblem) -> Maze:
    """The doors of a problem; tables and costs are still to be filled in."""
    n_doors = len(problem.chains)
    side = np.repeat(np.arange(len(problem.first_chain) - 1), np.diff(problem.first_chain))
    patch_of_side = np.repeat(np.arange(problem.n_patches), np.diff(problem.first_side))
    patch = patch_of_side[side] if n_doors else np.zeros(0, np.int64)
    first_door = problem.first_chain[problem.first_side].astype(np.int32)
    twin = np.full(n_doors, -1, np.int32)
    order = np.argsort(problem.chains, kind="stable")
    same = np.flatnonzero(problem.chains[order][1:] == problem.chains[order][:-1])
    twin[order[same]] = order[same + 1]
    twin[order[same + 1]] = order[same]
    size = (2 * np.diff(first_door).astype(np.int64)) ** 2
    first_after = np.concatenate([[0], np.cumsum(size)]).astype(np.int64)
    return Maze(
        problem.chains,
        patch.astype(np.int32),
        side.astype(np.int32),
        (np.arange(n_doors) - first_door[patch]).astype(np.int32),
        twin,
        first_door,
        problem.first_side,
        first_after,
        np.zeros(first_after[-1], np.int8),
        np.zeros(problem.n_patches, np.int8),
        np.zeros((problem.n_chains, 4)),
    )


@kernel
def judge(maze: Maze, lengths: Int32Array, patches: Int32Array) -> None:
    """Write what patches are, and would be, by :func:`rules.has_cheap_fill`.

    lengths: (s,) int32 of all sides; left as they are.
    """
    for f in patches:
        low, high = int(maze.first_side[f]), int(maze.first_side[f + 1])
        perimeter = 0
        for k in range(low, high):
            perimeter += lengths[k]
        maze.state[f] = CHEAP if is_cheap(lengths, low, high) else IRREGULAR
        doors = maze.first_door[f + 1] - maze.first_door[f]
        at = maze.first_after[f]
        for one in range(2 * doors):
            for other in range(2 * doors):
                by = 2 * (one % 2) - 1
                too = 2 * (other % 2) - 1
                here = maze.side[maze.first_door[f] + one // 2]
                there = maze.side[maze.first_door[f] + other // 2]
                lengths[here] += by
                lengths[there] += too
                if perimeter + by + too < MIN_PERIMETER:
                    maze.after[at] = FORBIDDEN
                else:
                    maze.after[at] = CHEAP if is_cheap(lengths, low, high) else IRREGULAR
                lengths[here] -= by
                lengths[there] -= too
                at += 1


@kernel
def _through(maze: Maze, door: int, more: int, out: int, too: int, regularity: float) -> float:
    """What a patch costs more if two of its doors change; more, too: 1 up, 0 down."""
    f = maze.patch[door]
    width = 2 * (maze.first_door[f + 1] - maze.first_door[f])
    at = maze.first_after[f] + (2 * maze.place[door] + more) * width + 2 * maze.place[out] + too
    if maze.after[at] == FORBIDDEN:
        return np.inf
    return regularity * (int(maze.after[at]) - int(maze.state[f]))


@kernel
def single(maze: Maze, door: int, more: int, regularity: float) -> float:
    """What it costs to change one chain alone: by 2, or by 1 if it is in its patch twice."""
    twin = maze.twin[door]
    if twin >= 0 and maze.patch[twin] == maze.patch[door]:
        return maze.step[maze.chain[door], 1 + more] + _through(
            maze, door, more, twin, more, regularity
        )
    cost = maze.step[maze.chain[door], 3 * more] + _through(
        maze, door, more, door, more, regularity
    )
    if twin >= 0:
        cost += _through(maze, twin, more, twin, more, regularity)
    return cost


@kernel
def find_walk(
    maze: Maze,
    starts: Int32Array,
    begin: int,
    most_steps: int,
    regularity: float,
    walk: Int32Array,
) -> tuple[int, int, float]:
    """The first walk that gains, from any of the doors ``starts``, looked at from place begin on.

    walk: (w, 2) int32 with w > most_steps + 1, gets chains and their changes. Returns how many
    there are, 0 where no walk gains; the place of the start looked at last; and the gain.
    """
    n_doors = len(maze.chain)
    outside = 2 * n_doors
    length = np.empty(outside + 1)
    before = np.empty(outside + 1, np.int32)
    way_out = np.empty(outside + 1, np.int32)
    steps = np.empty(outside + 1, np.int32)
    waiting = np.zeros(outside + 1, np.bool_)
    stamp = np.full(outside + 1, -1, np.int32)
    queue = np.empty(outside + 1, np.int32)
    rim = np.flatnonzero(maze.twin < 0).astype(np.int32)
    for s in range(begin, len(starts)):
        for more in range(2):
            gain = -single(maze, starts[s], more, regularity)
            if gain > GAIN:
                twin = maze.twin[starts[s]]
                by = 1 if twin >= 0 and maze.patch[twin] == maze.patch[starts[s]] else 2
                walk[0, 0] = maze.chain[starts[s]]
                walk[0, 1] = by if more else -by
                return 1, s, gain
            root = 2 * starts[s] + more
            name = 2 * s + more
            if np.isinf(maze.step[maze.chain[starts[s]], 1 + more]):
                continue
            length[root] = 0.0
            before[root] = -1
            steps[root] = 0
            stamp[root] = name
            queue[0] = root
            head, count = 0, 1
            while count:
                at = queue[head]
                head = (head + 1) % (outside + 1)
                count -= 1
                waiting[at] = False
                if steps[at] >= most_steps:
                    continue
                if at == outside:
                    low, high = 0, len(rim)
                else:
                    f = maze.patch[at // 2]
                    low, high = maze.first_door[f], maze.first_door[f + 1]
                for d in range(low, high):
                    # From outside one goes in by a door, from a patch out by one.
                    door = rim[d] if at == outside else d
                    if at != outside and door == at // 2:
                        continue
                    into = door if at == outside else maze.twin[door]
                    if at != outside and into >= 0 and maze.patch[into] == maze.patch[door]:
                        continue
                    for too in range(2):
                        reached = length[at] + maze.step[maze.chain[door], 1 + too]
                        if at != outside and reached < regularity:
                            reached += _through(maze, at // 2, at % 2, door, too, regularity)
                        if reached >= -GAIN:
                            continue
                        target = outside if into < 0 else 2 * into + too
                        if target == root:
                            n, gain = _told(maze, at, door, too, before, way_out, regularity, walk)
                            if gain > GAIN:
                                return n, s, gain
                            continue
                        if stamp[target] == name and reached >= length[target] - GAIN:
                            continue
                        if _visited(maze, target, at, before, outside):
                            continue
                        length[target] = reached
                        before[target] = at
                        way_out[target] = 2 * door + too
                        steps[target] = steps[at] + 1
                        if stamp[target] != name or not waiting[target]:
                            waiting[target] = True
                            queue[(head + count) % (outside + 1)] = target
                            count += 1
                        stamp[target] = name
    return 0, len(starts), 0.0


@kernel
def _visited(maze: Maze, target: int, at: int, before: Int32Array, outside: int) -> bool:
    """Is the target's patch, or the outside, on the way to here?"""
    steps = 0
    longest = len(before)
    while at >= 0:
        steps += 1
        if target == outside or at == outside:
            if target == at:
                return True
        elif maze.patch[target // 2] == maze.patch[at // 2]:
            return True
        # Labels change while others still lead to them: such a way may bite its tail.
        if steps > longest:
            return True
        at = before[at]
    return False


@kernel
def _told(
    maze: Maze,
    last: int,
    door: int,
    too: int,
    before: Int32Array,
    way_out: Int32Array,
    regularity: float,
    walk: Int32Array,
) -> tuple[int, float]:
    """Chains and changes of the walk that closes by a door, and its gain; 0 if it is none.

    It is followed back afresh, as labels on the way may have changed since.
    """
    outside = 2 * len(maze.chain)
    cost = 0.0
    n = 0
    at = last
    leaving = 2 * door + too
    seen = np.empty(len(walk), np.int32)
    while True:
        if n == len(walk):
            return 0, 0.0
        place = -1 if at == outside else maze.patch[at // 2]
        for i in range(n):
            if seen[i] == place or walk[i, 0] == maze.chain[leaving // 2]:
                return 0, 0.0
        seen[n] = place
        walk[n, 0] = maze.chain[leaving // 2]
        walk[n, 1] = 2 * (leaving % 2) - 1
        n += 1
        cost += maze.step[maze.chain[leaving // 2], 1 + leaving % 2]
        if at != outside:
            cost += _through(maze, at // 2, at % 2, leaving // 2, leaving % 2, regularity)
        if before[at] < 0:
            return n, -cost
        leaving = way_out[at]
        at = before[at]
