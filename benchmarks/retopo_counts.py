"""Counts for whole networks: what they cost, and how long one changed count takes.

    python benchmarks/retopo_counts.py --patches 50,200 --seeds 3
    python benchmarks/retopo_counts.py --patches 1000 --seeds 1 --no-whole

Networks in the plane: *tilings*, random merges of neighbouring triangles of a Delaunay
triangulation with 2 to 8 corners a patch (a flat place in a side is a T-junction), and *grids* of
jittered quads of which 6 % are cut into triangles and 6 % merged with a neighbour. Totals are
errors of counts + patches without a regular fill, as the complete family of the database has it, at
a regularity of 1, as multiples of the T-join's total: the least errors of all even counts. Next to
these: all counts rounded one by one (how many patches that leaves odd), strips alone, the T-join
improved by neighbourhoods without cycles, and one CP-SAT model of the whole network from the
T-join. Then changes of one count by 1 or 2. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from patterndb_sketch.retopo.counts import CountsProblem, change_count, solve_counts
from patterndb_sketch.retopo.counts.neighbourhoods import (
    grow_neighbourhood,
    list_neighbours,
    solve_neighbourhood,
)
from patterndb_sketch.retopo.counts.parity import (
    even_along_strips,
    even_by_least_errors,
    label_strips,
)

#: Wider corners are flat: the side goes on, past a T-junction.
FLAT = np.radians(150.0)

#: Edges of an average chain.
EDGES = 5.0

#: Shares of a grid's cells that are cut into triangles, and merged.
CUT, MERGED = 0.06, 0.06

#: By how much a grid's points are off, in cells. Then strips cost about three times the T-join.
JITTER = 0.24


def problem_of(points: NDArray[np.float64], faces: list[list[int]]) -> CountsProblem | None:
    """The problem of faces in the plane, None where one has fewer than 2 corners or more than 8.

    faces: vertices of simple polygons, counter-clockwise. Vertices of two edges lie in a chain.
    """
    edges = [(a, b) for face in faces for a, b in zip(face, face[1:] + face[:1], strict=True)]
    degree = np.zeros(len(points), np.int64)
    for a, b in {(min(e), max(e)) for e in edges}:
        degree[a] += 1
        degree[b] += 1
    length: dict[tuple[int, int], float] = {}
    number: dict[tuple[int, int], int] = {}
    patches: list[list[list[int]]] = []
    for face in faces:
        p = points[face]
        back, forth = np.roll(p, 1, axis=0) - p, np.roll(p, -1, axis=0) - p
        angle = np.arctan2(
            forth[:, 0] * back[:, 1] - forth[:, 1] * back[:, 0], (forth * back).sum(1)
        )
        angle %= 2 * np.pi
        node = degree[face] > 2
        # A corner of the whole plane region is a corner too.
        corner = (node & (angle < FLAT)) | (~node & (angle < np.radians(120.0)))
        node |= corner
        if not 2 <= corner.sum() <= 8:
            return None
        first = int(np.flatnonzero(corner)[0])
        sides: list[list[int]] = []
        at, n = first, len(face)
        while at < first + n:
            low = at
            if corner[low % n]:
                sides.append([])
            at += 1
            while not node[at % n]:
                at += 1
            path = [face[i % n] for i in range(low, at + 1)]
            key = min((path[0], path[1]), (path[-1], path[-2]))
            if key not in number:
                number[key] = len(number)
                length[key] = float(np.linalg.norm(np.diff(points[path], axis=0), axis=1).sum())
            sides[-1].append(number[key])
        patches.append(sides)
    lengths = np.array(list(length.values()))
    return CountsProblem.of(EDGES * lengths / lengths.mean(), patches, regularity=1.0)


def tiling(n_patches: int, seed: int) -> CountsProblem:
    """Triangles of random points, merged at random, each pair where the union is a fair disk."""
    chance = np.random.default_rng(seed)
    across = round((1.35 * n_patches) ** 0.5) + 1
    y, x = np.mgrid[:across, :across]
    points = np.stack([x, y], axis=-1).reshape(-1, 2) + chance.uniform(-0.4, 0.4, (across**2, 2))
    faces: dict[int, list[int]] = {}
    for simplex in Delaunay(points).simplices:
        a, b, c = points[simplex]
        area = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
        faces[len(faces)] = [int(v) for v in (simplex if area > 0 else simplex[::-1])]
    while len(faces) > n_patches:
        one = list(faces)[int(chance.integers(len(faces)))]
        face = faces[one]
        at = int(chance.integers(len(face)))
        edge = (face[(at + 1) % len(face)], face[at])
        other = next(
            (k for k, f in faces.items() if edge in zip(f, f[1:] + f[:1], strict=True)), one
        )
        if other == one:
            continue
        union = joined(face, faces[other])
        if union is None or len(union) > 8:
            continue
        faces[one] = union
        del faces[other]
    made = problem_of(points, list(faces.values()))
    # A face of which all corners are flat but one: other merges.
    return tiling(n_patches, seed + 1_000_003) if made is None else made


def joined(one: list[int], other: list[int]) -> list[int] | None:
    """The union of two faces along their one common path, None if they meet elsewhere too."""
    pairs = set(zip(other[1:] + other[:1], other, strict=True))
    common = [(a, b) in pairs for a, b in zip(one, one[1:] + one[:1], strict=True)]
    n = len(one)
    starts = [i for i in range(n) if common[i] and not common[i - 1]]
    if len(starts) != 1 or len(set(one) & set(other)) != sum(common) + 1:
        return None
    begin, length = starts[0], sum(common)
    mine = [one[(begin + length + i) % n] for i in range(n - length + 1)]
    at = other.index(mine[-1])
    theirs = [other[(at + i) % len(other)] for i in range(len(other) - length + 1)]
    return mine[:-1] + theirs[:-1]


def grid(n_patches: int, seed: int) -> CountsProblem:
    """Jittered quads, some cut into triangles, some merged with the next."""
    chance = np.random.default_rng(seed)
    rows = round(n_patches**0.5)
    columns = -(-n_patches // rows)
    y, x = np.mgrid[: rows + 1, : columns + 1]
    points = np.stack([x, y], axis=-1).reshape(-1, 2) + chance.uniform(
        -JITTER, JITTER, ((rows + 1) * (columns + 1), 2)
    )
    faces: list[list[int]] = []
    merged = False
    for i in range(rows):
        for j in range(columns):
            a = i * (columns + 1) + j
            d = a + columns + 1
            cell = [a, a + 1, d + 1, d]
            draw = chance.random()
            if merged:
                faces[-1] = [a - 1, a, a + 1, d + 1, d, d - 1]
                merged = False
            elif draw < CUT:
                faces += [cell[:3], [a, d + 1, d]]
            else:
                faces.append(cell)
                merged = draw > 1 - MERGED and j + 1 < columns
    made = problem_of(points, faces)
    return grid(n_patches, seed + 1_000_003) if made is None else made


def clocked(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def chosen_row(kind: str, problem: CountsProblem, seed: int, arguments: argparse.Namespace) -> str:
    rounded = np.maximum(np.round(problem.targets), problem.least).astype(np.int32)
    n_odd = int((problem.perimeters(rounded) % 2).sum())
    join = even_by_least_errors(problem)
    base = problem.sum_costs(join.counts)
    join_seconds = clocked(lambda: even_by_least_errors(problem))
    tied = even_along_strips(problem, label_strips(problem)).counts
    walked = solve_counts(problem, 0)
    walk_seconds = clocked(lambda: solve_counts(problem, 0))
    found = solve_counts(problem)
    seconds = clocked(lambda: solve_counts(problem))
    long = solve_counts(problem, arguments.long)
    assert not np.any(problem.perimeters(found.counts) % 2)
    whole = "-"
    if not arguments.no_whole:
        patches = range(problem.n_patches)
        solved = solve_neighbourhood(problem, join.counts, patches, arguments.whole)
        whole = f"{problem.sum_costs(solved) / base:.3f}"

    def share(counts: NDArray[np.int32]) -> str:
        return f"{problem.sum_costs(counts) / base:.3f}"

    errors = float(problem.errors(join.counts).sum())
    irregular = int(problem.find_irregular_patches(join.counts).sum())
    return (
        f"| {kind} {problem.n_patches}, {seed} | {problem.n_chains} | {n_odd} | "
        f"{errors:.1f} + {irregular} | {1e3 * join_seconds:.0f} | {share(tied)} | "
        f"{share(search_alone(problem, arguments.seconds))} | {whole} | "
        f"{walked.total / base:.3f} | {walk_seconds:.2f} | "
        f"**{found.total / base:.3f}** | {seconds:.2f} | {long.total / base:.3f} | "
        f"{found.cost:.1f} + {len(found.irregular)} |"
    )


def search_alone(problem: CountsProblem, seconds: float) -> NDArray[np.int32]:
    """The T-join improved by neighbourhoods of 16 patches for some seconds, without cycles."""
    near = list_neighbours(problem)
    counts = even_by_least_errors(problem).counts
    start, at = time.perf_counter(), 0
    while time.perf_counter() - start < seconds:
        patches = grow_neighbourhood(near, at % problem.n_patches, 16)
        made = solve_neighbourhood(problem, counts, patches, 0.1)
        counts = made if problem.sum_costs(made) <= problem.sum_costs(counts) else counts
        at += 5
    return counts


def changes_row(name: str, problem: CountsProblem, seed: int, n_changes: int) -> str:
    chance = np.random.default_rng(seed)
    counts = solve_counts(problem, 0).counts
    change_count(problem, counts, 0, int(counts[0]) + 1)
    quick: list[float] = []
    others: list[int] = []
    for _ in range(n_changes):
        chain = int(chance.integers(problem.n_chains))
        count = max(1, int(counts[chain]) + int(chance.choice([-2, -1, 1, 2])))
        start = time.perf_counter()
        found = change_count(problem, counts, chain, count)
        quick.append(1e3 * (time.perf_counter() - start))
        assert not np.any(problem.perimeters(found.counts) % 2)
        others.append(int((found.counts != counts).sum()))
    return (
        f"| {name} | {statistics.median(quick):.1f} | {max(quick):.1f} | "
        f"{statistics.mean(others):.1f} | {max(others)} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--patches", default="50,200", help="with commas")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=2.0, help="without cycles")
    parser.add_argument("--long", type=int, default=50, help="neighbourhoods of the long search")
    parser.add_argument("--whole", type=float, default=5.0, help="work on the whole model")
    parser.add_argument("--no-whole", action="store_true")
    parser.add_argument("--changes", type=int, default=100)
    arguments = parser.parse_args()
    sizes = [int(size) for size in arguments.patches.split(",")]
    kinds = {"tiling": tiling, "grid": grid}
    solve_counts(grid(20, 0))
    print(
        "| network, seed | chains | odd if rounded | T-join: errors + irregular | ms | strips | "
        f"neighbourhoods alone, {arguments.seconds:g} s | whole model | cycles | s | chosen "
        f"| s | {arguments.long} neighbourhoods | chosen: errors + irregular |"
    )
    print("|---|" + "---:|" * 13)
    for kind, make in kinds.items():
        for size in sizes:
            for seed in range(1, arguments.seeds + 1):
                print(chosen_row(kind, make(size, seed), seed, arguments), flush=True)
    print("\n| one count changed | ms, median | worst | chains changed | most |")
    print("|---|" + "---:|" * 4)
    for kind, make in kinds.items():
        for size in sizes:
            for regularity in (1.0, 3.0):
                problem = make(size, 1).with_regularity(regularity)
                name = f"{kind} {problem.n_patches}, regularity {regularity:g}"
                print(changes_row(name, problem, size, arguments.changes), flush=True)


if __name__ == "__main__":
    main()
