"""Are the patches of clean networks found, each of them and nothing else?

    python benchmarks/surfacing/clean_cycles.py [--family NAME] [--each]

Of all networks of tests/support/surfacing/cleannetworks.py: how many of each family are found
exactly, cycles that are missing, and those that are too many. --each names every network that is
not. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import time

from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing.cycles import find_cycles
from tests.support.surfacing.cleannetworks import CleanNetwork, list_clean_networks


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--family", help="one family")
    parser.add_argument("--each", action="store_true", help="tell those that are not exact")
    args = parser.parse_args()
    families: dict[str, list[CleanNetwork]] = {}
    for one in list_clean_networks():
        if args.family in (None, one.family):
            families.setdefault(one.family, []).append(one)
    print("| family | networks | exact | cycles | missing | too many | CPU s |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    sums = [0, 0, 0, 0, 0, 0.0]
    for family, members in families.items():
        row = [0, 0, 0, 0, 0, 0.0]
        for one in members:
            start = time.process_time()
            found = find_cycles(CurveNetwork(one.network.curves, one.network.nodes))
            seconds = time.process_time() - start
            missing, more = one.compare(found.cycles)
            if args.each and (missing or more):
                print(f"{one.name}: {missing} missing, {more} too many")
            exact = not missing and not more
            counts = (1, exact, len(one.network.cycles), missing, more, seconds)
            row = [a + b for a, b in zip(row, counts, strict=True)]
        sums = [a + b for a, b in zip(sums, row, strict=True)]
        print(f"| {family} | {' | '.join(f'{v:,}' for v in row[:5])} | {row[5]:.1f} |", flush=True)
    print(f"| all | {' | '.join(f'{v:,}' for v in sums[:5])} | {sums[5]:.1f} |")


if __name__ == "__main__":
    main()
