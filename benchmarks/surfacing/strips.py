"""Strips bent around an axis: are they surfaced, and how near to the pipe that they are cut from?

    python benchmarks/surfacing/strips.py [--angles 10] [--heights 10]

Four curves each, two arcs of radius 1 and two straight lines: angles from 90 to 330 degrees by
heights from 0.1 to 3. Nothing but the curves is given; the cycle is found. Prints Markdown for
RESULTS.md: how many strips were surfaced, how many by the method itself, and the mean, the median
and the greatest over the strips of the mean distance both ways, in thousandths of the diagonal.
"""

from __future__ import annotations

import argparse

import numpy as np

from patterndb_sketch.surfacing.methods import METHODS
from tests.support.surfacing.strips import measure_strip

ANGLES = (90.0, 330.0)
HEIGHTS = (0.1, 3.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--angles", type=int, default=10)
    parser.add_argument("--heights", type=int, default=10)
    args = parser.parse_args()
    strips = [
        (float(degrees), float(height))
        for degrees in np.linspace(*ANGLES, args.angles)
        for height in np.geomspace(*HEIGHTS, args.heights)
    ]
    print("| method | strips | surfaced | by itself | mean | median | most |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for name, method in METHODS.items():
        if method.needs_database:
            continue
        found = [measure_strip(*strip, name) for strip in strips]
        made = [one for one in found if one is not None]
        far = 1000 * np.array([one[0] for one in made])
        itself = sum(one[1] == name for one in made)
        print(
            f"| {name} | {len(strips)} | {len(made)} | {itself} | {far.mean():.2f} "
            f"| {np.median(far):.2f} | {far.max():.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
