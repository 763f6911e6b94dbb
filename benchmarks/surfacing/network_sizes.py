"""How do time and memory of finding cycles grow with the network?

    python benchmarks/surfacing/network_sizes.py [SIZE...]

Square grids of SIZE by SIZE cells, all of which are to be found; and random networks: of 10,000
curves that meet nothing, and of 10,000 edges between 5,000 random points. Each in a process of its
own, the kernels compiled before. Seconds are of CPU time, of one run; memory is the most that the
process had. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing import find_cycles

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cycles import faces_network

SIZES = (10, 20, 40, 70, 100)
RANDOM_CURVES = 10_000
SEED = 1


def make_grid(n: int) -> CurveNetwork:
    """A flat grid of n by n squares, each of them a cycle."""
    across, along = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    points = np.stack([across, along, 0.0 * across], axis=-1).reshape(-1, 3)
    corners = [[i, i + n + 1, i + n + 2, i + 1] for i in range(n * (n + 1)) if (i + 1) % (n + 1)]
    return faces_network(points, corners)


def make_random(kind: str) -> CurveNetwork:
    """RANDOM_CURVES straight curves: ``apart`` from each other, or a ``graph`` on random points."""
    rng = np.random.default_rng(SEED)
    if kind == "apart":
        ends = rng.random((RANDOM_CURVES, 2, 3))
        ends[:, 1] = ends[:, 0] + 0.01 * rng.normal(size=(RANDOM_CURVES, 3))
        pairs = np.arange(2 * RANDOM_CURVES).reshape(-1, 2)
        return CurveNetwork.from_edges(ends.reshape(-1, 3), pairs)
    n = RANDOM_CURVES // 2
    edges: set[tuple[int, int]] = set()
    while len(edges) < RANDOM_CURVES:
        a, b = sorted(rng.integers(n, size=2).tolist())
        if a != b:
            edges.add((a, b))
    return CurveNetwork.from_edges(rng.random((n, 3)), sorted(edges))


def measure_network(name: str) -> str:
    """One row of the table."""
    find_cycles(make_grid(2))
    network = make_grid(int(name)) if name.isdigit() else make_random(name)
    start = time.process_time()
    result = find_cycles(CurveNetwork(network.curves, network.nodes))
    seconds = time.process_time() - start
    found = {cycle.key for cycle in result.cycles}
    meant = {cycle.key for cycle in network.cycles}
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    title = f"grid, {name} x {name}" if name.isdigit() else f"random, {name}"
    missing = f"{len(meant - found):,}" if meant else ""
    proven = "yes" if result.proven else "no"
    return (
        f"| {title} | {len(network.curves):,} | {len(found):,} | {missing} | {proven} "
        f"| {seconds:.1f} | {memory:.0f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, metavar="SIZE")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one:
        print(measure_network(args.one))
        return
    print("| network | curves | found | missing | proven | CPU s | MB |")
    print("|---|---:|---:|---:|---|---:|---:|")
    for name in (*map(str, args.sizes), "apart", "graph"):
        command = [sys.executable, __file__, "--one", name]
        print(subprocess.run(command, check=True, capture_output=True, text=True).stdout, end="")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
