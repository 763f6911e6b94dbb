"""Are the cycles found in a network the patches that its author meant?

    python benchmarks/cycles.py [--shared ../shared] [--only NAME]

Two kinds of networks, and nothing but their curves is used. Of cages and of the trebol network
all patches are known: found, missing and too many are counted. Of the CASSIE sketches, drawn
freehand, the record tells which patches were ever made in the session, by the program or the
user, as the strokes around each.

A recorded patch counts if it was not deleted by hand and all of its strokes are in the final
sketch; several with the same set of strokes count once. A found cycle matches if the set of its
curves' strokes is that of a patch that counts.

    recall:    sets of strokes that count and are found / sets that count.
    precision: found cycles that match / found cycles.

What the program itself deleted is not recorded: where a later stroke cut a patch, the record
holds the old patch and both parts. So recall has a bound below 1, which is printed beside it:
"walks" is the share of the sets whose strokes can all be in one simple closed walk, "bound" the
largest share that cycles can have of which no more than two pass any curve (of the cycles among
BOUND_CLOSINGS closings per pair of curves). Precision has none that is known, but a sketch may
show patches that its author never made.

Where a later stroke parts a patch, both parts are right, recorded or not, and the old patch is met
by what they span together. So two more shares are printed. A set of strokes that counts and is not
found is met if it is around two or three found cycles that hang together:

    met:   sets that are found or met / sets that count.
    right: found cycles that match or are part of what is so met / found cycles.

The constants were set by hand on all sketches, coarsely; "even" and "odd" are the means over
every second sketch by name. Seconds are CPU time of one run each.
Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ortools.sat.python import cp_model

from ingest.formats import read_mesh
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.cycles import find_cycles
from patterndb_sketch.surfacing.cycles.closing import (
    find_candidate_cycles,
    find_dangling,
    list_half_curves,
)
from patterndb_sketch.surfacing.networkfile import read_network, read_recorded_patches

#: Closings per pair of curves for the bound: more find next to no further patch.
BOUND_CLOSINGS = 20

#: Walks that are tried to use all strokes of a patch, before it counts as possible.
MOST_WALKS = 300_000

Strokes = frozenset[int | str]


@dataclass(frozen=True, slots=True)
class SketchRow:
    """A sketch: its size, what was found of it, and what could be."""

    name: str
    curves: int
    patches: int
    found: int
    recall: float
    precision: float
    met: float
    right: float
    walks: float
    bound: float
    proven: bool
    seconds: float


def patches_of(path: Path, network: CurveNetwork) -> set[Strokes]:
    """The sets of strokes that count."""
    drawn = {curve.stroke for curve in network.curves}
    return {
        frozenset(patch.strokes)
        for patch in read_recorded_patches(path)
        if not patch.manually_deleted and drawn.issuperset(patch.strokes)
    }


def strokes_of(network: CurveNetwork, curves: Sequence[int]) -> Strokes:
    return frozenset(network.curves[curve].stroke for curve in curves)


def sketch_row(path: Path, bounds: bool = False) -> SketchRow:
    """What is found of a sketch; the bounds too if asked for, else nan."""
    network = read_network(path)
    patches = patches_of(path, network)
    start = time.process_time()
    result = find_cycles(CurveNetwork(network.curves, network.nodes))
    seconds = time.process_time() - start
    found = [strokes_of(network, cycle.curves) for cycle in result.cycles]
    met, parts = meet_together(network, result.cycles, patches.difference(found))
    right = sum(strokes in patches or i in parts for i, strokes in enumerate(found))
    return SketchRow(
        path.stem,
        len(network.curves),
        len(patches),
        len(found),
        len(patches.intersection(found)) / len(patches),
        sum(strokes in patches for strokes in found) / max(1, len(found)),
        len(patches.intersection(found) | met) / len(patches),
        right / max(1, len(found)),
        sum(has_walk(network, p) for p in patches) / len(patches) if bounds else math.nan,
        bound(network, patches) / len(patches) if bounds else math.nan,
        result.proven,
        seconds,
    )


def meet_together(
    network: CurveNetwork, cycles: Sequence[Cycle], wanted: set[Strokes]
) -> tuple[set[Strokes], set[int]]:
    """Those of the sets that are around two or three cycles together, and the numbers of these."""
    curves = [frozenset(cycle.curves) for cycle in cycles]
    beside = [
        {j for j in range(len(curves)) if j != i and curves[i] & curves[j]}
        for i in range(len(curves))
    ]
    met: set[Strokes] = set()
    parts: set[int] = set()
    for i, neighbours in enumerate(beside):
        for j in neighbours:
            for k in ({i} | neighbours | beside[j]) - {j}:
                around = curves[i] ^ curves[j]
                if k != i:
                    around ^= curves[k]
                strokes = strokes_of(network, sorted(around))
                if strokes in wanted:
                    met.add(strokes)
                    parts |= {i, j, k}
    return met, parts


def has_walk(network: CurveNetwork, strokes: Strokes) -> bool:
    """Is there a simple closed walk along curves of these strokes, of each at least one?"""
    at: dict[int, list[tuple[int, int]]] = {}
    first: list[int] = []
    for number, curve in enumerate(network.curves):
        if curve.stroke in strokes:
            if curve.closed and len(strokes) == 1:
                return True
            first.append(number)
            for a, b in (curve.nodes, curve.nodes[::-1]):
                at.setdefault(a, []).append((number, b))
    rarest = min(strokes, key=lambda s: sum(network.curves[i].stroke == s for i in first))
    tried = 0
    for start in first:
        target, node = network.curves[start].nodes
        if network.curves[start].stroke != rarest or target == node:
            continue
        waiting = [(node, frozenset([node]), frozenset([rarest]), start)]
        while waiting:
            tried += 1
            if tried > MOST_WALKS:
                return True
            node, seen, used, last = waiting.pop()
            for curve, other in at[node]:
                if curve in (last, start):
                    continue
                now = used | {network.curves[curve].stroke}
                if other == target:
                    if now == strokes:
                        return True
                elif other not in seen:
                    waiting.append((other, seen | {other}, now, curve))
    return False


def bound(network: CurveNetwork, patches: set[Strokes]) -> int:
    """The most patches that cycles can match together, two of them at a curve at most."""
    halves = list_half_curves(network, ~find_dangling(network))
    candidates, _ = find_candidate_cycles(network, halves, BOUND_CLOSINGS)
    model = cp_model.CpModel()
    at: dict[int, list[cp_model.IntVar]] = {}
    by_patch: dict[Strokes, list[cp_model.IntVar]] = {}
    for key in candidates:
        strokes = strokes_of(network, key)
        if strokes in patches:
            chosen = model.new_bool_var("")
            by_patch.setdefault(strokes, []).append(chosen)
            for curve in key:
                at.setdefault(curve, []).append(chosen)
    for group in at.values():
        model.add(sum(group) <= 2)
    for group in by_patch.values():
        model.add(sum(group) <= 1)
    model.maximize(sum(chosen for group in by_patch.values() for chosen in group))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.linearization_level = 2
    solver.parameters.max_deterministic_time = 10.0
    solver.solve(model)
    return math.floor(solver.best_objective_bound + 1e-6)


def faces_network(points: np.ndarray, faces: Sequence[Sequence[int]]) -> CurveNetwork:
    """The edges of faces as straight curves, the faces as cycles."""
    number: dict[tuple[int, int], int] = {}
    walks = [list(zip(face, [*face[1:], face[0]], strict=True)) for face in faces]
    for walk in walks:
        for a, b in walk:
            number.setdefault((min(a, b), max(a, b)), len(number))
    network = CurveNetwork.from_edges(points, list(number))
    cycles = tuple(Cycle(tuple((number[min(s), max(s)], s[0] > s[1]) for s in w)) for w in walks)
    return CurveNetwork(network.curves, network.nodes, cycles)


def torus(m: int, n: int) -> CurveNetwork:
    """An m x n grid on a torus of radii 3 and 1."""
    u, v = np.meshgrid(2 * np.pi * np.arange(m) / m, 2 * np.pi * np.arange(n) / n, indexing="ij")
    radius = 3 + np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), np.sin(v)], axis=-1).reshape(-1, 3)

    def at(i: int, j: int) -> int:
        return i % m * n + j % n

    faces = [
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(m) for j in range(n)
    ]
    return faces_network(points, faces)


def prism(n: int) -> CurveNetwork:
    """A regular prism, 1.3 high."""
    at = 2 * np.pi * np.arange(n) / n
    ground = np.stack([np.cos(at), np.sin(at), 0 * at], axis=1)
    sides = [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
    faces = [list(range(n))[::-1], list(range(n, 2 * n)), *sides]
    return faces_network(np.concatenate([ground, ground + np.array([0, 0, 1.3])]), faces)


def known(shared: Path) -> Iterator[tuple[str, CurveNetwork]]:
    """Networks with all of their cycles."""
    for n in (3, 4, 5, 6, 8):
        yield f"prism, {n} sides", prism(n)
    for m, n in ((3, 3), (4, 4), (4, 5), (5, 4), (5, 5), (6, 8), (8, 6), (12, 4), (12, 16)):
        yield f"torus, {m} x {n}", torus(m, n)
    yield "trebol", read_network(shared / "data" / "curves" / "salvi" / "trebol_network.json")
    for name in ("spot", "penguin"):
        mesh = read_mesh(shared / "data" / "meshes" / f"{name}.obj")
        faces = [face.tolist() for face in np.split(mesh.corners, mesh.offsets[1:-1])]
        yield name, faces_network(mesh.points, faces)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--only", help="one network")
    args = parser.parse_args()
    find_cycles(prism(3))
    print("| network | curves | cycles | found | missing | too many | seconds |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for name, network in known(args.shared):
        if args.only in (None, name):
            start = time.process_time()
            result = find_cycles(CurveNetwork(network.curves, network.nodes))
            seconds = time.process_time() - start
            meant = {cycle.key for cycle in network.cycles}
            found = {cycle.key for cycle in result.cycles}
            counts = (len(network.curves), len(meant), len(found))
            cells = [*counts, len(meant - found), len(found - meant), f"{seconds:.2f}"]
            print(f"| {name} | {' | '.join(map(str, cells))} |", flush=True)
    print()
    print(
        "| sketch | curves | patches | found | recall | precision | met | right | walks | bound "
        "| proven | seconds |"
    )
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|---:|")
    rows: list[SketchRow] = []
    for path in sorted((args.shared / "data" / "curves" / "cassie" / "graph").glob("*.json")):
        if args.only in (None, path.stem) and read_recorded_patches(path):
            row = sketch_row(path, bounds=True)
            rows.append(row)
            shares = (row.recall, row.precision, row.met, row.right, row.walks, row.bound)
            cells = [row.name, row.curves, row.patches, row.found]
            cells += [f"{share:.3f}" for share in shares]
            cells += ["yes" if row.proven else "no", f"{row.seconds:.2f}"]
            print(f"| {' | '.join(map(str, cells))} |", flush=True)
    for name, some in (("mean", rows), ("mean, even", rows[::2]), ("mean, odd", rows[1::2])):
        if some:
            table = np.array(
                [(r.recall, r.precision, r.met, r.right, r.walks, r.bound) for r in some]
            )
            means = " | ".join(f"{mean:.3f}" for mean in table.mean(axis=0))
            print(f"| {name} | | | | {means} | | |")


if __name__ == "__main__":
    main()
