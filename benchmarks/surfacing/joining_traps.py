"""Are curves left apart that pass each other on purpose?

    python benchmarks/surfacing/joining_traps.py [--seed N ...] [--each]

Of the drawings of tests/support/surfacing/joiningtraps.py, counts those in which a pair has more
nodes in common than it is meant to have, and the pairs that have fewer than they are meant to have.
Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse

from patterndb_sketch.curvenetwork.joining import network_of_polylines
from tests.support.surfacing.joiningtraps import list_traps


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, nargs="+", default=[1, 2, 3], help="of the generator")
    parser.add_argument("--each", action="store_true", help="name those that are not right")
    args = parser.parse_args()
    print("| seed | drawings | joined wrongly | pairs not joined |")
    print("|---:|---:|---:|---:|")
    for seed in args.seed:
        row = [0, 0, 0]
        for name, trap in list_traps(seed):
            network = network_of_polylines(list(trap.curves.values()), list(trap.curves))
            joined, missed = trap.compare(network)
            if args.each and (joined or missed):
                print(f"{name}: joined {joined}, not joined {missed}", flush=True)
            row = [row[0] + 1, row[1] + bool(joined), row[2] + len(missed)]
        print(f"| {seed} | {row[0]} | {row[1]} | {row[2]} |", flush=True)


if __name__ == "__main__":
    main()
