"""Are the patches found that are meant in networks as people draw them?

    python benchmarks/surfacing/drawn_cycles.py [--seed N] [--every N] [--unit LENGTH] [--each]

Of the networks of tests/support/surfacing/drawnnetworks.py, joined by default: patches that are
meant, those of them that are found, and false ones, by the fault and how great it is, for each half
of the families.
Constants were chosen on the first half; the second only reports. --every takes every N-th network,
--unit draws them in another unit, the curves in another order and direction; --each names the
networks in which something is missing or false. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import time
from itertools import islice

import numpy as np

from patterndb_sketch.curvenetwork.joining import network_of_polylines
from patterndb_sketch.surfacing.cycles import find_cycles
from tests.support.surfacing.drawnnetworks import (
    FAULTS,
    HALVES,
    LEVELS,
    DrawnCurves,
    list_drawn_networks,
)


def score_network(one: DrawnCurves, unit: float, mixed: np.random.Generator | None) -> list[int]:
    """How many patches are meant, found and false."""
    names = list(one.curves)
    lines = [unit * line for line in one.curves.values()]
    if mixed is not None:
        order = mixed.permutation(len(names)).tolist()
        names = [names[k] for k in order]
        lines = [lines[k][:: int(mixed.choice([-1, 1]))] for k in order]
    network = network_of_polylines(lines, names)
    found = find_cycles(network)
    cycles = [[network.curves[curve].id for curve in cycle.curves] for cycle in found.cycles]
    return [one.meant.total(), *one.compare(cycles)]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1, help="of the generator")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="take every N-th network")
    parser.add_argument("--unit", type=float, help="draw in another unit, order and direction")
    parser.add_argument("--each", action="store_true", help="name those that are not exact")
    args = parser.parse_args()
    mixed = None if args.unit is None else np.random.default_rng(args.seed)
    heads = ("clean, sparse", *(f"{level:g}" for level in LEVELS), "all")
    print(f"| half | fault | {' | '.join(heads)} |")
    print(f"|---|---|{'---:|' * len(heads)}")
    for half in HALVES:
        start = time.process_time()
        sums = {fault: np.zeros((len(heads), 3), int) for fault in (*FAULTS, "all")}
        for one in islice(list_drawn_networks(half, args.seed), None, None, args.every):
            row = score_network(one, args.unit or 1.0, mixed)
            if args.each and (row[1] != row[0] or row[2]):
                print(f"{one.name}: {row[0]} meant, {row[1]} found, {row[2]} false", flush=True)
            column = 1 + LEVELS.index(one.level) if one.level else 0
            for name in (one.fault, "all"):
                if name in sums:
                    sums[name][[column, -1]] += row
        for fault, rows in sums.items():
            cells = [f"{hit:,} of {meant:,}, {false} false" for meant, hit, false in rows]
            print(f"| {half} | {fault} | {' | '.join(cells)} |")
        print(f"\n{time.process_time() - start:.0f} CPU s\n", flush=True)


if __name__ == "__main__":
    main()
